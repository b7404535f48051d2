"""The command `tatamu install blender`. It installs Blender as a Python module in a separate virtual environment."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

from tatamu.base.errors import InputError
from tatamu.simulation.blender.discovery import VERSION, environment_folder, python_of

PYTHON = "3.11"
"""The only version of Python for which this version of Blender is available as a wheel."""
PACKAGES = (f"bpy=={VERSION}", "numpy<2")


def install(folder: Path | None = None) -> Path:
    """Return the Python of a virtual environment that can import Blender; if it cannot, make the environment anew."""
    folder = folder or environment_folder()
    python = python_of(folder)
    if _works(python):
        return python
    shutil.rmtree(folder, ignore_errors=True)
    folder.parent.mkdir(parents=True, exist_ok=True)
    _run([_base_python(), "-m", "venv", str(folder)], "cannot make a virtual environment")
    _run([str(python), "-m", "pip", "install", "--quiet", *PACKAGES], "cannot install bpy")
    if not _works(python):
        raise InputError(f"install blender: {python} cannot import bpy; Blender's system libraries may be missing")
    return python


def _works(python: Path) -> bool:
    if not python.exists():
        return False
    return subprocess.run([str(python), "-c", "import bpy"], capture_output=True).returncode == 0


def _base_python() -> str:
    if sys.version_info[:2] == tuple(int(part) for part in PYTHON.split(".")):
        return sys.executable
    found = shutil.which(f"python{PYTHON}")
    if found is None:
        raise InputError(
            f"install blender: bpy {VERSION} needs Python {PYTHON}, which is not on the search path; install this "
            "Python, or install Blender itself (3.4 or later)"
        )
    return found


def _run(command: list[str], failure: str) -> None:
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        lines = (done.stderr or done.stdout).strip().splitlines()
        raise InputError(f"install blender: {failure} ({lines[-1] if lines else f'exit code {done.returncode}'})")
