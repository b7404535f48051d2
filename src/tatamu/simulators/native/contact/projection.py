"""Position-based correction of a pair that is too close, by split impulse.

Contact moves positions, and this motion over the time step becomes velocity. A pair that was already too close at the
start of the step would then be thrown apart. The pair is therefore separated at a limited speed. In addition, a part of
the correction does not become velocity, because it also moves the predicted positions, from which velocities are
computed. This part is *position only*.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tatamu.simulators.native.compiled import kernel


class Positions(NamedTuple):
    """Positions of the n vertices in one time step [m]. Each array has the shape (n, 3)."""

    x: np.ndarray
    """Positions that contact corrects."""
    start: np.ndarray
    """Positions at the start of the step, corrected by contact. All layers are on their correct sides."""
    predicted: np.ndarray
    """Positions before contact. They give the change of velocity, (x - predicted) / step.

    Corrections that are position only also shift the predicted positions."""


@kernel
def correction(gap: float, gap_at_start: float, wanted: float, clearing: float, recovery: float) -> tuple[float, float]:
    """Return the distance by which a pair is pushed apart, and the part of it that is position only.

    Args:
        gap: Distance of the pair, negative after it has passed through [m].
        gap_at_start: Distance of the pair at the start of the step [m].
        wanted: Distance that the pair should have [m].
        clearing: Largest distance that the pair may gain in this step [m].
        recovery: Part of the distance `clearing` that becomes velocity [m].

    Returns:
        The two distances [m]. The first is zero or negative if the pair needs no push.
    """
    legal = max(gap_at_start, 0.0)
    push = min(wanted, legal + clearing) - gap
    lasting = min(wanted, legal + recovery) - gap
    return push, push - max(lasting, 0.0)


@kernel
def move(x: np.ndarray, v: int, distance: float, nx: float, ny: float, nz: float) -> None:
    """Move vertex v by `distance` [m] along a unit vector n, or by the fraction `distance` of any other vector n."""
    x[v, 0] += distance * nx
    x[v, 1] += distance * ny
    x[v, 2] += distance * nz
