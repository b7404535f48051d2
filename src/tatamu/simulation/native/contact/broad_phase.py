"""Broad phase of contact: finds the parts of the cloth that may touch.

Candidates (pairs of mesh elements that may touch) are found with a grid. The search also finds pairs that do not touch,
but whose distance exceeds the contact distance by at most a margin. Therefore the candidates stay complete until two
parts of the cloth may have come closer by this margin. Until then, no new search is needed. Only relative motion
counts: if a hand carries a cloth away as a whole, no new search is needed either.
"""

from __future__ import annotations

import numpy as np

from tatamu.simulation.native.addresses import Addresses
from tatamu.simulation.native.compiled import allocating, call, kernel
from tatamu.simulation.native.contact import motion
from tatamu.simulation.native.contact.projection import Positions
from tatamu.simulation.native.contact.state import ContactMesh, ContactState
from tatamu.simulation.native.options import ContactOptions

KEPT_APART = 1.5
"""Distance within which the list of candidate pairs must always be complete, in thicknesses of the cloth.

The distance of the search minus this distance is the margin. Two parts of the cloth can approach each other by the
margin before the next search."""


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
    """Find the partners of every vertex, and the pairs of guarded edges.

    The array x contains the positions of the n vertices [m], shape (n, 3). In these positions every vertex is on the
    correct side of all layers.
    """
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
    """Follow the motion of the vertices, and search candidates again if they are worn out.

    Candidates are pairs of mesh elements that may touch. They are worn out when two vertices may have come closer by
    most of the margin since the search. The new search uses the positions at the start of the round. If no search is
    necessary but edges have come under pressure since the last search, only these edges are paired.
    """
    motion.follow(positions, contact)
    margin = mesh.search_distance - KEPT_APART * mesh.thickness
    if motion.worn_out(positions.x, contact, options.margin_wear * margin):
        search(positions.start, mesh, contact, options, kernels)
        motion.follow(positions, contact)
    elif contact.counters.newly_pressed:
        call(kernels.search_edges, None, (positions.start, mesh, contact, options))
