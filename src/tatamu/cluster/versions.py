"""Checks the versions of Python, of tatamu's code and of packages, which must be equal on all machines.

If they were different, results might depend on the machine.
"""

from __future__ import annotations

import platform
from collections.abc import Callable, Mapping
from functools import cache
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from time import perf_counter
from typing import Any

from tatamu.base.errors import UnavailableError
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

    Return a text that describes the first difference, such as "numba 0.61, not 0.60". Return None if all versions are
    equal.
    """
    for name, here in versions().items():
        if there.get(name) != here:
            return f"{name} {there.get(name, 'missing')}, not {here}"
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


def checked_call(of_client: Versions, function: Callable[..., Any], *args: Any, **kwargs: Any) -> tuple[float, Any]:
    """Call a function on a worker with the versions of the client, and return its wall time [s] and its result.

    Raises:
        UnavailableError: If a version differs. This happens if the worker joined after the check at the start.
    """
    if of_client != versions():
        raise UnavailableError(
            f"versions: a worker differs from this machine, which has {difference(of_client)}; install the same "
            "versions"
        )
    begun = perf_counter()
    result = function(*args, **kwargs)
    return perf_counter() - begun, result


def identify() -> tuple[Versions, str]:
    """Return the versions of packages on a worker, and the kind of its processor."""
    return dict(versions()), processor()
