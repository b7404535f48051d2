"""Locks that keep a folder to one process."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from tatamu.errors import InputError
from tatamu.files import unwritable

if TYPE_CHECKING:
    from filelock import AcquireReturnProxy


def lock_folder(path: Path, name: str, busy: str) -> AcquireReturnProxy:
    """Make a folder and lock it; as a context the lock ends with the block, and always with the process.

    Args:
        path: The folder.
        name: Name of the lock's file in it.
        busy: What another process that has the lock is doing, such as "another sweep is running here".

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
