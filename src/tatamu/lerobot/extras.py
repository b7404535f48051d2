"""Optional packages of this folder; one that is missing is reported in one line, with how to install it."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from tatamu.errors import InputError


def needed(module: str) -> Any:
    """Import an optional package.

    Raises:
        InputError: If it is not installed; the message says how to install it.
    """
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        package = (error.name or module).split(".")[0]
        raise InputError(
            f"datasets need the package {package}, which is not installed: pip install 'tatamu[dataset]'"
        ) from None
