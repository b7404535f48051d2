"""Position-based correction of a pair that is too close, by split impulse.

Contact moves positions. This motion, divided by the time step, becomes velocity. A pair that was already too close at
the start of the step would then be thrown apart. Therefore the pair is separated at a limited speed. In addition, a
part of the correction does not become velocity. Velocities are computed from the difference between corrected and
predicted positions, so for this part the predicted positions are moved as well. This part of the correction is called
*position only*.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tatamu.simulation.native.compiled import kernel


class Positions(NamedTuple):
    """Positions of the n vertices in one time step [m]. Each array has the shape (n, 3)."""

    x: np.ndarray
    """Positions that contact corrects."""
    start: np.ndarray
    """Positions at the start of the step, which contact corrected before. All layers are on their correct sides."""
    predicted: np.ndarray
    """Positions before contact. The change of velocity by contact is (x - predicted) / step.

    Corrections that must not become velocity also shift the predicted positions."""


@kernel
def correction(gap: float, gap_at_start: float, wanted: float, clearing: float, recovery: float) -> tuple[float, float]:
    """Return the distance by which a pair is pushed apart, and the part of it that does not become velocity.

    Args:
        gap: Distance of the pair, negative after it has passed through [m].
        gap_at_start: Distance of the pair at the start of the step [m].
        wanted: Distance that the pair should have [m].
        clearing: Largest distance by which a pair that was too close is separated in this step [m].
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
    """Move vertex v by `distance` times the vector n. If n is a unit vector, `distance` is a length [m]."""
    x[v, 0] += distance * nx
    x[v, 1] += distance * ny
    x[v, 2] += distance * nz
