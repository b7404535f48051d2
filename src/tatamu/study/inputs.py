"""Copies of the files from which a fold was learned, in the folder of its result.

With them, the folder can be moved, and the original files can be changed.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import tomli_w

from tatamu.base.errors import InputError
from tatamu.base.files import MIB, read_bytes, read_json, replacing, write_json, write_text
from tatamu.evaluation.disturbances import Disturbances, default_disturbances
from tatamu.folding.task import Task
from tatamu.garments.garmentfile import files_of
from tatamu.simulation.material import is_preset

INPUTS = "inputs"
INDEX = "files.json"
"""The file with the path of the copy of each kind of input."""


@dataclass(frozen=True)
class Sources:
    """The user's files of one input, of which the first refers to the others, or the text of one without a file."""

    files: Sequence[Path] = ()
    text: str = ""
    name: str = field(default="", kw_only=True)
    """File name of the text."""


def sources_of(task: Task, disturbances: Disturbances | None) -> dict[str, Sources]:
    """Return the user's files from which a task was made, with a plan that was proposed for an own garment."""
    asked = task.asked
    if asked is None:
        return {}
    found = {}
    if task.garment.own:
        found["garment"] = Sources(files_of(Path(asked.garment)))
        found["fold"] = Sources(text=task.plan.to_toml(), name=f"{task.plan.name}.toml")
    if asked.fold.endswith(".toml"):
        found["fold"] = Sources([Path(asked.fold)])
    if asked.material and not is_preset(Path(asked.material)):
        found["material"] = Sources([Path(asked.material)])
    if task.reach and task.reach.files:
        found["robot"] = Sources(task.reach.files)
    if disturbances is not None and disturbances != default_disturbances():
        found["disturbances"] = Sources(text=tomli_w.dumps(disturbances.describe()), name="disturbances.toml")
    return found


def keep_inputs(folder: Path, sources: Mapping[str, Sources]) -> None:
    """Copy the input files of a learned fold into `inputs/KIND`, where relative paths between them remain valid."""
    kept = {kind: _keep(folder / INPUTS / kind, source) for kind, source in sources.items()}
    if kept:
        write_json(folder / INPUTS / INDEX, {kind: f"{kind}/{place}" for kind, place in kept.items()})


def _keep(folder: Path, source: Sources) -> str:
    """Copy one input into a folder, and return the path of its first file relative to this folder."""
    if not source.files:
        write_text(folder / source.name, source.text)
        return source.name
    paths = [Path(os.path.abspath(path)) for path in source.files]
    base = os.path.commonpath([path.parent for path in paths])
    places = [path.relative_to(base) for path in paths]
    for path, place in zip(paths, places, strict=True):
        with replacing(folder / place) as temporary:
            temporary.write_bytes(read_bytes(path, 256 * MIB))
    return places[0].as_posix()


def kept_input(folder: Path, kind: str) -> Path | None:
    """Return the copy of an input, in the folder of a fold or of its plan; None if there is none.

    Raises:
        InputError: If the index of the copies is invalid.
    """
    for place in (folder, Path(os.path.abspath(folder)).parent):
        index = place / INPUTS / INDEX
        if index.exists():
            named = read_json(index)
            if not isinstance(named, dict) or not isinstance(named.get(kind, ""), str):
                raise InputError(
                    f"{index}: must contain a file name for each kind of input, given {json.dumps(named)[:60]}"
                )
            if kind not in named:
                return None
            if os.path.isabs(named[kind]) or ".." in Path(named[kind]).parts:
                raise InputError(
                    f"{index}: {kind}: must be a path inside {INPUTS}, given {json.dumps(named[kind])[:60]}"
                )
            return place / INPUTS / named[kind]
    return None
