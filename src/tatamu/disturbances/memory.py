"""Simulations that are kept, so that what was interrupted goes on, and nothing is asked twice."""

from __future__ import annotations

import json
from hashlib import sha256
from math import isfinite
from pathlib import Path

from tatamu.disturbances.verdict import Verdict
from tatamu.disturbances.world import World
from tatamu.files import read_text, unwritable


class Memory:
    """Verdicts by subject and world, one line each in a file."""

    def __init__(self, path: Path | None = None) -> None:
        """Read what is there, and make the folder; a line that was cut off is passed over.

        Args:
            path: The file; None: nothing outlives the process.

        Raises:
            InputError: The file cannot be read, or its folder not be made.
        """
        self._path = path
        self._known: dict[str, Verdict] = {}
        lines = read_text(path).splitlines() if path is not None and path.exists() else []
        for line in lines:
            try:
                value = json.loads(line)
                key = value.pop("key")
                self._known[key] = _verdict(**value)
            except (ValueError, TypeError, KeyError, AttributeError, RecursionError, OverflowError):
                continue
        if path is not None:
            try:
                path.parent.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise unwritable(path.parent, error) from None
        self.fresh = 0
        """How many were added."""

    @staticmethod
    def key(subject: str, world: World) -> str:
        """The name of a simulation."""
        values = sorted((name, value.hex()) for name, value in world.values.items() if value)
        return sha256(json.dumps([subject, values]).encode()).hexdigest()[:24]

    def get(self, key: str) -> Verdict | None:
        """The verdict of a simulation; None where it was not made."""
        return self._known.get(key)

    def keep(self, key: str, verdict: Verdict) -> None:
        """Keep a verdict at once.

        Raises:
            InputError: The file cannot be written.
        """
        self._known[key] = verdict
        self.fresh += 1
        if self._path is None:
            return
        try:
            with self._path.open("a") as file:
                start = "" if _ends_well(self._path) else "\n"
                file.write(start + json.dumps({"key": key, **verdict.as_dict()}) + "\n")
        except OSError as error:
            raise unwritable(self._path, error) from None


def _verdict(mean_vertex_distance: float | None, mask_iou: float | None, error: str | None = None) -> Verdict:
    """The verdict of a line.

    Raises:
        TypeError: One of the values is of another type.
    """
    numbers = all(isinstance(each, float | int | None) for each in (mean_vertex_distance, mask_iou))
    if not numbers or not isinstance(error, str | None):
        raise TypeError("not a verdict")
    if any(each is not None and not isfinite(each) for each in (mean_vertex_distance, mask_iou)):
        raise ValueError("not a verdict")
    return Verdict(mean_vertex_distance, mask_iou, error)


def _ends_well(path: Path) -> bool:
    """Whether a file ends with a whole line."""
    with path.open("rb") as file:
        file.seek(0, 2)
        if not file.tell():
            return True
        file.seek(-1, 2)
        return file.read(1) == b"\n"
