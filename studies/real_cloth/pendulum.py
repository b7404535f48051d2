"""Computes the swing of a stiff plate that hangs from a moving bar in air, for comparison with cloth.

The plate has the length L. Its angle phi from the vertical solves the equation:

    (1 + kappa) (L^2/3 phi'' + L/2 a) = - g L/2 sin(phi) - 1/L integral (c1 u + max(c2, c3 s^(-1/3)) |u| u) r dr
    u = v + r phi'

All terms are divided by areal density and width. v and a are the velocity and the acceleration of the bar across
itself, u is the velocity of the point at the distance r from the bar, and s its path since u changed its sign. The term
with s makes the drag larger just after a turn, because drag in small oscillations is several times the steady drag.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from studies.real_cloth.recording import STEP, Recording
from tatamu.simulation.material import GRAVITY

PIECES = 8
"""Number of pieces into which a swinging plate is divided along its length to sum the drag of air."""
SHORTEST = 1e-6
"""Minimum of a path s [m]."""


@dataclass(frozen=True)
class AirLaw:
    """Coefficients of the forces of air, divided by the areal density of the cloth."""

    added_mass: float = 0.0
    """kappa [-]."""
    linear: float = 0.0
    """c1 [1/s]."""
    quadratic: float = 0.0
    """c2 [1/m]."""
    turning: float = 0.0
    """c3 [m^(-2/3)]."""


def plate_swing(recording: Recording, air: AirLaw, length: float) -> np.ndarray:
    """Return how far the lower edge of a stiff plate swings at the f frames of a recording [m], shape (f,)."""
    times, corners = recording.path
    normal = recording.normal(times)
    velocity = np.gradient(corners.mean(axis=1), STEP, axis=0)
    ahead = (velocity * normal).sum(axis=1)
    pushed = (np.gradient(velocity, STEP, axis=0) * normal).sum(axis=1)
    radii = length * (np.arange(PIECES) + 0.5) / PIECES
    inertia = (1.0 + air.added_mass) * length**2 / 3.0
    angle = 0.0
    rate = 0.0
    path = np.zeros(PIECES)
    angles = np.empty(len(times))
    for k in range(len(times)):
        angles[k] = angle
        through = ahead[k] + radii * rate
        path = np.where(path * through < 0.0, 0.0, path) + STEP * through
        quadratic = np.maximum(air.quadratic, air.turning / np.cbrt(np.maximum(np.abs(path), SHORTEST)))
        held = air.linear * through + quadratic * np.abs(through) * through
        drag = length / PIECES * float(held @ radii)
        torque = -0.5 * length * (GRAVITY * np.sin(angle) + (1.0 + air.added_mass) * pushed[k]) - drag / length
        rate += STEP * torque / inertia
        angle += STEP * rate
    return np.interp(recording.clock, times, length * np.sin(angles))


def plate_nodes(recording: Recording, swing: np.ndarray, length: float) -> np.ndarray:
    """Return the positions that the camera's n x n nodes would have on a stiff plate [m], shape (f, n, n, 3).

    `swing` is that of the lower edge at the f frames [m].
    """
    corners = recording.corners(recording.clock)
    count = recording.nodes.shape[1]
    along = np.linspace(0.0, 1.0, count)[:, None]
    bar = corners[:, None, 0] + along * (corners[:, 1] - corners[:, 0])[:, None]
    down = swing[:, None] * recording.normal(recording.clock)
    down[:, 2] -= np.sqrt(length**2 - swing**2)
    part = np.linspace(1.0, 0.0, count)[:, None, None]
    return np.asarray(bar[:, None] + part * down[:, None, None])
