"""The shape of the cloth for the searches of contact: normals, centroids and radii of triangles."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tatamu.simulation.native.compiled import allocating
from tatamu.simulation.native.geometry import TINY_LENGTH, dot, normal_of, unit


class Shape(NamedTuple):
    """Normals, centroids and radii of the m triangles, and normals of the n vertices, at given positions."""

    face_normal: np.ndarray
    """Unit normal of every triangle, shape (m, 3)."""
    vertex_normal: np.ndarray
    """Unit normal of every vertex: the mean of the normals of its triangles, weighted by area, shape (n, 3)."""
    centroid: np.ndarray
    """Centroid of every triangle [m], shape (m, 3)."""
    radius: np.ndarray
    """Longest distance from the centroid of a triangle to a corner [m], shape (m,)."""


@allocating
def shape_of(x: np.ndarray, faces: np.ndarray) -> Shape:
    """Return the shape of the cloth at positions x of the n vertices [m], shape (n, 3)."""
    n = x.shape[0]
    m = faces.shape[0]
    face_normal = np.empty((m, 3))
    vertex_normal = np.zeros((n, 3))
    centroid = np.empty((m, 3))
    radius = np.empty(m)
    for t in range(m):
        a, b, c = faces[t, 0], faces[t, 1], faces[t, 2]
        nx, ny, nz = normal_of(x, a, b, c)
        face_normal[t, 0], face_normal[t, 1], face_normal[t, 2] = unit(nx, ny, nz)
        mx = (x[a, 0] + x[b, 0] + x[c, 0]) / 3.0
        my = (x[a, 1] + x[b, 1] + x[c, 1]) / 3.0
        mz = (x[a, 2] + x[b, 2] + x[c, 2]) / 3.0
        centroid[t, 0] = mx
        centroid[t, 1] = my
        centroid[t, 2] = mz
        square = 0.0
        for v in (a, b, c):
            vertex_normal[v, 0] += nx
            vertex_normal[v, 1] += ny
            vertex_normal[v, 2] += nz
            square = max(square, (x[v, 0] - mx) ** 2 + (x[v, 1] - my) ** 2 + (x[v, 2] - mz) ** 2)
        radius[t] = np.sqrt(square)
    for v in range(n):
        scale = 1.0 / (np.sqrt(dot(vertex_normal[v], vertex_normal[v])) + TINY_LENGTH)
        for k in range(3):
            vertex_normal[v, k] *= scale
    return Shape(face_normal, vertex_normal, centroid, radius)
