"""The errors that tatamu raises on purpose, as a tree.

TatamuError
├── InputError              a file, an option or a scene is wrong; the command line exits with 2
│   └── UnavailableError    a scheduler, a database or a disk does not answer; what was finished is kept
└── SimulationError         a rollout passed a limit of its model (stretch, speed, not finite)
    ├── SceneError          the scene itself is the cause; an InputError, too
    └── WorkerKilledError   a computation that killed its processes repeatedly
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pydantic import ValidationError

LONGEST = 1500
"""Texts of more characters are shortened in the middle: the file at the start and the advice at the end stay."""


def one_line(text: str) -> str:
    r"""Return a text as one line that any terminal can show.

    Texts quote files, which may be broken or hostile. Control characters, invisible characters and those that reverse
    the direction of writing are therefore escaped as in Python, such as `\x1b`.
    """
    line = " ".join(text.split())
    if len(line) > LONGEST:
        line = f"{line[: LONGEST // 2]} .. {line[-LONGEST // 2 :]}"
    return "".join(each if each.isprintable() else each.encode("unicode_escape").decode() for each in line)


class TatamuError(Exception):
    """Base of every error that tatamu raises on purpose; its text is one line that a person can act on."""

    def __str__(self) -> str:
        """Return the text as one line, without control characters."""
        return one_line(super().__str__())


class InputError(TatamuError):
    """A given file, option or value is wrong; the text has the value given, the values allowed and advice."""


class UnavailableError(InputError):
    """A scheduler, a database or a disk that the run needs does not answer, or is full; a later run resumes."""


class SimulationError(TatamuError):
    """A rollout left the range in which its simulator is valid."""


class SceneError(InputError, SimulationError):
    """No simulation of this scene can succeed: in a study the trial failed, elsewhere the scene is a wrong input."""


class WorkerKilledError(SimulationError):
    """A computation killed its processes repeatedly, or never answered."""


def describe(error: ValidationError) -> str:
    """Return one line on the first wrong field: its place, the allowed and the given value."""
    errors = error.errors(include_url=False)
    first = errors[0]
    where = ".".join(str(part) for part in first["loc"]) or "(whole file)"
    message = first["msg"].removeprefix("Value error, ").removeprefix("Assertion failed, ")
    if first["type"] in ("model_type", "dict_type"):
        message = "must be a table (an object)"
    if first["type"] == "literal_error":
        message = f"must be {first['ctx']['expected']}".replace("'", "")
    given = "" if first["type"] in ("missing", "value_error") else f", given {_short(first['input'])}"
    more = sum(other["loc"] != first["loc"][: len(other["loc"])] for other in errors[1:])  # not what holds it
    return f"{where}: {message}{given}" + (f" (and {more} more)" if more else "")


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
