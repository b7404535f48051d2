"""The vertices of a mesh that form a triangular lattice, and their places on it.

Two triangles that share an edge make a parallelogram: three corners placed on the lattice place the fourth. From a
first triangle this continues until borders, seams and irregular vertices. The remaining triangles may form another
patch.
"""

from __future__ import annotations

from collections import deque
from math import dist
from typing import NamedTuple

import numpy as np

SMALLEST_PATCH = 40
"""Patches of fewer vertices are not worth a band of their own."""
SKEW = 0.35
"""Largest distance of a fourth corner from its place on the lattice, as part of the shared edge."""
EDGE_SKEW = 0.7
"""The same for the last vertices at a border that cuts through cells."""

Places = dict[int, tuple[int, int]]


class Patch(NamedTuple):
    """Vertices of one piece of lattice; rows run along x, row r + 1 lies half a cell to the right of row r."""

    vertices: np.ndarray
    row: np.ndarray
    """Counted from 0."""
    column: np.ndarray


def patches(rest: np.ndarray, hinges: np.ndarray) -> list[Patch]:
    """The pieces of lattice of a mesh, each vertex in one at most, rows chosen so that rectangles are well filled."""
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
            if len(places) >= SMALLEST_PATCH:
                found.append(_patch(places))
    return found


class _Mesh(NamedTuple):
    points: list[list[float]]
    quads: list[list[int]]
    around: list[list[int]]
    """Hinges at each vertex."""
    taken: list[bool]
    """Vertices that are in a patch, or in too small a one."""

    def skew(self, a: int, b: int, c: int, d: int) -> float:
        """Return the distance of d from a + b - c, in lengths of the edge (a, b)."""
        p, q, r, s = (self.points[v] for v in (a, b, c, d))
        return dist([i + j - k for i, j, k in zip(p, q, r, strict=True)], s) / dist(p, q)


def _grow(seed: list[int], mesh: _Mesh) -> Places:
    """Axial coordinates (i, j) of every vertex that can be placed, starting with a triangle."""
    places = dict(zip(seed, ((0, 0), (1, 0), (0, 1)), strict=True))
    full = set(places.values())
    queue = deque(seed)
    while queue:
        queue += _place_around(queue.popleft(), mesh, places, full, SKEW)
    for v in list(places):
        _place_around(v, mesh, places, full, EDGE_SKEW)
    for v in places:
        mesh.taken[v] = True
    return places


def _place_around(v: int, mesh: _Mesh, places: Places, full: set[tuple[int, int]], skew: float) -> list[int]:
    """Place the vertices that a hinge at v determines, and return them."""
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
    """Rows along that direction of the lattice that needs the smallest rectangle."""
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
