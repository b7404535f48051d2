"""Contact of cloth with the table, a plane with Coulomb friction (docs/theory/contact.md).

The depth d of a vertex below the plane is undone, and the slip s along the plane by the fraction min(1, mu d / |s|). On
a table tilted by theta, gravity gives d = g cos(theta) h^2 and s = g sin(theta) h^2 in a step h, so cloth sticks
exactly when tan(theta) < mu.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tatamu.simulation.native.compiled import kernel
from tatamu.simulation.native.contact.projection import Positions
from tatamu.simulation.native.contact.state import ContactState
from tatamu.simulation.native.geometry import TINY_LENGTH
from tatamu.simulation.native.options import ContactOptions


class TablePlane(NamedTuple):
    """The plane z = height, rotated about its line x = 0 by a tilt."""

    present: bool
    height: float
    """Height of the plane at x = 0 [m]."""
    sine: float
    cosine: float
    half_thickness: float
    """Distance of the cloth's mid-surface from the table [m]."""
    friction: float
    """Coulomb coefficient mu of cloth on the table [-]."""


@kernel
def sweep(
    positions: Positions,
    inverse_mass: np.ndarray,
    contact: ContactState,
    plane: TablePlane,
    options: ContactOptions,
    step: float,
) -> None:
    """Lift all vertices that are too close to the table or below it, and hold them by friction.

    Only a part of the lift becomes velocity, as in `projection.correction`.
    """
    x = positions.x
    start = positions.start
    predicted = positions.predicted
    restless = contact.activity.restless
    sine = plane.sine
    cosine = plane.cosine
    half = plane.half_thickness
    hard = options.hard * 2.0 * half
    clearing = options.clearing_speed * step
    recovery = options.recovery_speed * step
    restless_until = contact.counters.outer_step + options.restless_steps
    for v in range(x.shape[0]):
        if inverse_mass[v] == 0.0:
            continue
        over = x[v, 0] * sine + (x[v, 2] - plane.height) * cosine
        if over >= half:
            continue
        over_at_start = start[v, 0] * sine + (start[v, 2] - plane.height) * cosine
        depth = min(half, over_at_start + clearing) - over
        if depth <= 0.0:
            continue
        if depth > hard:
            restless[v] = restless_until
        position_only = depth - max(min(half, over_at_start + recovery) - over, 0.0)
        predicted[v, 0] += position_only * sine
        predicted[v, 2] += position_only * cosine
        sx = x[v, 0] - start[v, 0]
        sy = x[v, 1] - start[v, 1]
        sz = x[v, 2] - start[v, 2]
        along = sx * sine + sz * cosine
        sx -= along * sine
        sz -= along * cosine
        slip = np.sqrt(sx * sx + sy * sy + sz * sz) + TINY_LENGTH
        held = min(1.0, plane.friction * depth / slip)
        x[v, 0] += depth * sine - held * sx
        x[v, 1] -= held * sy
        x[v, 2] += depth * cosine - held * sz
