"""Robustness: simulations that show under which disturbances a fold still succeeds, on one mesh or on two meshes.

A world is one random draw of all disturbances. The nominal world has no disturbances. A verdict is the result of one
fold in one world.
"""

from tatamu.evaluation.robustness.cache import VerdictCache
from tatamu.evaluation.robustness.judge import Judge, Judged, Progress, WorldSearch, simulate_missing
from tatamu.evaluation.robustness.meshes import FoldOnMesh, MeshVerdict
from tatamu.evaluation.robustness.record import (
    AloneMargin,
    MarginsResult,
    MeshUsed,
    Spread,
    SuccessRate,
    distances_of,
    failures_of,
)
from tatamu.evaluation.robustness.verdict import Verdict

__all__ = [
    "AloneMargin",
    "FoldOnMesh",
    "Judge",
    "Judged",
    "MarginsResult",
    "MeshUsed",
    "MeshVerdict",
    "Progress",
    "Spread",
    "SuccessRate",
    "Verdict",
    "VerdictCache",
    "WorldSearch",
    "distances_of",
    "failures_of",
    "simulate_missing",
]
