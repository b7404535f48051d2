"""Locks for folders. Only one process at a time can have the lock of a folder."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from tatamu.base.errors import InputError
from tatamu.base.files import unwritable

if TYPE_CHECKING:
    from filelock import AcquireReturnProxy


def lock_folder(path: Path, name: str, busy: str) -> AcquireReturnProxy:
    """Make a folder and lock it.

    If the result is used in a `with` statement, the lock ends with the statement. At the latest, the lock ends with the
    process.

    Args:
        path: Path of the folder.
        name: Name of the lock file in the folder.
        busy: Text of the error message that tells what the process with the lock is doing, such as "another sweep is
            running here".

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
