"""Makes datasets of folds from which robot policies learn.

    specification ──▶ draw ──▶ episode ──▶ part of the folder ──▶ LeRobot and Zarr, table, page

An episode depends only on the specification and on its index, so any process can record any episode.
"""

from tatamu.policies.dataset.folder import DatasetFolder
from tatamu.policies.dataset.make import make_dataset
from tatamu.policies.dataset.record import EpisodeRecord
from tatamu.policies.dataset.rerun import Replay, replay
from tatamu.policies.dataset.specification import DatasetSpecification, read_specification

__all__ = [
    "DatasetFolder",
    "DatasetSpecification",
    "EpisodeRecord",
    "Replay",
    "make_dataset",
    "read_specification",
    "replay",
]
