"""Optional packages, and the extras that install them; an error names the extra that is missing."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from tatamu.errors import InputError

EXTRAS = {
    "learn": (
        *("jinja2", "markupsafe", "plotly", "PIL"),
        *("shapely", "trimesh", "svgelements", "ezdxf"),
        *("optuna", "cmaes", "sqlalchemy", "filelock", "tomli_w", "threadpoolctl"),
    ),
    "mujoco": ("mujoco",),
    "photo": ("skimage", "cv2"),
    "gym": ("gymnasium",),
    "dataset": ("av", "zarr"),
    "cluster": ("distributed", "dask", "cloudpickle", "psycopg", "pyarrow"),
}
"""Modules by the extra that installs them; "report" and "garments" are parts of "learn"."""


def missing(error: ModuleNotFoundError) -> InputError | None:
    """Return the error of a user who lacks an extra; None if the missing module belongs to none.

    Args:
        error: The error of an import.
    """
    module = (error.name or "").partition(".")[0]
    return next((_lacking(module, extra) for extra, modules in EXTRAS.items() if module in modules), None)


def needed(module: str, extra: str) -> Any:
    """Import an optional package.

    Args:
        module: Name of the module.
        extra: The extra that installs it for this use; several may.

    Raises:
        InputError: If it is not installed; the message says how to install it.
    """
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        raise _lacking((error.name or module).partition(".")[0], extra) from None


def _lacking(module: str, extra: str) -> InputError:
    return InputError(f"this needs the package {module}, which is not installed: pip install 'tatamu[{extra}]'")
