"""Evaluators, and wrappers that modify them. An evaluator rates the fold that a manipulation's parameters produce.

A world is one random draw of all disturbances. The nominal world has no disturbances. To race a trial is to stop it as
soon as it cannot beat the best trial so far.
"""

from tatamu.evaluation.coarse import CoarseFirst, CoarseMesh, coarser_task, ends_early, on_coarser_mesh
from tatamu.evaluation.disturbed import Disturbed
from tatamu.evaluation.evaluator import NOTHING, Evaluation, Evaluator, Incumbent, Wrapper
from tatamu.evaluation.nominal import Nominal
from tatamu.evaluation.reach import WithinReach

__all__ = [
    "NOTHING",
    "CoarseFirst",
    "CoarseMesh",
    "Disturbed",
    "Evaluation",
    "Evaluator",
    "Incumbent",
    "Nominal",
    "WithinReach",
    "Wrapper",
    "coarser_task",
    "ends_early",
    "on_coarser_mesh",
]
