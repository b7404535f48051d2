"""Optional packages of `tatamu.robots`. If a package is missing, one line reports it with the command to install it."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial

from tatamu.base import extras

needed = partial(extras.needed, extra="robot")
"""Function that imports a package. The extra `robot` installs the package."""


@contextmanager
def quiet() -> Iterator[None]:
    """Suppress MuJoCo's warnings on standard error, and Python's warnings."""
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
    """Return in one line the message of an error that another package raised."""
    return " ".join(str(error).split())
