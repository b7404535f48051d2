"""Finds Blender on this machine.

If the environment variable TATAMU_BLENDER is set, it contains the path of Blender. If it is not set, Blender is taken
from the virtual environment that `tatamu install blender` makes. If this environment does not exist, the program
`blender` is looked up on the search path for programs.
"""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

from tatamu.base.errors import InputError

VARIABLE = "TATAMU_BLENDER"
"""Name of the environment variable that contains the path of Blender.

The path leads to a Blender executable, or to a Python interpreter that can import `bpy`, the Python module of
Blender."""
VERSION = "5.0.1"
"""Version of Blender that `tatamu install blender` installs.

The measurements in docs/notes/simulators.md were made with this version."""
HELP = (
    f"blender: no Blender found; run `tatamu install blender`, or put `blender` on the search path, "
    f"or let {VARIABLE} name a Blender executable or a Python that has bpy"
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
    """Return the command line that starts a worker, a process that runs Blender.

    Raises:
        InputError: If no Blender is found, or the environment variable names a program that does not exist.
    """
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
    """Return the command line that starts a worker, a process that runs Blender, from the path `program`.

    The program is a Blender executable, or a Python interpreter that can import Blender. The file name of an
    interpreter begins with `python` or `pypy`.
    """
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
