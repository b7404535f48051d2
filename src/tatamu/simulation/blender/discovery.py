"""Where Blender is: TATAMU_BLENDER, or the environment of `tatamu install blender`, or the search path.

This command installs Blender as a Python module in a separate virtual environment.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

from tatamu.base.errors import InputError

VARIABLE = "TATAMU_BLENDER"
"""Environment variable with the path of a Blender executable, or of a Python that can import `bpy`."""
PYTHON = "3.11"
"""Only version of Python for which this version of Blender is available as a wheel."""
VERSION = "5.0.1"
"""Version that `tatamu install blender` installs, with which docs/notes/simulators.md was measured."""


def environment_folder() -> Path:
    """Return the path of the virtual environment that `tatamu install blender` makes, in the user's cache."""
    if sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData" / "Local"))
    elif sys.platform == "darwin":
        base = Path.home() / "Library" / "Caches"
    else:
        base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return base / "tatamu" / f"blender-{VERSION}"


def python_of(folder: Path) -> Path:
    """Return the path of the Python interpreter in a virtual environment."""
    return folder / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")


def command() -> list[str]:
    """Return the command line that starts a worker, or raise InputError if no Blender is found."""
    named = os.environ.get(VARIABLE)
    if named:
        program = shutil.which(os.path.expanduser(named))
        if program is None:
            raise InputError(f"{VARIABLE}: must name a Blender executable or a Python that has bpy, given {named!r}")
        return started_by(program)
    installed = python_of(environment_folder())
    if installed.exists():
        return started_by(str(installed))
    found = shutil.which("blender")
    if found is None:
        raise InputError(
            f"blender: must be installed; run `tatamu install blender`, or set {VARIABLE} to a Blender "
            "executable or a Python that has bpy"
        )
    return started_by(found)


def started_by(program: str) -> list[str]:
    """Return the command line that starts a worker: by Blender, or by a Python, called `python..` or `pypy..`."""
    worker = str(Path(__file__).with_name("worker.py"))
    if Path(program).name.lower().startswith(("python", "pypy")):
        return [program, worker]
    return [program, "--background", "--factory-startup", "--python-exit-code", "3", "--python", worker]


def available() -> bool:
    """Return whether Blender is found on this machine."""
    try:
        command()
    except InputError:
        return False
    return True


def install(folder: Path | None = None) -> Path:
    """Return the Python of a virtual environment that can import Blender; if it cannot, make the environment anew."""
    folder = folder or environment_folder()
    python = python_of(folder)
    if _works(python):
        return python
    shutil.rmtree(folder, ignore_errors=True)
    folder.parent.mkdir(parents=True, exist_ok=True)
    _run([_base_python(), "-m", "venv", str(folder)], "cannot make a virtual environment")
    packages = (f"bpy=={VERSION}", "numpy<2")
    _run([str(python), "-m", "pip", "install", "--quiet", *packages], "cannot install bpy")
    if not _works(python):
        raise InputError(f"tatamu install blender: {python} cannot import bpy; install Blender's system libraries")
    return python


def _works(python: Path) -> bool:
    return python.exists() and subprocess.run([str(python), "-c", "import bpy"], capture_output=True).returncode == 0


def _base_python() -> str:
    if "{}.{}".format(*sys.version_info) == PYTHON:
        return sys.executable
    found = shutil.which(f"python{PYTHON}")
    if found is None:
        raise InputError(
            f"tatamu install blender: needs Python {PYTHON}, but no python{PYTHON} is on the search path; install this "
            "version of Python, or install the program Blender (3.4 or later) yourself"
        )
    return found


def _run(command: list[str], failure: str) -> None:
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        lines = (done.stderr or done.stdout).strip().splitlines()
        raise InputError(
            f"tatamu install blender: {failure} ({lines[-1] if lines else f'exit code {done.returncode}'})"
        )
