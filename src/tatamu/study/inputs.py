"""Copies of the user's files that a fold was learned from, in its folder: garment, plan, material, robot.

The folder can therefore be moved, and the original files can be changed, without any loss.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from tatamu.errors import InputError
from tatamu.files import MIB, read_bytes, read_json, replacing, write_json, write_text

INPUTS = "inputs"
INDEX = "files.json"
"""The file that names the copy of each kind."""
LARGEST_INPUT = 256 * MIB
"""Largest size of a copied file [bytes]; meshes of a robot's links may be large."""


@dataclass(frozen=True)
class Sources:
    """The files of one input, or its text if it has no file. The first file names the others."""

    files: Sequence[Path] = ()
    text: str = ""
    name: str = field(default="", kw_only=True)
    """File name of the text."""


def keep_inputs(folder: Path, sources: Mapping[str, Sources]) -> None:
    """Copy the sources of a learned fold into its folder, each kind to `inputs/KIND`.

    Files keep their places relative to one another, so relative paths in them remain valid.

    Raises:
        InputError: If a source cannot be read, or the folder cannot be written.
    """
    kept = {kind: _keep(folder / INPUTS / kind, source) for kind, source in sources.items()}
    if kept:
        write_json(folder / INPUTS / INDEX, {kind: f"{kind}/{place}" for kind, place in kept.items()})


def _keep(folder: Path, source: Sources) -> str:
    """Copy one input, and return the place of its first file in the folder."""
    if not source.files:
        write_text(folder / source.name, source.text)
        return source.name
    paths = [Path(os.path.abspath(path)) for path in source.files]
    base = os.path.commonpath([path.parent for path in paths])
    places = [path.relative_to(base) for path in paths]
    for path, place in zip(paths, places, strict=True):
        with replacing(folder / place) as temporary:
            temporary.write_bytes(read_bytes(path, LARGEST_INPUT))
    return places[0].as_posix()


def kept_input(folder: Path, kind: str) -> Path | None:
    """Return the copy of an input of a learned fold or of its plan; None if none was kept.

    Raises:
        InputError: If the index of the copies is invalid.
    """
    for place in (folder, Path(os.path.abspath(folder)).parent):
        index = place / INPUTS / INDEX
        if index.exists():
            named = read_json(index)
            if not isinstance(named, dict) or not isinstance(named.get(kind, ""), str):
                raise InputError(f"{index}: must name a file for each kind, given {json.dumps(named)[:60]}")
            return place / INPUTS / named[kind] if kind in named else None
    return None
