"""Optional packages, and the extras that install them."""

from __future__ import annotations

from importlib import import_module, util
from typing import Any

from tatamu.base.errors import InputError

EXTRAS = {
    "learn": (
        *("jinja2", "markupsafe", "plotly", "PIL"),
        *("shapely", "trimesh", "svgelements"),
        *("optuna", "cmaes", "sqlalchemy", "filelock", "tomli_w", "threadpoolctl"),
    ),
    "garments": ("ezdxf",),
    "mujoco": ("mujoco",),
    "photo": ("skimage", "cv2"),
    "gym": ("gymnasium",),
    "dataset": ("av", "zarr"),
    "cluster": ("distributed", "dask", "cloudpickle", "psycopg", "pyarrow"),
}
"""Modules that each extra installs. The extra "report" is a part of "learn"."""


def missing(error: ModuleNotFoundError) -> InputError | None:
    """Return the error for a missing module of an extra; None if the module belongs to no extra."""
    module = (error.name or "").partition(".")[0]
    return next((lacking(module, extra) for extra, modules in EXTRAS.items() if module in modules), None)


def needed(module: str, extra: str) -> Any:
    """Import an optional package for a use whose extra is given; several extras may install one package.

    Raises:
        InputError: If the package is not installed. The message says how to install it.
    """
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        raise lacking((error.name or module).partition(".")[0], extra) from None


def require(module: str, extra: str, use: str, package: str = "") -> None:
    """Raise an InputError if a module is not installed that `use` needs; `package` contains the module."""
    if util.find_spec(module) is None:
        raise lacking(package or module, extra, use)


def lacking(package: str, extra: str, use: str = "") -> InputError:
    """Return the error for a package that is not installed; `use` is what needs the package."""
    return InputError(f"{package}: must be installed{use and f' for {use}'}; run `pip install 'tatamu[{extra}]'`")
