"""Which parts of the cloth may touch: candidate pairs, found with a grid and kept while they are sure to be complete.

Every vertex has two slots, one per side, for the nearest triangle that is not its own (`nearest`). Borders, creased
edges and edges that are pressed are paired with all edges near them (`ridges`). The lists hold as long as no two parts
of the cloth can have come closer by the margin.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from tatamu.simulators.native.contact import edge_edge_search as ridges
from tatamu.simulators.native.contact import vertex_face_search as nearest

SLOTS = 3
"""Triangles that a vertex is kept from: the nearest below, the nearest above, and one that would be lost."""
WORN = 0.8
"""Lists are made anew once this part of their margin may be used up."""
PRESSED_FOR = 4
"""Searches for which the edges at a pressed vertex stay guarded."""


class Mesh(NamedTuple):
    """What contact needs to know of the mesh; it never changes during a rollout."""

    faces: np.ndarray  # (m, 3)
    neighbours: np.ndarray  # (m, 3): triangle across the edge opposite each corner, -1 at a border
    near_start: np.ndarray  # (n + 1,): where a vertex's entries in `near` begin
    near: np.ndarray  # triangles within two rings of each vertex
    edges: np.ndarray  # (e, 2)
    edge_faces: np.ndarray  # (e, 2): the triangles of each edge, -1 for none
    face_edges: np.ndarray  # (m, 3)
    inverse_mass: np.ndarray  # (n,); 0 while held
    reach: np.ndarray  # (3,): thickness, margin of the lists, largest distance from centroid to corner


class Lists(NamedTuple):
    """Candidate pairs, and how far they may be relied on."""

    face: np.ndarray  # (n, SLOTS): triangle in each slot, -1 for none
    side: np.ndarray  # (n, SLOTS): +1 or -1, 0 while not known
    order: np.ndarray  # (n,): vertices with a triangle in a slot, the highest first
    ordered: np.ndarray  # (1,): how many they are
    wake: np.ndarray  # (n, SLOTS): travelled distance at which the pair must be looked at again
    pairs: np.ndarray  # (p, 4): edge pairs, the ends of the guarded edge first
    pair_wake: np.ndarray  # (p,)
    used: np.ndarray  # (1,): edge pairs in use
    pressed: np.ndarray  # (n,): for how many searches to come all edges at the vertex are guarded
    call: np.ndarray  # (1,): whether a vertex has been pressed whose edges are not yet guarded
    touched: np.ndarray  # (n,): number of the last sweep that moved the vertex noticeably
    sweeps: np.ndarray  # (1,): sweeps so far
    anchor_face: np.ndarray  # (n, SLOTS): triangle that the vertex sticks to, -1 for none
    anchor: np.ndarray  # (n, SLOTS, 3): where it sticks on it, barycentric
    travelled: np.ndarray  # (1,): bound on the way of any vertex against any other since the search
    due: np.ndarray  # (1,): travelled distance at which the lists may be worn out
    built: np.ndarray  # (n, 3): positions that they were made at
    restless: np.ndarray  # (n,): outer step until which the vertex counts as restless
    number: np.ndarray  # (1,): outer steps so far


@njit(cache=True, error_model="numpy")
def _relative_motion(x, before):  # type: ignore[no-untyped-def]
    """A bound on how far any two vertices moved against each other: the diagonal of the box of all displacements."""
    ax, ay, az = np.inf, np.inf, np.inf
    bx, by, bz = -np.inf, -np.inf, -np.inf
    for v in range(x.shape[0]):
        dx, dy, dz = x[v, 0] - before[v, 0], x[v, 1] - before[v, 1], x[v, 2] - before[v, 2]
        ax, ay, az = min(ax, dx), min(ay, dy), min(az, dz)
        bx, by, bz = max(bx, dx), max(by, dy), max(bz, dz)
    return np.sqrt((bx - ax) ** 2 + (by - ay) ** 2 + (bz - az) ** 2)


@njit(cache=True, error_model="numpy")
def _put_in_order(x, lists):  # type: ignore[no-untyped-def]
    near = np.flatnonzero((lists.face[:, 0] >= 0) | (lists.face[:, 1] >= 0) | (lists.face[:, 2] >= 0))
    lists.ordered[0] = near.shape[0]
    lists.order[: near.shape[0]] = near[np.argsort(-x[near, 2])]


@njit(cache=True, error_model="numpy")
def search(x, mesh, lists):  # type: ignore[no-untyped-def]
    """Find the nearest triangle on either side of every vertex, and the pairs of guarded edges, at legal x."""
    face_normal, vertex_normal, centroid, radius = nearest.normals(x, mesh.faces)
    nearest.find(x, mesh, lists, face_normal, vertex_normal, centroid, radius)
    ridges.find(x, mesh, lists, face_normal, centroid, radius)
    _put_in_order(x, lists)
    lists.travelled[0], lists.due[0], lists.call[0] = 0.0, 0.0, False
    lists.built[:] = x
    for v in range(x.shape[0]):
        lists.pressed[v] = max(lists.pressed[v] - 1, 0)


@njit(cache=True, error_model="numpy")
def refresh(x, before, mesh, lists):  # type: ignore[no-untyped-def]
    """Count the motion from `before` to x; search again at the legal positions `before` if the lists are worn out.

    They are when two vertices may have come closer by the margin since they were made: what swings to and fro counts
    as travelled, but does not wear them out.
    """
    motion, limit = _relative_motion(x, before), mesh.reach[1] - 1.5 * mesh.reach[0]
    lists.travelled[0] += motion
    if not lists.call[0]:
        if lists.travelled[0] <= lists.due[0]:
            return
        away = _relative_motion(x, lists.built)
        if away < WORN * limit:
            lists.due[0] = lists.travelled[0] + limit - away
            return
    search(before, mesh, lists)
    lists.travelled[0] = motion
    lists.due[0] = limit
