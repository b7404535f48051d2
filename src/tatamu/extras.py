"""Optional packages, and the extras that install them; an error names the extra that is missing."""

from __future__ import annotations

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
"""Modules by the extra that installs them; parts of "learn" are "report" and "garments" by themselves."""


def missing(error: ModuleNotFoundError) -> InputError | None:
    """Return the error of a user who lacks an extra; None if the missing module belongs to none.

    Args:
        error: The error of an import.
    """
    module = (error.name or "").partition(".")[0]
    for extra, modules in EXTRAS.items():
        if module in modules:
            return InputError(f"this needs the package {module}, which is not installed: pip install 'tatamu[{extra}]'")
    return None
