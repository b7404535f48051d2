"""Sweeps: many learned folds from one file, a folder each, and what compares them.

How a task is learned comes from the caller; a sweep knows names, options and results.
"""

from tatamu.sweep.description import SweepTask, read_sweep
from tatamu.sweep.records import SweepFolder, TaskRecord
from tatamu.sweep.run import run_sweep

__all__ = ["SweepFolder", "SweepTask", "TaskRecord", "read_sweep", "run_sweep"]
