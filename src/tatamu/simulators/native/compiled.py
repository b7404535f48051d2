"""Compilation of kernels by numba, without fast-math; the results are kept on disk.

Products and sums are neither reordered nor fused, so a rollout always has the same bytes. With numpy's error model a
division by zero is an infinity instead of an exception, whose check would keep a loop from being computed eight numbers
at a time. `boundscheck` stays off.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from numba import njit, typeof

_KERNELS: list[Any] = []
"""The numba dispatchers of all functions that are compiled separately."""


def _compiler(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """A decorator that makes kernels and keeps account of them."""
    compiler = njit(cache=True, error_model="numpy", **options)

    def compiled(function: Callable[..., Any]) -> Any:
        _KERNELS.append(compiler(function))
        return _KERNELS[-1]

    return compiled


kernel = _compiler()
"""A compiled function; the compiler inlines it where it finds that worth while."""
inlined = njit(cache=True, error_model="numpy", inline="always")
"""Compile a function that is always inlined.

It is used if calling loops can then be vectorised, or if a function with many records is called in one place and would
otherwise be compiled twice.
"""
unlocked = _compiler(nogil=True)
"""One that lets other threads of Python run meanwhile: the outermost loop."""


def for_types_of(kernel: Any, arguments: tuple[Any, ...]) -> Callable[..., Any]:
    """Return a kernel's code for arguments of these types, compiled if it is not.

    A kernel looks at the types of all arguments whenever it is called, which costs a hundred microseconds for a scene
    with its hundred arrays; this code does not, and must not be given arguments of other types.
    """
    code: Callable[..., Any] = kernel.compile(tuple(map(typeof, arguments)))
    return code


def compilation() -> tuple[int, int]:
    """Return the number of kernels on disk (0 if this process had to compile none), and their total.

    Another process may compile some of them at the same time (`precompile`), so the files on disk are counted.
    """
    if not any(each.stats.cache_misses for each in _KERNELS):
        return 0, len(_KERNELS)
    folders = {each.stats.cache_path for each in _KERNELS}
    kept = {file.name.partition("-")[0] for folder in folders if folder for file in Path(folder).glob("*.nbi")}
    return sum(_name(each) in kept for each in _KERNELS), len(_KERNELS)


def _name(kernel: Any) -> str:
    """Return the beginning of the name of its file on disk."""
    return f"{kernel.py_func.__module__.rpartition('.')[2]}.{kernel.__name__}"
