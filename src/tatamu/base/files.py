"""Reading and writing of files: validated when they are read, never left half-written, and of limited sizes [bytes].

A folder can be locked for one process at a time.
"""

from __future__ import annotations

import errno
import json
import logging
import math
import os
import shlex
import stat
import tomllib
import warnings
import zipfile
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from secrets import token_hex
from typing import IO, TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.lib import format as npy
from pydantic import BaseModel, ValidationError

from tatamu.base.errors import InputError, UnavailableError, describe

if TYPE_CHECKING:
    from filelock import AcquireReturnProxy

Model = TypeVar("Model", bound=BaseModel)

MIB = 1 << 20
MAX_TEXT = 32 * MIB
"""Maximum size of text and JSON files: three times that of a large garment's mesh."""
MAX_TOML = 2 * MIB
"""Maximum size of TOML files, which are written by people."""
MAX_NPZ = 1024 * MIB
"""Maximum memory of all arrays in a file: ten times that of a motion of the default towel over ten minutes."""
BACKSLASHES = "; in paths, write / instead of \\, or use single quotes"
"""Advice on a path in a TOML file, where a backslash begins an escape sequence."""


def check_targets(targets: Sequence[Path], sources: Sequence[Path] = ()) -> None:
    """Check, before any work is done, that output files can be written and none of them is an input file."""
    for target in targets:
        _check_name(target)
        if os.path.exists(target) and any(os.path.exists(source) and target.samefile(source) for source in sources):
            raise InputError(f"{target}: must differ from the input files; choose another name for the output")


def _check_name(path: Path) -> None:
    """Refuse the name of a folder, and that of a pipe or a device, which a new file would replace.

    Names in /dev may lead to regular files, such as /dev/stdout, but are not files themselves.
    """
    # unlike methods of Path, no error for an impossible name; writing reports it
    other = os.path.exists(path) and not os.path.isfile(path)
    if other or not path.name or os.path.realpath(path.parent) == "/dev":
        kind = "a folder" if os.path.isdir(path) else "a pipe or a device"
        raise InputError(f"{path}: must be the name of a file to write, given {kind}")


def in_shell(path: Path | str) -> str:
    """Return a path as it is written on a command line; one that begins with a dash is not taken for an option."""
    return shlex.quote(f"./{path}" if str(path).startswith("-") else str(path))


def sibling(path: Path) -> Path:
    """Return a hidden path in the folder of `path`. Its name cannot be guessed, so nobody can plant a link there."""
    return path.with_name(f".tatamu-{token_hex(8)}.tmp")


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield a temporary file that takes the place of `path` if the `with` statement succeeds."""
    _check_name(path)
    temporary = sibling(path)
    try:
        with writing(path):
            path.parent.mkdir(parents=True, exist_ok=True)
            os.close(os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))  # mkstemp would ignore the umask
            yield temporary
            with temporary.open("rb+") as file:
                os.fsync(file.fileno())
            os.replace(temporary, path)
    finally:
        with suppress(OSError):  # if nothing could be written, there is no file to remove
            temporary.unlink()


def unwritable(path: Path, error: OSError) -> InputError:
    """Return the error for a file or folder that cannot be written. It is an `UnavailableError` if the disk is full."""
    full = error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)  # or the disk cannot be written at all
    kind = UnavailableError if full else InputError
    return kind(f"{path}: cannot be written ({error.strerror or error})")


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Guard a `with` statement that writes a file or a folder: an error of the system names the path."""
    try:
        yield
    except OSError as error:
        raise unwritable(path, error) from None


def write_text(path: Path, text: str) -> None:
    """Write a text file completely or not at all."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def write_bytes(path: Path, data: bytes) -> None:
    """Write a file completely or not at all."""
    with replacing(path) as temporary:
        temporary.write_bytes(data)


def write_json(path: Path, value: Any) -> None:
    """Write JSON completely or not at all. NaN is refused, because other languages cannot read it."""
    write_text(path, json.dumps(value, indent=1, allow_nan=False) + "\n")


def write_npz(path: Path, arrays: Mapping[str, np.ndarray]) -> None:
    """Write a compressed .npz file without pickles, completely or not at all."""
    with replacing(path) as temporary, zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as entry:
                npy.write_array(entry, np.asanyarray(array), allow_pickle=False)


def beside(file: Path, name: str) -> Path:
    """Return the path of another file that a file names, relative to its folder; it may be written as on Windows.

    Raises:
        InputError: If the name has control characters and no such file exists.
    """
    found, windows = file.parent / name, file.parent / name.replace("\\", "/")
    if os.path.exists(found):
        return found
    if set(name) & set("\a\b\t\n\v\f\r\x1b"):  # "C:\temp" in TOML has a tab
        raise InputError(f"{file}: {name!r} must be an existing file{BACKSLASHES}")
    return windows if os.path.exists(windows) else found


@contextmanager
def opened(path: Path, largest: int) -> Iterator[IO[bytes]]:
    """Yield an open regular file. Pipes and devices are refused because their size is not known.

    Raises:
        InputError: If the file cannot be read, is not a regular file, or is too large.
    """
    try:
        state = os.stat(path)
        if not stat.S_ISREG(state.st_mode):
            kind = "a folder" if stat.S_ISDIR(state.st_mode) else "a pipe or a device"
            raise InputError(f"{path}: must be a regular file, given {kind}")
        if state.st_size > largest:
            raise InputError(f"{path}: must be at most {largest / MIB:.0f} MiB, given {state.st_size / MIB:.1f} MiB")
        with open(path, "rb") as file:
            yield file
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from None
    except ValueError as error:  # the name contains a null character
        raise InputError(f"{str(path)!r}: cannot be read ({error})") from None


def read_bytes(path: Path, largest: int = MAX_TEXT) -> bytes:
    """Read a regular file."""
    with opened(path, largest) as file:
        data = file.read(largest + 1)  # some files of the system report no size
    if len(data) > largest:
        raise InputError(f"{path}: must be at most {largest / MIB:.0f} MiB")
    return data


def read_text(path: Path, largest: int = MAX_TEXT) -> str:
    """Read a UTF-8 text file. Errors give the reason in one line."""
    try:
        return read_bytes(path, largest).decode("utf-8-sig")  # some editors put a byte order mark at the start
    except UnicodeDecodeError:
        raise InputError(f"{path}: must be a UTF-8 text file, given a binary file or another encoding") from None


@contextmanager
def foreign(path: Path, what: str) -> Iterator[None]:
    """Guard a `with` statement in which a library reads a file: any error becomes one line, and output is suppressed.

    `what` is the expected kind of file for the message, such as "a DXF file".
    """
    before = logging.root.manager.disable
    logging.disable()
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            yield
    except InputError:
        raise
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from None
    except Exception as error:  # each library has its own errors, and damaged files can cause any other error
        raise InputError(f"{path}: is not {what} ({str(error) or type(error).__name__})") from None
    finally:
        logging.disable(before)


def read_json(path: Path) -> Any:
    """Read a JSON file. Errors name the line or field."""
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
        counts = Counter(name for name, _ in pairs)
        twice = next(name for name, count in counts.items() if count > 1)
        raise InputError(f"{twice}: must not occur twice in the same object")
    return fields


def read_toml(path: Path) -> Any:
    """Read a TOML file. Errors name the line or field."""
    text = read_text(path, MAX_TOML)
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        advice = BACKSLASHES if "Unescaped" in str(error) or "hex" in str(error) else ""
        raise InputError(f"{path}: is not valid TOML ({error}){advice}") from None


def read_npz(path: Path, what: str = "an .npz file of numbers", largest: int = MAX_NPZ) -> dict[str, np.ndarray]:
    """Read the arrays of an .npz file, which are numbers or single texts.

    A small file may unpack to gigabytes, so the sizes in all headers are added before any array is read. `what` is the
    expected kind of file for the message.
    """
    with opened(path, largest) as file, foreign(path, what), zipfile.ZipFile(file) as archive:
        names = [name for name in archive.namelist() if name.endswith(".npy")]
        total = 0
        for name in names:
            with archive.open(name) as member:
                total += _size(member, archive.getinfo(name).file_size, name)
            if total > largest:
                raise InputError(f"{path}: must contain arrays of at most {largest / MIB:.0f} MiB in total")
        arrays = {}
        for name in names:
            with archive.open(name) as member:
                arrays[name.removesuffix(".npy")] = np.asarray(npy.read_array(member, allow_pickle=False))
        return arrays


def _size(member: IO[bytes], unpacked: int, name: str) -> int:
    """Return the size of an array [bytes] by its header; raise ValueError for other arrays than numbers or a text."""
    version = npy.read_magic(member)
    if version not in ((1, 0), (2, 0)):
        raise ValueError(f"{name} must be in .npy format 1.0 or 2.0, given {version[0]}.{version[1]}")
    read = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
    shape, _, dtype = read(member)
    numbers = "fiub"  # numpy's letters for floating point numbers, integers and booleans
    if dtype.kind not in numbers and not (dtype.kind == "U" and shape == ()):
        raise ValueError(f"{name} must contain numbers, given {dtype}")
    size = dtype.itemsize * math.prod(shape)
    if min(shape, default=0) < 0 or member.tell() + size != unpacked:
        raise ValueError(f"{name} does not have the size that its header states")
    return size


def validated(model: type[Model], value: Any, source: Path | str) -> Model:
    """Return plain data as a record. The error for the first wrong field names the source."""
    try:
        return model.model_validate(value)
    except ValidationError as error:
        raise InputError(f"{source}: {describe(error, model)}") from None
    except InputError as error:  # raised by a record that checks itself
        raise InputError(f"{source}: {error}") from None


def read_record(model: type[Model], table: str, path: Path) -> Model:
    """Read a record from a TOML file with a single table. Errors name the file and the field."""
    value = read_toml(path)
    if list(value) != [table]:
        raise InputError(
            f"{path}: must contain the table [{table}] and nothing else, given {', '.join(map(str, value)) or 'none'}"
        )
    return validated(model, value[table], path)


def lock_folder(path: Path, name: str, busy: str) -> AcquireReturnProxy:
    """Make a folder and lock it until the end of a `with` statement, or of the process.

    `busy` says what the process with the lock does, such as "another sweep is running here".

    Raises:
        InputError: If another process has the lock, or the folder cannot be written.
    """
    from filelock import FileLock, Timeout

    try:
        path.mkdir(parents=True, exist_ok=True)
        return FileLock(path / name).acquire(timeout=0)
    except Timeout:
        raise InputError(f"{path}: {busy}") from None
    except OSError as error:
        raise unwritable(path, error) from None
