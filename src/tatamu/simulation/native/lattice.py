"""The vertices of a mesh that form a triangular lattice, and their positions on it.

Two triangles that share an edge form a parallelogram, so three of its corners on the lattice determine the fourth. From
one triangle, this is repeated up to the border, a seam or an irregular vertex. What remains may form another patch.
"""

from __future__ import annotations

from collections import deque
from math import dist
from typing import NamedTuple

import numpy as np

MIN_PATCH = 40
"""Minimum number of vertices in a patch; smaller ones are not worth a band."""
SKEW = 0.35
"""Maximum distance of the fourth corner of a parallelogram from its position on the lattice [shared edges]."""

Places = dict[int, tuple[int, int]]


class Patch(NamedTuple):
    """One piece of the lattice, with rows along one of its directions and every second one shifted by half a cell."""

    vertices: np.ndarray
    row: np.ndarray
    """Row of each vertex, counted from 0."""
    column: np.ndarray


def patches(rest: np.ndarray, hinges: np.ndarray) -> list[Patch]:
    """Return the disjoint patches of a mesh, each with the direction of rows that leaves fewest places empty."""
    points = rest.tolist()
    quads = hinges.tolist()
    around: list[list[int]] = [[] for _ in points]
    for h, quad in enumerate(quads):
        for v in quad:
            around[v].append(h)
    mesh = _Mesh(points, quads, around, [False] * len(points))
    found = []
    for quad in quads:
        if not any(mesh.taken[v] for v in quad) and mesh.skew(*quad) < SKEW:
            places = _grow(quad[:3], mesh)
            if len(places) >= MIN_PATCH:
                found.append(_patch(places))
    return found


class _Mesh(NamedTuple):
    points: list[list[float]]
    quads: list[list[int]]
    around: list[list[int]]
    """Hinges at each vertex."""
    taken: list[bool]
    """Whether each vertex is in a piece of the lattice, which may be too small for a patch."""

    def skew(self, a: int, b: int, c: int, d: int) -> float:
        """Return the distance of vertex d from its lattice position a + b - c [lengths of the edge (a, b)]."""
        p, q, r, s = (self.points[v] for v in (a, b, c, d))
        return dist([i + j - k for i, j, k in zip(p, q, r, strict=True)], s) / dist(p, q)


def _grow(seed: list[int], mesh: _Mesh) -> Places:
    """Return the lattice coordinates (i, j) of all vertices that can be reached from the triangle `seed`."""
    places = dict(zip(seed, ((0, 0), (1, 0), (0, 1)), strict=True))
    full = set(places.values())
    queue = deque(seed)
    while queue:
        queue += _place_around(queue.popleft(), mesh, places, full, SKEW)
    for v in list(places):
        _place_around(v, mesh, places, full, 0.7)  # at a border that cuts through cells
    for v in places:
        mesh.taken[v] = True
    return places


def _place_around(v: int, mesh: _Mesh, places: Places, full: set[tuple[int, int]], skew: float) -> list[int]:
    """Place and return the vertices whose positions follow from the other three of a hinge at vertex v."""
    new = []
    for h in mesh.around[v]:
        a, b, c, d = mesh.quads[h]
        if d in places:
            c, d = d, c
        if d in places or c not in places or a not in places or b not in places or mesh.taken[d]:
            continue
        i, j = (places[a][k] + places[b][k] - places[c][k] for k in (0, 1))
        if (i, j) not in full and mesh.skew(a, b, c, d) < skew:
            places[d] = i, j
            full.add((i, j))
            new.append(d)
    return new


def _patch(places: Places) -> Patch:
    """Arrange vertices in rows along the direction with the smallest rectangle of rows and columns."""
    vertices = np.array(list(places))
    i, j = np.array(list(places.values())).T
    best = None
    for along, across in ((i, j), (i + j, -i), (j, -i - j)):
        row = across - across.min()
        for lean in (0, 1):
            column = along + (row + lean) // 2
            size = (row.max() + 1) * (np.ptp(column) + 1)
            if best is None or size < best[0]:
                best = size, Patch(vertices, row, column - column.min())
    assert best is not None
    return best[1]
