"""Writes the tasks of a sweep as rows of the file `sweep.parquet` and of the table on the terminal."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.table import Table

from tatamu.base.extras import require
from tatamu.base.files import replacing
from tatamu.sweep.records import TaskRecord

MEASURES = [name for name in TaskRecord.model_fields if name not in ("name", "options", "state", "error")]
"""Fields of a task's record that are numbers."""


def check_parquet() -> None:
    """Refuse to start a sweep if `sweep.parquet` cannot be written.

    Raises:
        InputError: If pyarrow is not installed.
    """
    require("pyarrow", "cluster", "sweep.parquet")


def write_parquet(records: Sequence[TaskRecord], path: Path) -> None:
    """Write a table with a row for each task.

    The columns are the name, the state, the options as `option.NAME`, and the measures in SI units.
    """
    import pyarrow
    import pyarrow.parquet

    columns: dict[str, Any] = {}
    for name in ("name", "state", "error"):
        columns[name] = pyarrow.array([getattr(record, name) for record in records], pyarrow.string())
    for name in option_names(records):
        columns[f"option.{name}"] = pyarrow.array(_plain([record.options.get(name) for record in records]))
    for name in MEASURES:
        whole = name in ("trials", "failed_trials", "crossings")
        kind = pyarrow.int64() if whole else pyarrow.float64()
        columns[name] = pyarrow.array([getattr(record, name) for record in records], kind)
    with replacing(path) as temporary:
        pyarrow.parquet.write_table(pyarrow.table(columns), temporary)


def option_names(records: Sequence[TaskRecord]) -> list[str]:
    """Return the names of all options that at least one task has, in the order of their first use."""
    return list(dict.fromkeys(name for record in records for name in record.options))


def varied(records: Sequence[TaskRecord]) -> list[str]:
    """Return the names of the options whose values differ between tasks."""
    names = option_names(records)
    return [name for name in names if len({json.dumps(record.options.get(name)) for record in records}) > 1]


def _plain(values: list[Any]) -> list[Any]:
    """Return the values of a column, converted to a single type.

    If the types of the values differ, all values are converted to text.
    """
    kinds = {type(value) for value in values if value is not None}
    if len(kinds) <= 1 or kinds == {int, float}:
        return [float(value) if kinds == {int, float} and value is not None else value for value in values]
    return [None if value is None else str(value) for value in values]


def counts(records: Sequence[TaskRecord]) -> str:
    """Return the number of tasks in each state, as text."""
    found = Counter(record.state for record in records)
    words = [f"{found[state]} {state}" for state in ("complete", "running", "waiting", "failed") if found[state]]
    return f"{len(records)} tasks: {', '.join(words)}"


class LiveTable:
    """The table of a running sweep's tasks on the terminal.

    Running tasks come first, and then the tasks that ended last.
    """

    def __init__(self, records: Sequence[TaskRecord]) -> None:
        self._records = {record.name: record for record in records}
        self._progress: dict[str, str] = {}
        self._latest: list[str] = []

    def update(self, record: TaskRecord, progress: str | None) -> None:
        """Store the changed record of a task, or the text of its progress."""
        if self._records.get(record.name, record).state != record.state or record.name not in self._latest:
            self._latest = [record.name, *(name for name in self._latest if name != record.name)]
        self._records[record.name] = record
        if progress is not None:
            self._progress[record.name] = progress

    def __rich__(self) -> Table:
        """Return the table in its current state."""
        out = Table(title=counts(list(self._records.values())), title_justify="left")
        for name in ("task", "state", "progress"):
            out.add_column(name, overflow="fold")
        recent = [self._records[name] for name in self._latest]
        ordered = sorted(recent, key=lambda record: record.state != "running")
        for record in ordered[:24]:
            out.add_row(record.name, record.state, said(record) or self._progress.get(record.name, ""))
        return out


def said(record: TaskRecord) -> str:
    """Return a few words on how a task ended; empty if the task has not ended."""
    if record.state == "failed":
        return record.error or "failed"
    if record.state != "complete":
        return ""
    distance = "no fold" if record.mean_vertex_distance is None else f"{1e3 * record.mean_vertex_distance:.1f} mm"
    objective = "" if record.objective is None else f", C = {record.objective:.4f}"
    return f"{distance} from the target{objective}"
