"""Position-based correction of a pair that is too close, by split impulse.

The motion by contact, divided by the time step, becomes velocity, which would throw a pair apart that was already too
close at the start of the step. It is therefore separated at a limited speed, and a part of its correction is *position
only*: the predicted positions are moved as well, so that this part does not become velocity.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tatamu.simulation.native.compiled import kernel


class Positions(NamedTuple):
    """Positions of the vertices in one time step [m], each of the shape (n, 3)."""

    x: np.ndarray
    """Positions that contact corrects."""
    start: np.ndarray
    """Positions at the start of the step, with all layers on their correct sides."""
    predicted: np.ndarray
    """Positions before contact, moved by corrections that are position only.

    Contact changes the velocities by (x - predicted) / step."""


@kernel
def correction(gap: float, gap_at_start: float, wanted: float, clearing: float, recovery: float) -> tuple[float, float]:
    """Return the push of a pair, zero or negative if it needs none, and its part that is position only [m].

    A pair that was too close is separated by at most `clearing` [m] in this step, of which `recovery` [m] becomes
    velocity.
    """
    legal = max(gap_at_start, 0.0)
    push = min(wanted, legal + clearing) - gap
    lasting = min(wanted, legal + recovery) - gap
    return push, push - max(lasting, 0.0)


@kernel
def move(x: np.ndarray, v: int, distance: float, nx: float, ny: float, nz: float) -> None:
    """Move vertex v by `distance` times the vector n."""
    x[v, 0] += distance * nx
    x[v, 1] += distance * ny
    x[v, 2] += distance * nz
