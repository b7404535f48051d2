"""The state of contact: the mesh, candidate pairs, recent activity, and counters.

Arrays are allocated once. The docstring of this package tells which module writes each record.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

PARTNERS = 3
"""Maximum number of triangles from which contact keeps a vertex apart."""
BELOW = 0
ABOVE = 1
EXTRA = 2
"""Columns of partners: the nearest triangle below a vertex, the nearest above it, and another one that it touches."""


class ContactMesh(NamedTuple):
    """The mesh of n vertices, m triangles and e edges, of which only `inverse_mass` changes during a rollout."""

    faces: np.ndarray
    """Vertices of every triangle, shape (m, 3)."""
    neighbours: np.ndarray
    """Triangle beyond the edge opposite each corner, shape (m, 3); -1 at a border."""
    near_start: np.ndarray
    """Start of each vertex's entries in `near`, shape (n + 1,)."""
    near: np.ndarray
    """Triangles near each vertex, for all vertices one after another."""
    edges: np.ndarray
    """Vertices of every edge, shape (e, 2)."""
    edge_faces: np.ndarray
    """Triangles at every edge, shape (e, 2); the second is -1 at a border."""
    face_edges: np.ndarray
    """Edges of every triangle, shape (m, 3)."""
    inverse_mass: np.ndarray
    """Inverse mass of every vertex [1/kg], shape (n,); 0 for a vertex that is held."""
    friction: float
    """Coulomb coefficient mu of cloth on cloth [-]."""
    thickness: float
    """Distance of two layers that rest on each other [m]."""
    search_distance: float
    """Distance within which a search finds candidates [m]: the thickness plus the margin."""
    triangle_radius: float
    """Upper bound on the distance from a triangle's centroid to a corner [m]."""


class VertexFace(NamedTuple):
    """The partners of each vertex: at most PARTNERS triangles from which contact keeps it apart."""

    triangle: np.ndarray
    """Partners, shape (n, PARTNERS); -1 for none."""
    side: np.ndarray
    """Side of the vertex, shape (n, PARTNERS): +1 where the normal points, -1 opposite, 0 if unknown."""
    wake: np.ndarray
    """Value of `counters.travelled`, a bound on any approach since the search, at which a pair is tested again [m].

    The shape is (n, PARTNERS)."""
    meets: np.ndarray
    """Path of the vertex plus the longest path of a corner at which a pair is tested again [m], shape (n, PARTNERS)."""
    awake: np.ndarray
    """Pairs that the first sweep of the round tested, as PARTNERS v + k; `counters.partners_awake` are in use."""
    anchor_triangle: np.ndarray
    """Triangle to which friction holds the vertex, shape (n, PARTNERS); -1 for none."""
    anchor: np.ndarray
    """Point on this triangle to which friction pulls, in barycentric coordinates, shape (n, PARTNERS, 3)."""
    order: np.ndarray
    """Vertices with partners, the highest first, shape (n,); `counters.ordered` are in use."""


class EdgeEdge(NamedTuple):
    """The p pairs of edges that contact keeps apart, of which distant ones sleep."""

    pairs: np.ndarray
    """Ends of both edges of each pair, first of the guarded edge, shape (p, 4); `counters.pairs` rows are in use."""
    wake: np.ndarray
    """Value of `counters.travelled` at which a pair is tested again [m], shape (p,)."""
    meets: np.ndarray
    """Sum over both edges of the longer path of an end at which a pair is tested again [m], shape (p,)."""
    apart: np.ndarray
    """Distance at the start of the round [m], shape (p,); 0 for pairs that sleep."""
    awake: np.ndarray
    """Pairs that the first sweep of the round left awake; `counters.pairs_awake` are in use."""
    guarded: np.ndarray
    """Whether each edge is guarded and has been paired, shape (e,)."""


class VertexMotion(NamedTuple):
    """Motion of the vertices since the last search for candidates, relative to their mean motion."""

    path: np.ndarray
    """Length of the path through positions at the starts of rounds [m], shape (n,)."""
    reach: np.ndarray
    """Length of the path plus the motion in the present round [m], shape (n,)."""
    legal: np.ndarray
    """Positions at the start of the present round [m], shape (n, 3)."""
    searched_at: np.ndarray
    """Positions at the last search for candidates [m], shape (n, 3)."""


class Activity(NamedTuple):
    """Recent effects of contact on each vertex."""

    touched: np.ndarray
    """Last sweep that moved the vertex noticeably."""
    restless: np.ndarray
    """Last outer step in which the vertex is tested for passing through cloth."""
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
        ("longest_path", np.float64),  # twice the sum of the longest motion in each round since the search [m]
        ("travelled", np.float64),  # longest_path plus twice the longest motion within this round [m]
        ("due", np.float64),  # value of `travelled` at which candidates may be worn out [m]
        ("newly_pressed", np.bool_),  # whether any pressed vertex has edges that are not guarded yet
    ],
    align=True,
)
"""Type of the counters, a record because compiled loops cannot write to fields of a NamedTuple."""


class ContactState(NamedTuple):
    """The state that contact keeps between steps."""

    vertex_face: VertexFace
    edge_edge: EdgeEdge
    activity: Activity
    motion: VertexMotion
    counters: Any
    """A record of the type `COUNTERS`."""


def initial_state(mesh: ContactMesh, pairs_per_edge: int) -> ContactState:
    """Return the state before any search, with memory for `pairs_per_edge` edge pairs per edge."""
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
            apart=np.empty(room),
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
