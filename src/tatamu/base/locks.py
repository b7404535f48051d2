"""Locks of folders, each for one process at a time."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from tatamu.base.errors import InputError
from tatamu.base.files import unwritable

if TYPE_CHECKING:
    from filelock import AcquireReturnProxy


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
