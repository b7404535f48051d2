"""Rounds of contact: positions go from slots to vertices, are corrected there, and come back.

Where layers are crushed, contact is resolved several times per outer step.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from tatamu.simulators.native.contact import broad_phase as candidates
from tatamu.simulators.native.contact import impact_zones as zones
from tatamu.simulators.native.contact import table
from tatamu.simulators.native.contact import vertex_face as contact

RESTLESS, CALM = 0.25, 0.08
"""Contact that moves a vertex by more than the first part of a thickness is resolved twice as often from then on, at
most after every substep; by less than the second, half as often. Layers that hands crush would otherwise swing by
thicknesses between two corrections."""

SWEEPS_OF_MANY = 5
"""Sweeps at most where a step has several rounds of contact: the next round is soon."""


@njit(cache=True, error_model="numpy")
def gather(X, slot, x, moved):  # type: ignore[no-untyped-def]
    """Positions from slots to vertices, twice; the sum of the squares of all [m^2]."""
    a, b, c = X[0], X[1], X[2]
    square = 0.0
    for v in range(slot.shape[0]):
        s = slot[v]
        p, q, r = a[s], b[s], c[s]
        x[v, 0], x[v, 1], x[v, 2] = p, q, r
        moved[v, 0], moved[v, 1], moved[v, 2] = p, q, r
        square += p * p + q * q + r * r
    return square


@njit(cache=True, error_model="numpy")
def _scatter(x, moved, slot, X, V, rate):  # type: ignore[no-untyped-def]
    """Corrected positions back to slots, and what was corrected to the velocities."""
    a, b, c, u, v, w = X[0], X[1], X[2], V[0], V[1], V[2]
    for i in range(slot.shape[0]):
        s = slot[i]
        a[s], b[s], c[s] = x[i, 0], x[i, 1], x[i, 2]
        u[s] += rate * (x[i, 0] - moved[i, 0])
        v[s] += rate * (x[i, 1] - moved[i, 1])
        w[s] += rate * (x[i, 2] - moved[i, 2])


@njit(cache=True, error_model="numpy")
def _largest_correction(x, moved):  # type: ignore[no-untyped-def]
    """Longest way that contact moved a vertex [m]."""
    square = 0.0
    for v in range(x.shape[0]):
        a, b, c = x[v, 0] - moved[v, 0], x[v, 1] - moved[v, 1], x[v, 2] - moved[v, 2]
        square = max(square, a * a + b * b + c * c)
    return np.sqrt(square)


@njit(cache=True, error_model="numpy")
def collide(state, mesh, lists, world, step):  # type: ignore[no-untyped-def]
    """Resolve contact; the longest way that it moved a vertex [m]."""
    x, moved, before = state.x, state.moved, state.before
    candidates.refresh(x, before, mesh, lists)
    gap = 0.0
    for sweep in range(len(contact.KEEP) if state.rounds[0] == 1 else SWEEPS_OF_MANY):
        keep = contact.KEEP[sweep]
        if gap >= keep:
            break
        gap = contact.sweep(x, before, moved, mesh, lists, world.friction_cloth, step, keep)
        if world.has_table:  # last, so that it carries what the layers hand down
            table.sweep(
                x,
                before,
                moved,
                mesh.inverse_mass,
                lists,
                world.height,
                world.sine,
                world.cosine,
                world.half_thickness,
                world.friction_table,
                step,
            )
    correction = _largest_correction(x, moved)
    lists.travelled[0] += 2.0 * correction  # what contact moves may have come nearer to something as well
    if correction > CALM * mesh.reach[0] or state.rounds[0] > 1:
        zones.hold(x, before, mesh, lists)
    _scatter(x, moved, state.slot, state.X, state.V, 1.0 / step)
    return correction


@njit(cache=True, error_model="numpy")
def pace(rounds, correction, thickness, most):  # type: ignore[no-untyped-def]
    """Rounds of contact in the next outer step."""
    if correction > RESTLESS * thickness:
        return min(2 * rounds, most)
    if correction < CALM * thickness:
        return max(rounds // 2, 1)
    return rounds
