"""Contact in one time step: nonlinear Gauss-Seidel sweeps over all pairs and the table, then impact zones.

A sweep corrects one pair after another. Each correction starts from the positions that the correction before left. The
first sweep restores the whole distance between layers. Each later sweep restores only a given fraction of this
distance. The sweeps end when every pair already has the distance that the next sweep would restore, or when the list of
fractions ends. If layers are crushed, contact is resolved in several rounds per outer step, the longest time step of
the simulation.
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
    """Make one sweep over edges, vertices, bodies and the table, and return the smallest gap between layers.

    The gap is measured before its correction. Its unit is the thickness of the cloth.
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
    """Return the longest distance by which contact moved a vertex [m]. A vertex that contact holds counts in part.

    Contact moves each vertex from its predicted position to its final position. If the final position is the position
    at the start of the round, contact only holds the vertex against a load. The correction of such a vertex counts with
    the factor `held`.
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
    """Resolve all contact of one round: contact between layers, with bodies and with the table.

    Args:
        positions: Positions to correct, and the positions at the start of the round.
        mesh: The mesh.
        contact: State of contact.
        bodies: Rigid bodies, with their poses of this round.
        plane: The table.
        options: All options of contact. Its `restored` must be an array.
        kernels: Addresses of the sweeps and searches.
        step: Time since the start of the round [s].

    Returns:
        The longest distance by which contact moved a vertex [m]. A vertex that contact holds in its place counts in
        part. Motion that does not become velocity is not counted.
    """
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
    """Return the number of rounds of contact in the next outer step.

    The number is doubled if contact moved a vertex far in the present outer step, and halved if contact hardly moved
    any vertex.

    Args:
        rounds: Number of rounds in the present outer step.
        longest: Longest correction in any of these rounds [m].
        thickness: Thickness of the cloth [m].
        most: Largest number of rounds.
        options: Options of contact. Above the length `restless` of a correction the number of rounds grows, and below
            the length `calm` it falls.
    """
    if longest > options.restless * thickness:
        return min(2 * rounds, most)
    if longest < options.calm * thickness:
        return max(rounds // 2, 1)
    return rounds
