"""Contact with rigid bodies within an outer step: what is close to them, and contact after each membrane step."""

from __future__ import annotations

import numpy as np
from numba import types

from tatamu.simulation.native.compiled import call, kernel
from tatamu.simulation.native.contact.bodies import near
from tatamu.simulation.native.contact.bodies.state import Bodies, place
from tatamu.simulation.native.system import State, System


@kernel
def _longest_way(V: np.ndarray, seconds: float) -> float:
    """Return the distance [m] that the fastest vertex moves in a time [s] at its present velocity."""
    square = 0.0
    for s in range(V.shape[1]):
        square = max(square, V[0, s] * V[0, s] + V[1, s] * V[1, s] + V[2, s] * V[2, s])
    return seconds * np.sqrt(square)


@kernel
def _gather_near(X: np.ndarray, slot: np.ndarray, bodies: Bodies, to_start: bool) -> None:
    """Copy positions of vertices near bodies from slots, as those at the start or at the end of a membrane step."""
    positions = bodies.near.positions
    for b in range(bodies.radius.shape[0]):
        for i in range(bodies.near.narrow.counts[b, 0]):
            v = bodies.near.narrow.vertices[b, i]
            for k in range(3):
                if to_start:
                    positions.start[v, k] = X[k, slot[v]]
                else:
                    positions.x[v, k] = X[k, slot[v]]
                    positions.predicted[v, k] = X[k, slot[v]]


@kernel
def _scatter_near(state: State, bodies: Bodies, h: float, ahead: float) -> None:
    """Copy corrected positions back to slots, change velocities by the corrections, and look ahead to Y."""
    positions = bodies.near.positions
    for b in range(bodies.radius.shape[0]):
        for i in range(bodies.near.narrow.counts[b, 0]):
            v = bodies.near.narrow.vertices[b, i]
            s = state.slot[v]
            for k in range(3):
                state.V[k, s] += (positions.x[v, k] - positions.predicted[v, k]) / h
                state.X[k, s] = positions.x[v, k]
                state.Y[k, s] = positions.x[v, k] + ahead * state.V[k, s]
                positions.predicted[v, k] = positions.x[v, k]  # because the vertex may be near another body, too
                positions.start[v, k] = positions.x[v, k]


@kernel
def find_near(system: System, number: int, done: int, until: int, total: int) -> bool:
    """Gather cloth that may touch a body from membrane step `done` to `until` of `total`; return whether any may."""
    state = system.state
    bodies = system.bodies
    place(bodies, number, done / total, until / total)
    longest_way = _longest_way(state.V, (until - done) * system.sizes.substep)
    found = near.refresh(state.positions.x, longest_way, system.mesh, bodies)
    if found:
        _gather_near(state.X, state.slot, bodies, True)
    return found


@kernel
def meet(system: System, number: int, substep: int, total: int) -> None:
    """Resolve contact with bodies after one of the `total` membrane steps in outer step `number`.

    In an outer step, the weight of hanging cloth moves vertices on a finger by millimetres, too much for one
    correction.
    """
    state = system.state
    bodies = system.bodies
    positions = bodies.near.positions
    h = system.sizes.substep
    place(bodies, number, substep / total, (substep + 1) / total)
    _gather_near(state.X, state.slot, bodies, False)
    arguments = (positions, system.mesh, system.contact, bodies, system.options, h, 1.0)
    call(system.kernels.sweep_bodies, types.float64, arguments)
    _scatter_near(state, bodies, h, system.sizes.damping)
