"""Evaluators: functions from the parameters of a manipulation to how good the fold is, and wrappers of them.

A world is one random draw of the disturbances. The nominal world has no disturbances. To race a trial is to stop it as
soon as it cannot beat the best one.
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
