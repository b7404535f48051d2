"""A cache of simulation results, so that an interrupted measurement resumes and no simulation runs twice.

A verdict is the result of a fold in one world. A world is one random draw of all disturbances.
"""

from __future__ import annotations

import json
from hashlib import sha256
from pathlib import Path

from pydantic import TypeAdapter, ValidationError

from tatamu.base.files import read_text, unwritable
from tatamu.evaluation.disturbances import World
from tatamu.evaluation.robustness.verdict import Verdict

_LINE = TypeAdapter(Verdict)


class VerdictCache:
    """Cache of verdicts, the results of folds under random disturbances. Its file has one line for each verdict."""

    def __init__(self, path: Path | None = None) -> None:
        """Read the file if it exists, and make its folder. An incomplete line is skipped.

        Args:
            path: Path of the file; None if verdicts are only kept in memory.

        Raises:
            InputError: If the file cannot be read, or its folder cannot be made.
        """
        self._path = path
        self._known: dict[str, Verdict] = {}
        if path is None:
            return
        for line in read_text(path).splitlines() if path.exists() else ():
            try:
                value = json.loads(line)
                key = value.pop("key")
                self._known[key] = _LINE.validate_json(json.dumps(value), strict=True)
            except (ValueError, TypeError, KeyError, AttributeError, RecursionError, OverflowError, ValidationError):
                continue
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise unwritable(path.parent, error) from None

    @staticmethod
    def key(fold: str, world: World) -> str:
        """Return the key of a simulation, made from a fold and a world (one draw of the disturbances)."""
        values = sorted((name, value.hex()) for name, value in world.values.items() if value)
        return sha256(json.dumps([fold, values]).encode()).hexdigest()[:24]

    def get(self, key: str) -> Verdict | None:
        """Return the verdict of a simulation by its key; None if the cache does not contain the verdict."""
        return self._known.get(key)

    def keep(self, key: str, verdict: Verdict) -> None:
        """Add a verdict, and write it to the file immediately.

        Raises:
            InputError: If the file cannot be written.
        """
        self._known[key] = verdict
        if self._path is None:
            return
        try:
            with self._path.open("a") as file:
                start = "" if _ends_with_line(self._path) else "\n"
                file.write(start + json.dumps({"key": key, **_LINE.dump_python(verdict)}) + "\n")
        except OSError as error:
            raise unwritable(self._path, error) from None


def _ends_with_line(path: Path) -> bool:
    """Return whether a file is empty or ends with a complete line."""
    with path.open("rb") as file:
        if not file.seek(0, 2):
            return True
        file.seek(-1, 2)
        return file.read(1) == b"\n"
