"""Disturbances of hands, grasps, cloth and table: their file, random draws of them, and the disturbed scenes."""

from tatamu.evaluation.disturbances.channels import CHANNELS, Channel
from tatamu.evaluation.disturbances.description import (
    Disturbances,
    default_disturbances,
    disturbances_in,
    load_disturbances,
    read_disturbances,
    require_disturbances,
    with_calibrated,
)
from tatamu.evaluation.disturbances.disturbed import disturbed_scene, hand_errors, hand_failure
from tatamu.evaluation.disturbances.systematic import Split, join, split
from tatamu.evaluation.disturbances.world import (
    NOMINAL,
    Stream,
    World,
    deviations,
    mean_world,
    sample_worlds,
)

__all__ = [
    "CHANNELS",
    "NOMINAL",
    "Channel",
    "Disturbances",
    "Split",
    "Stream",
    "World",
    "default_disturbances",
    "deviations",
    "disturbances_in",
    "disturbed_scene",
    "hand_errors",
    "hand_failure",
    "join",
    "load_disturbances",
    "mean_world",
    "read_disturbances",
    "require_disturbances",
    "sample_worlds",
    "split",
    "with_calibrated",
]
