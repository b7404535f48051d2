"""Disturbances: what is not known of hands, grasps, cloth and table, and worlds drawn from it.

A world turns a fold and a manipulation into a scene; it knows no simulator.
"""

from tatamu.disturbances.asking import Asker, Asking, Progress, Settled, settled
from tatamu.disturbances.description import (
    Disturbances,
    default_disturbances,
    disturbances_in,
    load_disturbances,
    read_disturbances,
    with_calibrated,
)
from tatamu.disturbances.disturbed import disturbed_scene
from tatamu.disturbances.memory import Memory
from tatamu.disturbances.meshes import FoldOnMesh, Judged, fold_on_coarser_mesh, on_own_mesh
from tatamu.disturbances.verdict import Limits, Share, Verdict, judge, share_of
from tatamu.disturbances.world import CALM, CHANNELS, Channel, Stream, World, deviations, drawn, spread

__all__ = [
    "CALM",
    "CHANNELS",
    "Asker",
    "Asking",
    "Channel",
    "Disturbances",
    "FoldOnMesh",
    "Judged",
    "Limits",
    "Memory",
    "Progress",
    "Settled",
    "Share",
    "Stream",
    "Verdict",
    "World",
    "default_disturbances",
    "deviations",
    "disturbances_in",
    "disturbed_scene",
    "drawn",
    "fold_on_coarser_mesh",
    "judge",
    "load_disturbances",
    "on_own_mesh",
    "read_disturbances",
    "settled",
    "share_of",
    "spread",
    "with_calibrated",
]
