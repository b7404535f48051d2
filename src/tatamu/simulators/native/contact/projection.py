"""How far contact pushes things apart, and what it remembers of that."""

from __future__ import annotations

from numba import njit

CLEARING_SPEED, RECOVERY_SPEED = 0.5, 0.1
"""Layers that begin a step too close come apart at the first of these speeds [m/s], but keep no more than the second:
what begins in a tangle does not explode."""
NOTICEABLE = 0.02
"""Pushes beyond this part of a thickness make the next sweep look again at what they moved."""
HARD, RESTLESS_FOR = 0.08, 3
"""A push beyond that part of a thickness is hard, and makes vertices restless for so many outer steps: only they can
pass through something in spite of contact (`zones`)."""


@njit(cache=True, error_model="numpy")
def pushes(gap, gap_before, wanted, step):  # type: ignore[no-untyped-def]
    """How far to push a pair apart, and the part of it that must not become velocity."""
    before = max(gap_before, 0.0)
    push = min(wanted, before + CLEARING_SPEED * step) - gap
    lasting = min(wanted, before + RECOVERY_SPEED * step) - gap
    return push, push - max(lasting, 0.0)


@njit(cache=True, error_model="numpy")
def shift(x, v, way, nx, ny, nz):  # type: ignore[no-untyped-def]
    """Move vertex v some way along n."""
    x[v, 0] += way * nx
    x[v, 1] += way * ny
    x[v, 2] += way * nz
