"""The errors that tatamu raises on purpose.

TatamuError
├── InputError              a file, an option or a scene is wrong; the command line exits with the code 2
│   └── UnavailableError    a scheduler, a database or a disk does not answer; finished work is kept
└── SimulationError         a simulation failed: the cloth stretched too far, was too fast, or was not finite
    ├── SceneError          no simulation of this scene can succeed; this class is also an InputError
    └── WorkerKilledError   a computation killed its processes repeatedly
"""

from __future__ import annotations

from collections.abc import Sequence
from difflib import get_close_matches
from typing import TYPE_CHECKING, Any, get_args

if TYPE_CHECKING:
    from pydantic import BaseModel, ValidationError


def one_line(text: str) -> str:
    r"""Return a text as one line that any terminal can show.

    A text may quote a hostile file, so control characters, invisible ones, and those that reverse the direction of
    writing are escaped as in Python, for example `\x1b`.
    """
    line = " ".join(text.split())
    if len(line) > 1500:  # file name and advice remain
        line = f"{line[:750]} .. {line[-750:]}"
    return "".join(each if each.isprintable() else each.encode("unicode_escape").decode() for each in line)


class TatamuError(Exception):
    """Base of all errors that tatamu raises on purpose. The text is one line with advice for the user."""

    def __str__(self) -> str:
        return one_line(super().__str__())


class InputError(TatamuError):
    """A given file, option or value is wrong. The text contains the given value, the allowed values and advice."""


class UnavailableError(InputError):
    """A scheduler, a database or a disk that the run needs does not answer, or is full. A later run can resume."""


class SimulationError(TatamuError):
    """A simulation failed because it left the range in which the simulator is valid."""


class SceneError(InputError, SimulationError):
    """No simulation of this scene can succeed: a failed trial in a study, elsewhere a wrong scene of the user."""


class WorkerKilledError(SimulationError):
    """A computation killed its processes several times, or never answered."""


def check_range(name: str, value: int, minimum: int, maximum: int) -> None:
    """Raise an InputError that names a value outside its range."""
    if not minimum <= value <= maximum:
        raise InputError(f"{name}: must be from {minimum} to {maximum}, given {value}")


def describe(error: ValidationError, model: type[BaseModel]) -> str:
    """Return one line about the first wrong field of a record: its path, the allowed value and the given value."""
    errors = error.errors(include_url=False)
    first = errors[0]
    where = ".".join(str(part) for part in first["loc"])
    message = first["msg"].removeprefix("Value error, ").removeprefix("Assertion failed, ")
    if first["type"] in ("model_type", "dict_type"):
        message = "must be a table (an object)"
    if first["type"] == "literal_error":
        message = f"must be {first['ctx']['expected']}".replace("'", "")
    if first["type"] == "string_pattern_mismatch":
        message = f"must match {first['ctx']['pattern']}"
    given = ""
    if first["type"] not in ("missing", "value_error"):  # the text of a whole file would take long
        text = repr(first["input"])
        given = f", given {text if len(text) <= 60 else text[:57] + '...'}"
    if first["type"] == "extra_forbidden":
        close = get_close_matches(str(first["loc"][-1]), _fields_at(model, first["loc"][:-1]), 1)
        given += f"; did you mean {close[0]}?" if close else ""
    more = sum(other["loc"] != first["loc"][: len(other["loc"])] for other in errors[1:])  # without its parents
    return f"{where}: {message}{given}".removeprefix(": ") + (f" (and {more} more)" if more else "")


def _fields_at(model: Any, place: Sequence[int | str]) -> list[str]:
    """Return the names of the fields of a record, or of a record inside it; none if the place is no single record."""
    for part in place:
        annotation = model.model_fields[part].annotation if part in getattr(model, "model_fields", ()) else model
        inner = [each for each in (annotation, *get_args(annotation)) if hasattr(each, "model_fields")]
        model = inner[0] if inner else None
    return list(getattr(model, "model_fields", ()))
