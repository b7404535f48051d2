"""Position-based correction of a pair that is too close, by split impulse.

Contact moves positions, and this motion over the time step becomes velocity. A pair that was already too close at the
start of the step would then be thrown apart. It is therefore separated at a limited speed, and a part of the correction
also moves the predicted positions, from which velocities are computed. That part is *position only*.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tatamu.simulators.native.compiled import kernel


class Positions(NamedTuple):
    """Positions of the vertices in one time step [m], shape (n, 3) each."""

    x: np.ndarray
    """Corrected by contact."""
    start: np.ndarray
    """At the start of the step, after the contact of the step before: legal, layers are on their sides."""
    predicted: np.ndarray
    """Before contact, from which the change of velocity is taken: (x - predicted) / step. Shifted by corrections that
    are position only."""


@kernel
def correction(gap: float, gap_at_start: float, wanted: float, clearing: float, recovery: float) -> tuple[float, float]:
    """Return the distance by which a pair is pushed apart, and the part of it that is position only.

    Args:
        gap: How far apart the pair is, negative when it has passed [m].
        gap_at_start: How far apart it was at the start of the step [m].
        wanted: How far apart it should be [m].
        clearing: How far it may come apart in this step [m].
        recovery: How far of that as velocity [m].

    Returns:
        Both [m]; the first is not positive where nothing is to be done.
    """
    legal = max(gap_at_start, 0.0)
    push = min(wanted, legal + clearing) - gap
    lasting = min(wanted, legal + recovery) - gap
    return push, push - max(lasting, 0.0)


@kernel
def move(x: np.ndarray, v: int, distance: float, nx: float, ny: float, nz: float) -> None:
    """Move vertex v by a distance [m] along n, or by a part of the vector n."""
    x[v, 0] += distance * nx
    x[v, 1] += distance * ny
    x[v, 2] += distance * nz
