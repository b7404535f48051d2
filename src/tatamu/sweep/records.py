"""The tasks of a sweep, its folder, and the file `sweep.json`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from tatamu.base.errors import InputError
from tatamu.base.files import write_json
from tatamu.base.records import OpenRecord
from tatamu.base.version import __version__
from tatamu.study.folder import ResultFolder
from tatamu.study.record import PlanRecord, ResultRecord

NAME = r"^[A-Za-z0-9][\w.-]{0,99}$"
"""Names that a task's folder may have."""
OF_BOTH = ("mean_vertex_distance", "mask_iou", "area_error")
"""Measures of single folds and of plans."""
State = Literal["waiting", "running", "complete", "failed"]


class TaskRecord(OpenRecord):
    """A task of a sweep, with the measures of its best trial, or of the last fold of a plan."""

    name: Annotated[str, Field(pattern=NAME)]
    """Name of the task's folder."""
    options: dict[str, Any]
    state: State = "waiting"
    error: str | None = None
    """None if the task did not fail."""
    trials: int | None = None
    """Number of trials of all folds."""
    failed_trials: int | None = None
    objective: float | None = None
    """Objective C, Eq. (10); None for a plan of several steps."""
    trajectory_length: float | None = None
    """l_x [m]."""
    mean_vertex_distance: float | None = None
    """[m]."""
    mask_iou: float | None = None
    area_error: float | None = None
    """Area error E_f [%]."""
    crossings: int | None = None
    """Number of edges that pass through triangles after the fold."""
    seconds: float | None = None
    """Sum of the wall times of all trials [s]."""


class SweepRecord(OpenRecord):
    """The contents of `sweep.json`."""

    version: Literal[1] = 1
    tatamu: str = ""
    tasks: list[TaskRecord] = Field(default_factory=list)


class SweepFolder:
    """The folder of a sweep.

    Attributes:
        path: The folder.
        file: The record of the sweep.
        table_file: A row for each task.
        page_file: The page of the sweep.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.file = path / "sweep.json"
        self.table_file = path / "sweep.parquet"
        self.page_file = path / "sweep.html"

    def of_task(self, name: str) -> Path:
        """Return the result folder of a task."""
        return self.path / name

    def read(self) -> list[TaskRecord]:
        """Return the records of an earlier run; empty if there was none.

        Raises:
            InputError: If the file cannot be read, or is not the file of a sweep.
        """
        if not self.file.exists():
            return []
        return SweepRecord.load(self.file).tasks

    def write(self, records: Sequence[TaskRecord]) -> None:
        """Write `sweep.json`."""
        write_json(self.file, SweepRecord(tatamu=__version__, tasks=list(records)).model_dump())


def completed(record: TaskRecord, folder: Path) -> TaskRecord:
    """Return the record of a completed task with the measures in its folder.

    Raises:
        InputError: If the folder cannot be read.
    """
    results = ResultFolder(folder)
    measures = _of_plan(results.plan_record) if results.holds_plan else _of_fold(results.record)
    return record.model_copy(update={"state": "complete", "error": None, **measures})


def holds_task(record: TaskRecord, folder: Path, trials: int) -> bool:
    """Return whether a task is complete, with its folder and `trials` trials for each step."""
    results = ResultFolder(folder)
    if record.state != "complete" or not (folder / "report.html").exists():
        return False
    try:
        steps = results.plan_record.steps if results.holds_plan else [results.record]
        counts = [step.trials if isinstance(step.trials, int) else len(step.trials) for step in steps]
    except InputError:
        return False
    return all(count == trials for count in counts)


def _of_fold(result: ResultRecord) -> dict[str, Any]:
    best = result.best_score
    return {
        **{name: getattr(best, name) for name in ("objective", "trajectory_length", *OF_BOTH)},
        "trials": len(result.trials),
        "failed_trials": sum(trial.state == "failed" for trial in result.trials),
        "crossings": result.crossings.final if result.crossings else None,
        "seconds": result.wall_seconds,
    }


def _of_plan(result: PlanRecord) -> dict[str, Any]:
    return {
        **{name: getattr(result.final, name) for name in OF_BOTH},
        "trials": sum(step.trials for step in result.steps),
        "crossings": result.steps[-1].crossings.final,
        "seconds": result.wall_seconds,
    }
