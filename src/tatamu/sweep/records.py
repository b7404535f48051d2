"""Records of the tasks of a sweep, and their folder: `sweep.json` and a result folder for each task."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from pydantic import Field

from tatamu.errors import InputError
from tatamu.files import read_json, validated, write_json
from tatamu.records import OpenRecord
from tatamu.study import PlanRecord, ResultFolder, ResultRecord
from tatamu.version import __version__

State = Literal["waiting", "running", "complete", "failed"]


class TaskRecord(OpenRecord):
    """A task and its state; measures of the best trial, or of a plan's last fold."""

    name: str
    """Name of the task's folder."""
    options: dict[str, Any]
    """Options as in the sweep file."""
    state: State = "waiting"
    error: str | None = None
    """Why the task failed; None if it did not."""
    trials: int | None = None
    """Number of trials, over all steps."""
    failed_trials: int | None = None
    objective: float | None = None
    """C of the best trial, Eq. (10); None for a plan of several steps."""
    trajectory_length: float | None = None
    """l_x [m]."""
    mean_vertex_distance: float | None = None
    """Mean of e_i [m]."""
    mask_iou: float | None = None
    area_error: float | None = None
    """E_f [%]."""
    crossings: int | None = None
    """Edges that pass through triangles at the end."""
    seconds: float | None = None
    """Wall time of the trials, summed [s]."""


class SweepRecord(OpenRecord):
    """The file `sweep.json`."""

    version: Literal[1] = 1
    tatamu: str = ""
    tasks: list[TaskRecord] = Field(default_factory=list)


@dataclass(frozen=True)
class SweepFolder:
    """The folder of a sweep."""

    path: Path

    @property
    def file(self) -> Path:
        """File with the records of the tasks: `sweep.json`."""
        return self.path / "sweep.json"

    @property
    def table_file(self) -> Path:
        """File with the records as a table: `sweep.parquet`."""
        return self.path / "sweep.parquet"

    @property
    def page_file(self) -> Path:
        """File of the page that compares the tasks: `sweep.html`."""
        return self.path / "sweep.html"

    def of_task(self, name: str) -> Path:
        """Return the result folder of a task."""
        return self.path / name

    def read(self) -> list[TaskRecord]:
        """Return the records that an earlier run wrote; empty if there was none.

        Raises:
            InputError: If the file cannot be read, or does not belong to a sweep.
        """
        if not self.file.exists():
            return []
        return validated(SweepRecord, read_json(self.file), self.file).tasks

    def write(self, records: Sequence[TaskRecord]) -> None:
        """Write `sweep.json`."""
        write_json(self.file, SweepRecord(tatamu=__version__, tasks=list(records)).model_dump())


def completed(record: TaskRecord, folder: Path) -> TaskRecord:
    """Return the record of a task whose folder is written.

    Raises:
        InputError: If the folder cannot be read.
    """
    results = ResultFolder(folder)
    measures = _of_plan(results.plan_record) if results.holds_plan else _of_fold(results.record)
    return record.model_copy(update={"state": "complete", "error": None, **measures})


def holds_task(record: TaskRecord, folder: Path, trials: int) -> bool:
    """Return whether a task is complete with `trials` trials for each step, and its folder still exists."""
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
    names = ("objective", "trajectory_length", "mean_vertex_distance", "mask_iou", "area_error")
    return {
        **{name: getattr(result.best_score, name) for name in names},
        "trials": len(result.trials),
        "failed_trials": sum(trial.state == "failed" for trial in result.trials),
        "crossings": result.crossings.final if result.crossings else None,
        "seconds": result.wall_seconds,
    }


def _of_plan(result: PlanRecord) -> dict[str, Any]:
    final = result.final
    return {
        "mean_vertex_distance": final.mean_vertex_distance,
        "mask_iou": final.mask_iou,
        "area_error": final.area_error,
        "trials": sum(step.trials for step in result.steps),
        "crossings": result.steps[-1].crossings.final,
        "seconds": result.wall_seconds,
    }
