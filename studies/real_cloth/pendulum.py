"""A stiff plate that hangs from a moving bar in air: a model with one degree of freedom, for comparison.

    (1 + kappa) (L^2/3 phi'' + L/2 a) = - g L/2 sin(phi) - 1/L integral (c1 u + max(c2, c3 s^(-1/3)) |u| u) r dr
    u = v + r phi'

per density and width: kappa added mass over density, c1 and c2 linear and quadratic drag over density, v and a velocity
and acceleration of the bar across itself, s the path since u changed its sign. A plate that oscillates by little has
several times the drag of one in steady motion.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from studies.real_cloth.recording import STEP, Recording
from tatamu.material import GRAVITY

PIECES = 8
"""Pieces of the plate's height over which the drag is summed."""
SHORTEST = 1e-6
"""Least path since a turn [m]."""


@dataclass(frozen=True)
class AirLaw:
    """Effects of air, over the cloth's areal density."""

    added_mass: float = 0.0
    """Added mass kappa [-]."""
    linear: float = 0.0
    """Linear drag c1 [1/s]."""
    quadratic: float = 0.0
    """Quadratic drag c2 [1/m]."""
    turning: float = 0.0
    """Turning drag c3 [m^(-2/3)]."""


def plate_swing(recording: Recording, air: AirLaw, length: float) -> np.ndarray:
    """Return the swing of the plate's lower edge at the frames [m], shape (f,).

    Args:
        recording: Recording whose bar moves the plate.
        air: Law of air.
        length: L [m].
    """
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
    """Return the camera's nodes on the plate at the frames [m], shape (f, n, n, 3).

    Args:
        recording: Recording whose robot holds the plate.
        swing: Swing of the lower edge at the frames [m], shape (f,).
        length: Length of the plate [m].
    """
    corners = recording.corners(recording.clock)
    count = recording.nodes.shape[1]
    along = np.linspace(0.0, 1.0, count)[:, None]
    bar = corners[:, None, 0] + along * (corners[:, 1] - corners[:, 0])[:, None]
    down = swing[:, None] * recording.normal(recording.clock)
    down[:, 2] -= np.sqrt(length**2 - swing**2)
    part = np.linspace(1.0, 0.0, count)[:, None, None]
    return np.asarray(bar[:, None] + part * down[:, None, None])
