"""Reading and writing of files: validated on reading, never half-written."""

from __future__ import annotations

import errno
import json
import os
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from pydantic import BaseModel, ValidationError

from tatamu.errors import InputError, UnavailableError

Model = TypeVar("Model", bound=BaseModel)

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
"""Errors of a disk that takes nothing more, whatever is written."""


def check_targets(targets: Sequence[Path], sources: Sequence[Path] = ()) -> None:
    """Refuse targets that cannot be written, or would overwrite a source, before any work is done.

    Raises:
        InputError: A target is a folder, or one of the sources.
    """
    for target in targets:
        if os.path.isdir(target):  # unlike Path.is_dir, False for a name that no file can have: writing says so
            raise InputError(f"{target}: cannot be written (is a folder)")
        if os.path.exists(target) and any(os.path.exists(source) and target.samefile(source) for source in sources):
            raise InputError(f"{target}: is what is read; give another name to write to")


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield a temporary name beside `path`; rename it onto `path` when the block ends well, else remove it."""
    if not path.name:
        raise InputError(f"{path}: cannot be written (is a folder)")
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield temporary
        os.replace(temporary, path)
    except OSError as error:
        raise unwritable(path, error) from None
    finally:
        with suppress(OSError):  # where nothing could be written, nothing is to be removed
            temporary.unlink()


def unwritable(path: Path, error: OSError) -> InputError:
    """The error of a file or folder that cannot be written: an `UnavailableError` where its disk is full."""
    kind = UnavailableError if error.errno in FULL else InputError
    return kind(f"{path}: cannot be written ({error.strerror or error})")


def write_text(path: Path, text: str) -> None:
    """Write a text file in one piece."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def write_json(path: Path, value: Any) -> None:
    """Write JSON in one piece; NaN is refused, as other languages cannot read it."""
    write_text(path, json.dumps(value, indent=1, allow_nan=False) + "\n")


def write_npz(path: Path, arrays: Mapping[str, np.ndarray]) -> None:
    """Write a compressed .npz without pickles, in one piece."""
    with replacing(path) as temporary, temporary.open("wb") as file:
        np.savez_compressed(file, allow_pickle=False, **arrays)


def read_text(path: Path) -> str:
    """Read a UTF-8 text file, or say in one line why it cannot be read."""
    try:
        return path.read_text(encoding="utf-8-sig")  # some editors put a mark in front
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from None
    except UnicodeDecodeError:
        raise InputError(f"{path}: is not a UTF-8 text file") from None
    except ValueError as error:
        raise InputError(f"{str(path)!r}: cannot be read ({error})") from None


def read_json(path: Path) -> Any:
    """Read JSON, or say where it stops being JSON."""
    text = read_text(path)
    try:
        return json.loads(text, object_pairs_hook=_once)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: is not valid JSON ({error})") from None


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    fields = dict(pairs)
    if len(fields) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise InputError(f"{twice}: stands twice in one object")
    return fields


def read_toml(path: Path) -> Any:
    """Read TOML, or say where it stops being TOML."""
    text = read_text(path)
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: is not valid TOML ({error})") from None


def validated(model: type[Model], value: Any, source: Path | str) -> Model:
    """Build `model` from plain data; the first wrong field becomes an InputError that names the source."""
    try:
        return model.model_validate(value)
    except ValidationError as error:
        raise InputError(f"{source}: {describe(error)}") from None


def describe(error: ValidationError) -> str:
    """One line for the first wrong field: where it is, what is allowed, what was given."""
    first = error.errors(include_url=False)[0]
    where = ".".join(str(part) for part in first["loc"]) or "(whole file)"
    message = first["msg"].removeprefix("Value error, ").removeprefix("Assertion failed, ")
    if first["type"] in ("model_type", "dict_type"):
        message = "must be a table (an object)"
    given = "" if first["type"] in ("missing", "value_error") else f", given {_short(first['input'])}"
    more = sum(other["loc"] != first["loc"][: len(other["loc"])] for other in error.errors()[1:])  # not what holds it
    return f"{where}: {message}{given}" + (f" (and {more} more)" if more else "")


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
