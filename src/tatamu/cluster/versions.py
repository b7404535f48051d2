"""Finds the versions of Python, of tatamu's code and of packages, which must be equal on all machines.

If they were different, results might depend on the machine.
"""

from __future__ import annotations

import platform
from collections.abc import Mapping
from functools import cache
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from tatamu.base.version import __version__

Versions = Mapping[str, str]


@cache
def versions() -> Versions:
    """Return the versions of Python, of tatamu and of packages in this process, as a dictionary by name."""
    found = {"Python": platform.python_version(), "tatamu": f"{__version__} ({source_digest()})"}
    for name in ("numpy", "numba", "scipy"):  # packages whose versions may change results
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "missing"
    return found


def difference(there: Versions) -> str | None:
    """Compare the versions of another process with the versions in this process.

    Return a text that describes the first difference. Return None if all versions are equal.
    """
    for name, here in versions().items():
        if there.get(name) != here:
            return f"{name} {there.get(name, 'missing')} there, {here} here"
    return None


@cache
def source_digest() -> str:
    """Return a short digest of tatamu's code, which changes if any byte of the code changes."""
    root = Path(__file__).parent.parent
    digest = sha256()
    for file in sorted(root.rglob("*.py")):
        digest.update(file.relative_to(root).as_posix().encode())
        digest.update(file.read_bytes())
    return digest.hexdigest()[:12]


@cache
def processor() -> str:
    """Return the kind of this machine's processor, for which the simulator `native` is compiled.

    Processors of the same kind give exactly the same results.
    """
    try:
        from llvmlite.binding import get_host_cpu_features, get_host_cpu_name

        features = get_host_cpu_features().flatten()
        return f"{get_host_cpu_name()} {sha256(features.encode()).hexdigest()[:6]}"
    except (ImportError, RuntimeError):
        return platform.processor() or platform.machine()
