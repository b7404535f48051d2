"""Optional packages of this folder; one that is missing is reported in one line, with how to install it."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

from tatamu.errors import InputError


def needed(module: str) -> Any:
    """Import an optional package.

    Raises:
        InputError: If it is not installed; the message has the command that installs it.
    """
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        package = (error.name or module).split(".")[0]
        raise InputError(
            f"robots need the package {package}, which is not installed: pip install 'tatamu[robot]'"
        ) from None


@contextmanager
def quiet() -> Iterator[None]:
    """Suppress MuJoCo's warnings on standard error: those that it writes itself, and those that Python shows."""
    mujoco = needed("mujoco")
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)
            yield
    finally:
        mujoco.set_mju_user_warning(before)


def one_line(error: Exception) -> str:
    """Return the text of another package's error in one line."""
    return " ".join(str(error).split())
