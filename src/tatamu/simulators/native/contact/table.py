"""Cloth against the table: a plane with Coulomb friction, applied to positions once per step.

With depth d below the plane and slip s along it, both since the step began: d is undone, and s shrinks by
min(1, mu d / |s|). A resting cloth that gravity pulls by g cos(theta) h^2 into the table and by g sin(theta) h^2 along
it therefore sticks exactly when tan(theta) < mu. Source: docs/theory/contact.md.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from tatamu.simulators.native.contact.projection import CLEARING_SPEED, HARD, RECOVERY_SPEED, RESTLESS_FOR


@njit(cache=True, error_model="numpy")
def sweep(x, before, moved, inverse_mass, lists, height, sine, cosine, half, friction, step):  # type: ignore[no-untyped-def]
    """Correct the positions x, shape (n, 3); the mid-surface stays `half` a thickness over the table. See `contact`."""
    hard = HARD * 2.0 * half
    for v in range(x.shape[0]):
        if inverse_mass[v] == 0.0:
            continue
        over = x[v, 0] * sine + (x[v, 2] - height) * cosine
        if over >= half:
            continue
        over_before = before[v, 0] * sine + (before[v, 2] - height) * cosine
        depth = min(half, over_before + CLEARING_SPEED * step) - over
        if depth <= 0.0:
            continue
        if depth > hard:
            lists.restless[v] = lists.number[0] + RESTLESS_FOR
        silent = depth - max(min(half, over_before + RECOVERY_SPEED * step) - over, 0.0)
        moved[v, 0] += silent * sine
        moved[v, 2] += silent * cosine
        sx, sy, sz = x[v, 0] - before[v, 0], x[v, 1] - before[v, 1], x[v, 2] - before[v, 2]
        along = sx * sine + sz * cosine
        sx, sz = sx - along * sine, sz - along * cosine
        slip = np.sqrt(sx * sx + sy * sy + sz * sz) + 1e-30
        held = min(1.0, friction * depth / slip)
        x[v, 0] += depth * sine - held * sx
        x[v, 1] -= held * sy
        x[v, 2] += depth * cosine - held * sz
