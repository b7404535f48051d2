"""Optional packages of `tatamu.robots`; a missing package is reported in one line, with the command to install it."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial

from tatamu import extras

needed = partial(extras.needed, extra="robot")
"""Function that imports a package which the extra `robot` installs."""


@contextmanager
def quiet() -> Iterator[None]:
    """Suppress MuJoCo's warnings on standard error, its own and Python's."""
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
