"""Compilation of kernels by numba, without fast-math. A kernel is a compiled function. Compiled code is kept on disk.

Without fast-math, the compiler does not reorder or fuse products and sums. Therefore two rollouts of the same scene
have exactly equal bytes. Numpy's error model is used. With this model, a division by zero gives an infinity and not an
exception. Checks for exceptions would prevent loops from computing eight numbers at a time. The indices of arrays are
not checked either (`boundscheck` is off).
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from numba import njit, typeof

_KERNELS: list[Any] = []
"""All functions that numba compiles separately, as the dispatcher objects that numba makes of them."""


def _compiler(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator that compiles functions and records them in a list."""
    compiler = njit(cache=True, error_model="numpy", **options)

    def compiled(function: Callable[..., Any]) -> Any:
        _KERNELS.append(compiler(function))
        return _KERNELS[-1]

    return compiled


kernel = _compiler()
"""Decorator that compiles a function. The compiler inlines the function if it expects that this is faster."""
inlined = njit(cache=True, error_model="numpy", inline="always")
"""Decorator that compiles a function and always inlines it.

There are two reasons for inlining. Some loops that call a function can be vectorised only if the function is inlined.
The other reason is the time for compiling. A function that is called at only one place, and has many records as
arguments, would be compiled twice if it were not inlined.
"""
unlocked = _compiler(nogil=True)
"""Decorator that compiles the outermost loop of a simulation. Other Python threads can run during this loop."""


def for_types_of(kernel: Any, arguments: tuple[Any, ...]) -> Callable[..., Any]:
    """Return a kernel's compiled code for arguments of these types. The kernel is compiled if necessary.

    In every call, a kernel checks the types of all arguments. For a scene with its hundred arrays, this takes a hundred
    microseconds. The returned code does not check the types, so it must not be called with arguments of other types.
    """
    code: Callable[..., Any] = kernel.compile(tuple(map(typeof, arguments)))
    return code


def compilation() -> tuple[int, int]:
    """Return the progress of compilation: the number of compiled functions (kernels) on disk, and of all kernels.

    The first number is 0 if this process did not have to compile any kernel.

    The function counts files on disk, because another process may compile kernels at the same time (`precompile`).
    """
    if not any(each.stats.cache_misses for each in _KERNELS):
        return 0, len(_KERNELS)
    folders = {each.stats.cache_path for each in _KERNELS}
    kept = {file.name.partition("-")[0] for folder in folders if folder for file in Path(folder).glob("*.nbi")}
    return sum(_name(each) in kept for each in _KERNELS), len(_KERNELS)


def _name(kernel: Any) -> str:
    """Return the beginning of the file name of a kernel on disk."""
    return f"{kernel.py_func.__module__.rpartition('.')[2]}.{kernel.__name__}"
