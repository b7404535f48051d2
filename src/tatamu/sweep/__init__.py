"""Sweeps: many learned folds from one file, each in a folder, and the page and table that compare them.

The caller provides the function that learns a task. The package uses only names, options and results.
"""

from tatamu.sweep.description import SweepTask, read_sweep
from tatamu.sweep.records import SweepFolder, TaskRecord
from tatamu.sweep.run import run_sweep

__all__ = ["SweepFolder", "SweepTask", "TaskRecord", "read_sweep", "run_sweep"]
