"""The state of contact: the mesh, candidate pairs, recent activity, and counters.

All arrays are allocated once and grouped in NamedTuples, which compiled loops accept. One module writes each record in
the course of a step; see the table in the docstring of this package.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

PARTNERS = 3
"""Triangles that a vertex is kept from: the nearest below, the nearest above, and one that would be lost."""
BELOW = 0
ABOVE = 1
EXTRA = 2
"""Their numbers among the partners of a vertex."""


class ContactMesh(NamedTuple):
    """The mesh as contact needs it; only `inverse_mass` changes during a rollout."""

    faces: np.ndarray
    """Triangles, shape (m, 3)."""
    neighbours: np.ndarray
    """Triangle across the edge opposite each corner, -1 at a border, shape (m, 3)."""
    near_start: np.ndarray
    """Start of each vertex's entries in `near`, shape (n + 1,)."""
    near: np.ndarray
    """Triangles within two rings of each vertex."""
    edges: np.ndarray
    """Shape (e, 2)."""
    edge_faces: np.ndarray
    """The triangles of each edge, -1 for none, shape (e, 2)."""
    face_edges: np.ndarray
    """Shape (m, 3)."""
    inverse_mass: np.ndarray
    """[1/kg], shape (n,); 0 of a vertex that is held."""
    friction: float
    """Coulomb coefficient mu of cloth on cloth [-]."""
    thickness: float
    """Distance t of layers at rest [m]."""
    search_distance: float
    """A thickness and the margin [m]: whatever is nearer than this in a search becomes a candidate."""
    triangle_radius: float
    """Longest distance from the centroid of a triangle to a corner [m]."""


class VertexFace(NamedTuple):
    """Vertices against triangles: the partners of each vertex. Searched by the broad phase, written by each sweep."""

    triangle: np.ndarray
    """Partners of each vertex, -1 for none, shape (n, PARTNERS)."""
    side: np.ndarray
    """Side of the triangle's normal on which the vertex is, +1 or -1, or 0 if unknown; shape (n, PARTNERS)."""
    wake: np.ndarray
    """Value of `counters.travelled` before which the pair cannot be too near [m], shape (n, PARTNERS)."""
    meets: np.ndarray
    """Lengths of both its paths, together, before which it cannot be [m], shape (n, PARTNERS)."""
    awake: np.ndarray
    """Pairs that the last first sweep tested, as PARTNERS v + k; `counters.partners_awake` of them are in use."""
    anchor_triangle: np.ndarray
    """Triangle that friction holds the vertex to, -1 for none, shape (n, PARTNERS)."""
    anchor: np.ndarray
    """Friction anchor: where on that triangle, barycentric, shape (n, PARTNERS, 3)."""
    order: np.ndarray
    """Vertices with a partner, the highest first, shape (n,); `counters.ordered` of them are in use."""


class EdgeEdge(NamedTuple):
    """Edges against edges. Searched by the broad phase, put to sleep by each first sweep."""

    pairs: np.ndarray
    """Ends of both edges, those of the guarded edge first, shape (p, 4); `counters.pairs` of them are in use."""
    wake: np.ndarray
    """Value of `counters.travelled` before which the pair cannot be too near [m], shape (p,)."""
    meets: np.ndarray
    """Lengths of both its paths, together, before which it cannot be [m], shape (p,)."""
    awake: np.ndarray
    """Numbers of the pairs that the last first sweep left awake; `counters.pairs_awake` of them are in use."""
    guarded: np.ndarray
    """Whether an edge was paired, shape (e,)."""


class VertexMotion(NamedTuple):
    """Motion of the vertices since the search, relative to the mean; see `motion`.

    Written at the start of each round, and the reach once more before impact zones.
    """

    path: np.ndarray
    """Length of each vertex's path through legal positions [m], shape (n,)."""
    reach: np.ndarray
    """Path plus the distance to the predicted or corrected position in this round [m], shape (n,)."""
    legal: np.ndarray
    """Positions at the start of the round [m], shape (n, 3)."""
    searched_at: np.ndarray
    """Positions at which candidates were searched [m], shape (n, 3)."""


class Activity(NamedTuple):
    """Lately done to each vertex by contact, shape (n,) each. Written by whatever corrects positions."""

    touched: np.ndarray
    """Number of the last sweep that moved the vertex noticeably."""
    restless: np.ndarray
    """Number of the outer step until which the vertex may pass through something in spite of contact."""
    pressed: np.ndarray
    """Number of further searches for which all edges at the vertex are guarded."""


COUNTERS = np.dtype(
    [
        ("outer_step", np.int64),  # outer steps made
        ("sweep", np.int64),  # Gauss-Seidel sweeps made
        ("rounds", np.int64),  # how often contact is resolved per outer step
        ("ordered", np.int64),  # vertices in `VertexFace.order`
        ("pairs", np.int64),  # pairs in `EdgeEdge.pairs`
        ("partners_awake", np.int64),  # pairs in `VertexFace.awake`
        ("pairs_awake", np.int64),  # pairs in `EdgeEdge.awake`
        ("longest_path", np.float64),  # twice the sum of the longest steps between legal positions since the search [m]
        ("travelled", np.float64),  # that, and twice the longest way from there in this round [m]
        ("due", np.float64),  # value of `travelled` at which candidates may be worn out [m]
        ("newly_pressed", np.bool_),  # whether a vertex is pressed whose edges are not yet guarded
    ],
    align=True,
)
"""Changing numbers, in a record because compiled loops cannot write to fields of a NamedTuple."""


class ContactState(NamedTuple):
    """All that contact remembers from step to step."""

    vertex_face: VertexFace
    edge_edge: EdgeEdge
    activity: Activity
    motion: VertexMotion
    counters: Any
    """A record of type `COUNTERS`."""


def initial_state(mesh: ContactMesh, pairs_per_edge: int) -> ContactState:
    """Return the state before any search, with memory for this number of edge pairs per edge of the mesh."""
    count = len(mesh.inverse_mass)
    room = pairs_per_edge * len(mesh.edges)
    counters = np.zeros(1, dtype=COUNTERS).view(np.recarray)[0]
    counters.rounds = 1
    return ContactState(
        vertex_face=VertexFace(
            triangle=np.full((count, PARTNERS), -1),
            side=np.zeros((count, PARTNERS), dtype=np.int64),
            wake=np.zeros((count, PARTNERS)),
            meets=np.zeros((count, PARTNERS)),
            awake=np.zeros(count * PARTNERS, dtype=np.int64),
            anchor_triangle=np.full((count, PARTNERS), -1),
            anchor=np.zeros((count, PARTNERS, 3)),
            order=np.arange(count),
        ),
        edge_edge=EdgeEdge(
            pairs=np.empty((room, 4), dtype=np.int64),
            wake=np.empty(room),
            meets=np.empty(room),
            awake=np.empty(room, dtype=np.int64),
            guarded=np.zeros(len(mesh.edges), dtype=np.bool_),
        ),
        activity=Activity(
            touched=np.zeros(count, dtype=np.int64),
            restless=np.zeros(count, dtype=np.int64),
            pressed=np.zeros(count, dtype=np.int64),
        ),
        motion=VertexMotion(
            path=np.zeros(count),
            reach=np.zeros(count),
            legal=np.zeros((count, 3)),
            searched_at=np.zeros((count, 3)),
        ),
        counters=counters,
    )
