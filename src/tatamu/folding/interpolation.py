"""Interpolation of a garment's state to the vertices of another mesh of it."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from tatamu.garments import Garment

CANDIDATES = 12
"""How many nearby triangles are tried in the search for the one round a point."""


def interpolated(garment: Garment, state: np.ndarray, other: Garment) -> np.ndarray:
    """Return the positions of a garment at the vertices of another mesh [m], shape (m, 3), each found in its layer."""
    found = np.empty((len(other.vertices), 3))
    for up in (False, True):
        faces = garment.faces[_face_up(garment) == up]
        vertices = np.unique(other.faces[_face_up(other) == up])
        if len(vertices):
            found[vertices] = _in_triangles(garment.vertices[:, :2], faces, other.vertices[vertices, :2], state)
    return found


def _in_triangles(flat: np.ndarray, faces: np.ndarray, points: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return values of flat vertices at p points, shape (p, 3); outside the mesh, those of a nearby triangle."""
    corners = flat[faces]
    count = min(CANDIDATES, len(faces))
    _, near = cKDTree(corners.mean(axis=1)).query(points, count)
    near = near.reshape(len(points), count)
    a, b, c = (corners[near, k] for k in range(3))
    to_a, to_b, to_c = (corner - points[:, None] for corner in (a, b, c))
    weights = np.stack([_cross(to_b, to_c), _cross(to_c, to_a)]) / _cross(b - a, c - a)
    shares = np.stack([*weights, 1.0 - weights.sum(axis=0)], axis=2)
    chosen = shares.min(axis=2).argmax(axis=1)
    row = np.arange(len(points))
    inside = np.maximum(shares[row, chosen], 0.0)
    inside /= inside.sum(axis=1, keepdims=True)
    return np.einsum("pk,pkx->px", inside, values[faces[near[row, chosen]]])


def _face_up(garment: Garment) -> np.ndarray:
    a, b, c = (garment.vertices[garment.faces[:, k], :2] for k in range(3))
    return _cross(b - a, c - a) > 0


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
