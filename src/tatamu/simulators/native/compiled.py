"""How kernels are compiled: by numba, kept on disk, without fast-math.

Products and sums are neither reordered nor fused, so a rollout has the same bytes however often and beside whatever it
is made. With numpy's error model a division by zero is an infinity instead of an exception, whose check would keep a
loop from being computed eight numbers at a time. `boundscheck` stays off.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import njit

_KERNELS: list[Any] = []
"""Every function that is compiled by itself, as numba's dispatcher."""


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
"""One that is always inlined, as loops that call it are then computed several numbers at a time."""
unlocked = _compiler(nogil=True)
"""One that lets other threads of Python run meanwhile: the outermost loop."""


def compilation() -> tuple[int, int]:
    """How many kernels this process compiles or has compiled, as they were not on disk; and how many there are."""
    return sum(bool(each.stats.cache_misses) for each in _KERNELS), len(_KERNELS)
