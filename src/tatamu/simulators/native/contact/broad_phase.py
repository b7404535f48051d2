"""Broad phase: which parts of the cloth may touch.

Candidates are found with a grid and kept while they are sure to be complete: as long as no two parts of the cloth can
have come closer by the margin since they were searched. What counts is relative motion; a cloth that a hand carries
away as a whole wears nothing out.
"""

from __future__ import annotations

import numpy as np

from tatamu.simulators.native.compiled import kernel
from tatamu.simulators.native.contact import edge_edge_search, vertex_face_search
from tatamu.simulators.native.contact.projection import Positions
from tatamu.simulators.native.contact.shape import shape_of
from tatamu.simulators.native.contact.state import ContactMesh, ContactState
from tatamu.simulators.native.options import ContactOptions

KEPT_APART = 1.5
"""Thicknesses of the search distance that motion may not use up: pairs are known before they are too close."""


@kernel
def _relative_motion(x: np.ndarray, start: np.ndarray) -> float:
    """A bound on how far any two vertices moved against each other [m]: the diagonal of the box of displacements."""
    low_x, low_y, low_z = np.inf, np.inf, np.inf
    high_x, high_y, high_z = -np.inf, -np.inf, -np.inf
    for v in range(x.shape[0]):
        dx = x[v, 0] - start[v, 0]
        dy = x[v, 1] - start[v, 1]
        dz = x[v, 2] - start[v, 2]
        low_x = min(low_x, dx)
        low_y = min(low_y, dy)
        low_z = min(low_z, dz)
        high_x = max(high_x, dx)
        high_y = max(high_y, dy)
        high_z = max(high_z, dz)
    return np.sqrt((high_x - low_x) ** 2 + (high_y - low_y) ** 2 + (high_z - low_z) ** 2)


@kernel
def _order_by_height(x: np.ndarray, contact: ContactState) -> None:
    """Order the vertices with partners from the highest down, see `vertex_face.sweep`."""
    triangle = contact.vertex_face.triangle
    near = np.flatnonzero((triangle[:, 0] >= 0) | (triangle[:, 1] >= 0) | (triangle[:, 2] >= 0))
    contact.vertex_face.order[: near.shape[0]] = near[np.argsort(-x[near, 2])]
    contact.counters.ordered = near.shape[0]


@kernel
def search(x: np.ndarray, mesh: ContactMesh, contact: ContactState, options: ContactOptions) -> None:
    """Find the partners of every vertex, and the pairs of guarded edges, at legal positions x [m], shape (n, 3)."""
    shape = shape_of(x, mesh.faces)
    counters = contact.counters
    pressed = contact.activity.pressed
    vertex_face_search.search(x, mesh, contact.vertex_face, shape, options)
    counters.pairs = edge_edge_search.search(x, mesh, contact.edge_edge, pressed, shape, options)
    _order_by_height(x, contact)
    counters.travelled = 0.0
    counters.due = 0.0
    counters.newly_pressed = False
    contact.searched_at[:] = x
    for v in range(x.shape[0]):
        pressed[v] = max(pressed[v] - 1, 0)


@kernel
def refresh(positions: Positions, mesh: ContactMesh, contact: ContactState, options: ContactOptions) -> None:
    """Count the motion since the start of the step; search again, at the start, if candidates are worn out.

    They are when two vertices may have come closer by the margin since the search. What swings to and fro counts as
    travelled, by which pairs that sleep are woken, but does not wear them out.
    """
    counters = contact.counters
    motion = _relative_motion(positions.x, positions.start)
    limit = mesh.search_distance - KEPT_APART * mesh.thickness
    counters.travelled += motion
    if not counters.newly_pressed:
        if counters.travelled <= counters.due:
            return
        away = _relative_motion(positions.x, contact.searched_at)
        if away < options.margin_wear * limit:
            counters.due = counters.travelled + limit - away
            return
    search(positions.start, mesh, contact, options)
    counters.travelled = motion
    counters.due = limit
