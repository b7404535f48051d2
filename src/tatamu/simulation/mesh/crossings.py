"""Crossings of a cloth with itself: edges that pass through triangles with which they share no vertex.

The ends of such an edge lie strictly on opposite sides of the triangle's plane, and its line passes strictly between
the triangle's sides, which the signs of the volumes of five tetrahedra show. A hashed grid gives the candidates.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from tatamu.simulation.mesh.topology import Topology


def crossing_pairs(
    points: np.ndarray, faces: np.ndarray, edges: np.ndarray, wanted: tuple[np.ndarray, np.ndarray] | None = None
) -> np.ndarray:
    """Return the crossing pairs of an edge and a triangle, shape (k, 2), for finite points.

    `wanted` tells which triangles and which edges are wanted. A pair is found if one of both is, and the order of the
    pairs stays the same.
    """
    wanted_faces, wanted_edges = wanted or (np.ones(len(faces), bool), np.ones(len(edges), bool))
    return _find(np.ascontiguousarray(points, dtype=np.float64), faces, edges, wanted_faces, wanted_edges)


def crossings(points: np.ndarray, faces: np.ndarray, edges: np.ndarray | None = None) -> int:
    """Return the number of crossings, of all edges by default; every edge counts if a position is not finite."""
    edges = Topology(faces).edges if edges is None else edges
    return len(crossing_pairs(points, faces, edges)) if np.isfinite(points).all() else len(edges)


def crossings_over_time(positions: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the number of crossings in each frame, shape (f,), from positions of the shape (f, n, 3)."""
    edges = Topology(faces).edges
    return np.array([crossings(points, faces, edges) for points in positions])


@njit(cache=True)
def _volume(p: np.ndarray, q: np.ndarray, r: np.ndarray, s: np.ndarray) -> float:
    """Return six times the signed volume of a tetrahedron [m^3]."""
    ax, ay, az = q[0] - p[0], q[1] - p[1], q[2] - p[2]
    bx, by, bz = r[0] - p[0], r[1] - p[1], r[2] - p[2]
    cx, cy, cz = s[0] - p[0], s[1] - p[1], s[2] - p[2]
    return ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)


@njit(cache=True)
def _cross(p: np.ndarray, q: np.ndarray, a: np.ndarray, b: np.ndarray, c: np.ndarray) -> bool:
    """Return whether the edge p-q passes strictly through the triangle (a, b, c)."""
    if not _volume(a, b, c, p) * _volume(a, b, c, q) < 0.0:
        return False
    u = _volume(p, q, a, b)
    v = _volume(p, q, b, c)
    w = _volume(p, q, c, a)
    return (u > 0.0 and v > 0.0 and w > 0.0) or (u < 0.0 and v < 0.0 and w < 0.0)


@njit(cache=True)
def _find(
    points: np.ndarray,
    faces: np.ndarray,
    edges: np.ndarray,
    wanted_faces: np.ndarray,
    wanted_edges: np.ndarray,
) -> np.ndarray:
    """Return the crossing pairs of an edge and a triangle, shape (k, 2).

    Every edge is hashed by the cell with the lower corner of its bounding box, whose sides are at most those of a cell.
    A wanted triangle is tested against all edges of nearby cells, another one only against the wanted edges.
    """
    low = np.empty((edges.shape[0], 3))
    high = np.empty((edges.shape[0], 3))
    cell = 1e-9
    origin = np.full(3, np.inf)
    nearest = np.full(3, np.inf)  # the box of all wanted edges
    farthest = np.full(3, -np.inf)
    for e in range(edges.shape[0]):
        for d in range(3):
            low[e, d] = min(points[edges[e, 0], d], points[edges[e, 1], d])
            high[e, d] = max(points[edges[e, 0], d], points[edges[e, 1], d])
            cell = max(cell, high[e, d] - low[e, d])
            origin[d] = min(origin[d], low[e, d])
            if wanted_edges[e]:
                nearest[d] = min(nearest[d], low[e, d])
                farthest[d] = max(farthest[d], high[e, d])
    size = 1
    while size < 2 * edges.shape[0]:
        size *= 2
    head = np.full((2, size), -1)  # first edge of each hash bucket: of all edges, and of the wanted edges
    after = np.full((2, edges.shape[0]), -1)  # next edge in the same bucket
    key = np.empty((edges.shape[0], 3), np.int64)
    for e in range(edges.shape[0]):
        for d in range(3):
            key[e, d] = int(np.floor((low[e, d] - origin[d]) / cell))
        bucket = (key[e, 0] * 73856093 ^ key[e, 1] * 19349663 ^ key[e, 2] * 83492791) & (size - 1)
        for kind in range(1 + wanted_edges[e]):
            after[kind, e] = head[kind, bucket]
            head[kind, bucket] = e
    found = [(0, 0) for _ in range(0)]
    first = np.empty(3, np.int64)
    last = np.empty(3, np.int64)
    least = np.empty(3)
    most = np.empty(3)
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        kind = 0 if wanted_faces[f] else 1
        for d in range(3):
            least[d] = min(points[a, d], points[b, d], points[c, d])
            most[d] = max(points[a, d], points[b, d], points[c, d])
            first[d] = int(np.floor((least[d] - cell - origin[d]) / cell))
            last[d] = int(np.floor((most[d] - origin[d]) / cell))
        apart = False
        for d in range(3):
            apart = apart or least[d] > farthest[d] or most[d] < nearest[d]
        if kind == 1 and apart:
            continue
        for i in range(first[0], last[0] + 1):
            for j in range(first[1], last[1] + 1):
                for k in range(first[2], last[2] + 1):
                    e = head[kind, (i * 73856093 ^ j * 19349663 ^ k * 83492791) & (size - 1)]
                    while e >= 0:
                        p, q = edges[e, 0], edges[e, 1]
                        apart = p == a or p == b or p == c or q == a or q == b or q == c
                        apart = apart or key[e, 0] != i or key[e, 1] != j or key[e, 2] != k
                        for d in range(3):
                            apart = apart or low[e, d] > most[d] or high[e, d] < least[d]
                        if not apart and _cross(points[p], points[q], points[a], points[b], points[c]):
                            found.append((e, f))
                        e = after[kind, e]
    pairs = np.empty((len(found), 2), np.int64)
    for i, (e, f) in enumerate(found):
        pairs[i, 0] = e
        pairs[i, 1] = f
    return pairs
