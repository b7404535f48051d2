"""Contact in one round: nonlinear Gauss-Seidel sweeps over all pairs and the table, then impact zones.

A sweep corrects one pair after another, each from the positions that the one before left. The first restores the whole
distance between layers, and later ones a given fraction of it. The sweeps end when every pair has the distance that the
next sweep would restore, or when the list of fractions ends.
"""

from __future__ import annotations

import numpy as np
from numba import types

from tatamu.simulation.native.addresses import Addresses
from tatamu.simulation.native.compiled import call, inlined, kernel
from tatamu.simulation.native.contact import broad_phase, motion
from tatamu.simulation.native.contact.bodies.state import Bodies
from tatamu.simulation.native.contact.projection import Positions
from tatamu.simulation.native.contact.state import ContactMesh, ContactState
from tatamu.simulation.native.contact.table import TablePlane
from tatamu.simulation.native.geometry import longest_displacement
from tatamu.simulation.native.options import ContactOptions


@inlined
def _sweep(
    positions: Positions,
    mesh: ContactMesh,
    contact: ContactState,
    bodies: Bodies,
    plane: TablePlane,
    options: ContactOptions,
    kernels: Addresses,
    step: float,
    restored: float,
) -> float:
    """Sweep over edges, vertices, bodies and the table, and return the minimum gap before correction [thicknesses].

    `step` is the time since the start of the round [s], and `restored` the fraction of distances that is restored [-].
    """
    contact.counters.sweep += 1
    edge_gap = call(kernels.sweep_edges, types.float64, (positions, mesh, contact, options, step, restored))
    gap = call(kernels.sweep_vertices, types.float64, (positions, mesh, contact, options, step, restored))
    if bodies.radius.shape[0]:
        call(kernels.sweep_bodies, types.float64, (positions, mesh, contact, bodies, options, step, restored))
    if plane.present:  # last, because the layers pass their load on to the table
        call(kernels.sweep_table, None, (positions, mesh.inverse_mass, contact, plane, options, step))
    return min(gap, edge_gap / options.edge_gap) / mesh.thickness


@kernel
def _restlessness(positions: Positions, held: float) -> float:
    """Return the longest distance by which contact moved a vertex [m].

    If a vertex ends where it was at the start of the round, contact only holds it against a load, so its correction
    counts with the factor `held`.
    """
    square = 0.0
    for v in range(positions.x.shape[0]):
        correction = 0.0
        motion = 0.0
        for k in range(3):
            correction += (positions.x[v, k] - positions.predicted[v, k]) ** 2
            motion += (positions.x[v, k] - positions.start[v, k]) ** 2
        square = max(square, min(correction, max(motion, held * held * correction)))
    return np.sqrt(square)


@inlined
def resolve(
    positions: Positions,
    mesh: ContactMesh,
    contact: ContactState,
    bodies: Bodies,
    plane: TablePlane,
    options: ContactOptions,
    kernels: Addresses,
    step: float,
) -> float:
    """Resolve all contact of one round, a time `step` [s], and return its longest correction [m] (`_restlessness`)."""
    counters = contact.counters
    broad_phase.refresh(positions, mesh, contact, options, kernels)
    most_sweeps = len(options.restored)
    if counters.rounds > 1:
        most_sweeps = min(most_sweeps, options.sweeps_of_many)
    gap = 0.0
    for number in range(most_sweeps):
        restored = options.restored[number]
        if gap >= restored:
            break
        gap = _sweep(positions, mesh, contact, bodies, plane, options, kernels, step, restored)
    longest = longest_displacement(positions.x, positions.predicted)
    if longest > options.calm * mesh.thickness or counters.rounds > 1:
        motion.reach(positions, contact)  # a vertex that contact moved may have come near to a sleeping pair
        call(kernels.hold_zones, types.int64, (positions, mesh, contact, options))
    return _restlessness(positions, options.held)


@kernel
def rounds_of_next_step(rounds: int, longest: float, thickness: float, most: int, options: ContactOptions) -> int:
    """Return the number of rounds in the next outer step, up to `most`.

    It doubles if the longest correction [m] is above the option `restless`, and halves if it is below `calm`.
    """
    if longest > options.restless * thickness:
        return min(2 * rounds, most)
    if longest < options.calm * thickness:
        return max(rounds // 2, 1)
    return rounds
