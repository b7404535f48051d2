"""Broad phase of contact: finds the parts of the cloth that may touch, by a grid.

The search also finds pairs that are farther apart than the contact distance by at most a margin, so candidates stay
complete until two parts of the cloth may have come closer by this margin. Only relative motion counts: a cloth that a
hand carries away as a whole needs no new search.
"""

from __future__ import annotations

import numpy as np

from tatamu.simulation.native.addresses import Addresses
from tatamu.simulation.native.compiled import allocating, call, kernel
from tatamu.simulation.native.contact import motion
from tatamu.simulation.native.contact.projection import Positions
from tatamu.simulation.native.contact.state import ContactMesh, ContactState
from tatamu.simulation.native.options import ContactOptions


@allocating
def order_by_height(x: np.ndarray, contact: ContactState) -> None:
    """Order the vertices with partners from the highest down, as `vertex_face.sweep` needs them."""
    triangle = contact.vertex_face.triangle
    near = np.flatnonzero((triangle[:, 0] >= 0) | (triangle[:, 1] >= 0) | (triangle[:, 2] >= 0))
    contact.vertex_face.order[: near.shape[0]] = near[np.argsort(-x[near, 2])]
    contact.counters.ordered = near.shape[0]


@kernel
def search(
    x: np.ndarray, mesh: ContactMesh, contact: ContactState, options: ContactOptions, kernels: Addresses
) -> None:
    """Find the partners of every vertex, and the pairs of guarded edges, at legal positions x [m]."""
    pressed = contact.activity.pressed
    call(kernels.search_partners, None, (x, mesh, contact.vertex_face, options))
    for e in range(contact.edge_edge.guarded.shape[0]):
        contact.edge_edge.guarded[e] = False
    contact.counters.pairs = 0
    call(kernels.search_edges, None, (x, mesh, contact, options))
    call(kernels.order_by_height, None, (x, contact))
    motion.begin(x, contact)
    for v in range(x.shape[0]):
        pressed[v] = max(pressed[v] - 1, 0)


@kernel
def refresh(
    positions: Positions, mesh: ContactMesh, contact: ContactState, options: ContactOptions, kernels: Addresses
) -> None:
    """Follow the motion, and search candidates again if two vertices may have come closer by most of the margin.

    The search uses the positions at the start of the round. If only edges have come under pressure, only these are
    paired.
    """
    motion.follow(positions, contact)
    # candidates must always be complete within 1.5 thicknesses; the margin is the rest of the search distance
    margin = mesh.search_distance - 1.5 * mesh.thickness
    if motion.worn_out(positions.x, contact, options.margin_wear * margin):
        search(positions.start, mesh, contact, options, kernels)
        motion.follow(positions, contact)
    elif contact.counters.newly_pressed:
        call(kernels.search_edges, None, (positions.start, mesh, contact, options))
