"""Runs sweeps: many folds that one file describes are learned, and then compared on a page and in a table.

Each fold to learn is a task with its own folder. The caller provides the function that learns a task. This package only
handles the names, options and results of tasks.
"""

from tatamu.sweep.description import SweepTask, read_sweep
from tatamu.sweep.records import SweepFolder, TaskRecord
from tatamu.sweep.run import run_sweep

__all__ = ["SweepFolder", "SweepTask", "TaskRecord", "read_sweep", "run_sweep"]
