"""The state of contact: the mesh, candidate pairs, recent activity, and counters.

All arrays are allocated once and grouped in NamedTuples, which compiled loops accept. Only one module writes each
record at a time; a table in the docstring of this package lists these modules.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

PARTNERS = 3
"""Largest number of triangles from which contact keeps a vertex apart.

They are the nearest triangle below, the nearest triangle above, and a further triangle that the vertex touches."""
BELOW = 0
ABOVE = 1
EXTRA = 2
"""Column of the third triangle of a vertex in arrays such as `VertexFace.triangle`.

Contact keeps a vertex apart from up to three triangles. Their columns are BELOW for the nearest triangle below the
vertex, ABOVE for the nearest triangle above it, and EXTRA for a further triangle that it touches."""


class ContactMesh(NamedTuple):
    """The mesh with n vertices, m triangles and e edges. Only `inverse_mass` changes during a rollout."""

    faces: np.ndarray
    """Numbers of the vertices of every triangle, shape (m, 3)."""
    neighbours: np.ndarray
    """For each corner of a triangle, the triangle beyond the opposite edge; -1 at a border, shape (m, 3)."""
    near_start: np.ndarray
    """Start of each vertex's entries in `near`, shape (n + 1,)."""
    near: np.ndarray
    """Numbers of the triangles near each vertex, for all vertices one after another."""
    edges: np.ndarray
    """Numbers of the two vertices of every edge, shape (e, 2)."""
    edge_faces: np.ndarray
    """Numbers of the triangles at every edge, shape (e, 2). The second is -1 at a border."""
    face_edges: np.ndarray
    """Numbers of the three edges of every triangle, shape (m, 3)."""
    inverse_mass: np.ndarray
    """Inverse mass of every vertex [1/kg], shape (n,). It is 0 for a vertex that is held."""
    friction: float
    """Coulomb coefficient mu of cloth on cloth [-]."""
    thickness: float
    """Distance of two layers that rest on each other [m]."""
    search_distance: float
    """Distance within which a search finds candidates [m]: the thickness plus the margin."""
    triangle_radius: float
    """Upper bound on the distance from the centroid of a triangle to a corner, for all triangles [m]."""


class VertexFace(NamedTuple):
    """The partners of each of the n vertices. They are triangles from which contact keeps the vertex apart.

    The broad phase searches the partners, and each sweep updates them. A vertex has at most PARTNERS partners.
    """

    triangle: np.ndarray
    """Numbers of the triangles from which contact keeps a vertex apart, shape (n, PARTNERS).

    Entries that are not needed are -1."""
    side: np.ndarray
    """Side of the triangle on which the vertex is, shape (n, PARTNERS).

    The side is +1 where the normal points, -1 on the opposite side, or 0 if it is unknown."""
    wake: np.ndarray
    """Value of `counters.travelled` at which the vertex and the triangle must be tested again [m], shape (n, PARTNERS).

    `counters.travelled` is a bound on the approach of any two vertices since the search. While it is smaller than this
    value, the vertex cannot be too near to the triangle."""
    meets: np.ndarray
    """Path length at which the vertex and the triangle must be tested again [m], shape (n, PARTNERS).

    While their path length is smaller, the vertex cannot be too near to the triangle. The path length of a pair is the
    path of the vertex plus the longest path of a corner of the triangle, since the search."""
    awake: np.ndarray
    """Numbers of the pairs that the first sweep of the present round tested.

    Pair k of vertex v has the number PARTNERS v + k.

    The first `counters.partners_awake` entries are in use."""
    anchor_triangle: np.ndarray
    """Triangle to which friction holds the vertex, -1 if the vertex has no friction anchor, shape (n, PARTNERS)."""
    anchor: np.ndarray
    """Friction anchor: a point on `anchor_triangle` in barycentric coordinates, shape (n, PARTNERS, 3).

    Friction pulls the vertex towards this point."""
    order: np.ndarray
    """Vertices that contact keeps apart from any triangle, sorted by height, the highest first, shape (n,).

    The first `counters.ordered` entries are in use."""


class EdgeEdge(NamedTuple):
    """The p pairs of edges that contact keeps apart.

    The broad phase finds the pairs. The first sweep of each round puts distant pairs to sleep.
    """

    pairs: np.ndarray
    """Ends of both edges of each pair, starting with the guarded edge, shape (p, 4).

    The first `counters.pairs` rows are in use."""
    wake: np.ndarray
    """Value of `counters.travelled` at which the two edges of a pair must be tested again [m], shape (p,).

    `counters.travelled` is a bound on the approach of any two vertices since the search. While it is smaller than this
    value, the edges cannot be too near to each other."""
    meets: np.ndarray
    """Path length at which the two edges of a pair must be tested again [m], shape (p,).

    While their path length is smaller, the edges cannot be too near to each other. The path length of a pair is the sum
    of two paths since the search: for each edge, the longer path of its two ends."""
    awake: np.ndarray
    """Numbers of the pairs that the first sweep of the present round left awake. Only these pairs are tested.

    The first `counters.pairs_awake` entries are in use."""
    guarded: np.ndarray
    """Whether each of the e edges of the mesh is guarded and has been paired, shape (e,)."""


class VertexMotion(NamedTuple):
    """Motion of the n vertices since the last search for candidates, relative to their mean motion.

    The module `motion` updates all fields at the start of each round of contact. Before cloth that passed through cloth
    is set back (`impact_zones`), it updates `reach` once more.
    """

    path: np.ndarray
    """Length of each vertex's path since the search [m], shape (n,).

    The path connects the positions at the starts of the rounds of contact."""
    reach: np.ndarray
    """Length of each vertex's path plus its motion in the present round of contact [m], shape (n,)."""
    legal: np.ndarray
    """Positions at the start of the present round, as the last round of contact corrected them [m], shape (n, 3)."""
    searched_at: np.ndarray
    """Positions at the last search for candidates [m], shape (n, 3)."""


class Activity(NamedTuple):
    """Recent effects of contact on each vertex. Every correction of positions updates these numbers.

    Each array has one number per vertex.
    """

    touched: np.ndarray
    """Number of the last sweep that moved the vertex noticeably."""
    restless: np.ndarray
    """Number of the last outer step in which the vertex is tested for passing through cloth."""
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
"""Type of the record of counters, for example of outer steps and sweeps.

The counters are in a record because compiled loops cannot write to fields of a NamedTuple."""


class ContactState(NamedTuple):
    """The state that contact keeps between steps."""

    vertex_face: VertexFace
    edge_edge: EdgeEdge
    activity: Activity
    motion: VertexMotion
    counters: Any
    """Counters, for example of outer steps and sweeps. They are a record of the type `COUNTERS`."""


def initial_state(mesh: ContactMesh, pairs_per_edge: int) -> ContactState:
    """Return the state before any search. It has memory for `pairs_per_edge` edge pairs per edge of the mesh."""
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
