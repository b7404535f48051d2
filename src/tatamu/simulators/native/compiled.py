"""How kernels are compiled: by numba, kept on disk, without fast-math.

Products and sums are neither reordered nor fused, so a rollout has the same bytes however often and beside whatever it
is made. With numpy's error model a division by zero is an infinity instead of an exception, whose check would keep a
loop from being computed eight numbers at a time. `boundscheck` stays off.
"""

from __future__ import annotations

from numba import njit

kernel = njit(cache=True, error_model="numpy")
"""A compiled function; the compiler inlines it where it finds that worth while."""
inlined = njit(cache=True, error_model="numpy", inline="always")
"""One that is always inlined: where loops that call it are then computed several numbers at a time, and where it takes
many records and is called in one place, as it would otherwise be compiled for itself and once more there."""
unlocked = njit(cache=True, error_model="numpy", nogil=True)
"""One that lets other threads of Python run meanwhile: the outermost loop."""
