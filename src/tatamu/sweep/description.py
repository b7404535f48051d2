"""Reads a sweep file, which docs/reference/sweep-file.md describes."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from hashlib import sha256
from itertools import product
from math import prod
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field

from tatamu.base.errors import InputError
from tatamu.base.files import read_toml, validated
from tatamu.base.records import Record
from tatamu.sweep.records import NAME

MAX_TASKS = 100_000
"""Largest number of tasks in a sweep."""
GROWING = frozenset({"trials"})
"""Options that may change while a task stays the same and goes on."""

Options = dict[str, Any]


class SweepFile(Record):
    """The contents of a sweep file. Options have the long names of those of `tatamu learn`."""

    version: Literal[1] = 1
    all: Options = Field(default_factory=dict)
    grid: dict[str, Annotated[list[Any], Field(min_length=1)]] = Field(default_factory=dict)
    """Values of options, of which every combination is a task."""
    task: list[Options] = Field(default_factory=list)
    """Options of single tasks, and their `name`."""


@dataclass(frozen=True)
class SweepTask:
    """A study of a sweep."""

    name: str
    """Name of the task's folder, which ends with a digest of its options if none is given."""
    options: Options


def read_sweep(path: Path, model: type[BaseModel]) -> list[SweepTask]:
    """Read a sweep file, whose tasks have the options of `model`.

    Raises:
        InputError: If the file cannot be read, or a field is wrong.
    """
    file = validated(SweepFile, read_toml(path), path)
    count = prod(len(values) for values in file.grid.values()) if file.grid else 0
    if not 1 <= count + len(file.task) <= MAX_TASKS:
        raise InputError(
            f"{path}: must describe 1 to {MAX_TASKS} tasks, in [grid] or as [[task]], given {count + len(file.task)}"
        )
    tasks = [_task(path, where, options, model) for where, options in _all_options(file)]
    seen: dict[str, str] = {}
    for (where, _), task in zip(_all_options(file), tasks, strict=True):
        if task.name in seen:
            raise InputError(
                f"{path}: {where} has the same name as {seen[task.name]}; give each task a name of its own"
            )
        seen[task.name] = where
    return tasks


def _all_options(file: SweepFile) -> Iterator[tuple[str, Options]]:
    """Yield the place of each task in the file, such as "grid[3]", and its options."""
    for number, values in enumerate(product(*file.grid.values()) if file.grid else ()):
        yield f"grid[{number}]", {**file.all, **dict(zip(file.grid, values, strict=True))}
    for number, options in enumerate(file.task):
        yield f"task[{number}]", {**file.all, **options}


def _task(path: Path, where: str, options: Options, model: type[BaseModel]) -> SweepTask:
    own = dict(options)
    name = own.pop("name", None)
    if name is not None and not (isinstance(name, str) and re.fullmatch(NAME, name)):
        raise InputError(
            f"{path}: {where}.name: must be 1 to 100 letters, digits, '.', '_' or '-', and begin with a letter or "
            f"digit, given {str(name)[:60]!r}"
        )
    made = validated(model, own, f"{path}: {where}")
    given = made.model_dump(mode="json", exclude_unset=True)
    return SweepTask(name or _name(made, given), given)


def _name(made: BaseModel, given: Options) -> str:
    """Return a name: garment, fold, seed, and a digest of the options."""
    kept = {name: value for name, value in sorted(given.items()) if name not in GROWING}
    digest = sha256(json.dumps(kept, sort_keys=True).encode()).hexdigest()[:6]
    words = [Path(str(getattr(made, name, ""))).stem for name in ("garment", "fold")]
    plain = [re.sub(r"[^A-Za-z0-9_]+", "-", word).strip("-")[:30] for word in words]
    return "-".join([*filter(None, plain), f"seed-{getattr(made, 'seed', 0)}", digest])
