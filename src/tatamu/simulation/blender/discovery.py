"""Where Blender is: TATAMU_BLENDER, or the environment of `tatamu install blender`, or the search path."""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

from tatamu.base.errors import InputError

VARIABLE = "TATAMU_BLENDER"
"""Environment variable with the path of a Blender executable, or of a Python that can import `bpy`."""
VERSION = "5.0.1"
"""Version that `tatamu install blender` installs, with which docs/notes/simulators.md was measured."""
HELP = (
    f"blender: no Blender found; run `tatamu install blender`, or put `blender` on the search path, "
    f"or set {VARIABLE} to a Blender executable or a Python that has bpy"
)
WORKER = Path(__file__).with_name("worker.py")


def cache_folder() -> Path:
    """Return tatamu's folder in the user's cache."""
    if sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData" / "Local"))
    elif sys.platform == "darwin":
        base = Path.home() / "Library" / "Caches"
    else:
        base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return base / "tatamu"


def environment_folder() -> Path:
    """Return the path of the virtual environment that `tatamu install blender` makes."""
    return cache_folder() / f"blender-{VERSION}"


def python_of(folder: Path) -> Path:
    """Return the path of the Python interpreter in a virtual environment."""
    return folder / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")


def command() -> list[str]:
    """Return the command line that starts a worker, or raise InputError if no Blender is found."""
    named = os.environ.get(VARIABLE)
    if named:
        return started_by(_named(named))
    installed = python_of(environment_folder())
    if installed.exists():
        return started_by(str(installed))
    found = shutil.which("blender")
    if found is None:
        raise InputError(HELP)
    return started_by(found)


def _named(name: str) -> str:
    program = shutil.which(os.path.expanduser(name))
    if program is None:
        raise InputError(f"{VARIABLE}: must name a Blender executable or a Python that has bpy, given {name!r}")
    return program


def started_by(program: str) -> list[str]:
    """Return the command line that starts a worker: by Blender, or by a Python, called `python..` or `pypy..`."""
    if Path(program).name.lower().startswith(("python", "pypy")):
        return [program, str(WORKER)]
    return [program, "--background", "--factory-startup", "--python-exit-code", "3", "--python", str(WORKER)]


def available() -> bool:
    """Return whether Blender is found on this machine."""
    try:
        command()
    except InputError:
        return False
    return True
