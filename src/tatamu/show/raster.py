"""Finds the triangle that is visible at each pixel (z-buffer), for pictures that are drawn without a browser.

In the image, x points to the right and y points down [pixels]. The depth increases towards the eye.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array

from tatamu.simulation.mesh.zbuffer import z_buffer


@dataclass(frozen=True)
class View:
    """A camera that looks at the point `centre`; the projection is parallel if `distance` is infinite."""

    centre: np.ndarray
    """Point in the middle of the image [m], shape (3,)."""
    rotation: np.ndarray
    """Directions right, up and towards the eye, as the rows of a rotation matrix, shape (3, 3)."""
    scale: float
    """Pixels per metre at the centre."""
    shape: tuple[int, int]
    """Height and width of the image [pixels]."""
    distance: float = np.inf
    """Distance from the eye to the centre [m]."""

    def project(self, points: np.ndarray) -> np.ndarray:
        """Return x, y [pixels] and the depth of points [m], shape (n, 3)."""
        right, up, near = (points - self.centre).dot(self.rotation.T).T
        # Inside a triangle, the depth is interpolated linearly. The depth 1 / distance is linear over the image.
        shrink = 1.0 / (1.0 - near / self.distance)
        depth = near if np.isinf(self.distance) else shrink
        height, width = self.shape
        x, y = right * shrink * self.scale + width / 2, height / 2 - up * shrink * self.scale
        return np.column_stack([x, y, depth])

    def towards_eye(self, points: np.ndarray) -> np.ndarray:
        """Return the unit vectors from points to the eye, shape (n, 3)."""
        if np.isinf(self.distance):
            return np.broadcast_to(self.rotation[2], points.shape)
        away = self.centre + self.distance * self.rotation[2] - points
        return away / np.linalg.norm(away, axis=1, keepdims=True)


@dataclass(frozen=True)
class Visible:
    """The triangle that is visible at each pixel of an image."""

    face: np.ndarray
    """Number of the nearest triangle in each pixel, shape (h, w); -1 if no triangle covers the pixel."""
    weights: np.ndarray
    """Barycentric coordinates of each pixel in its triangle, shape (h, w, 3)."""

    @cached_property
    def mask(self) -> np.ndarray:
        """Whether a triangle covers each pixel, shape (h, w)."""
        return self.face >= 0

    @cached_property
    def covered(self) -> tuple[np.ndarray, np.ndarray]:
        """Triangle of each of the p covered pixels, shape (p,), and barycentric coordinates in it, shape (p, 3)."""
        return self.face[self.mask], self.weights[self.mask]

    def sample(self, values: np.ndarray, faces: np.ndarray) -> np.ndarray:
        """Interpolate values at the vertices, shape (n,) or (n, k), to the covered pixels, shape (p,) or (p, k)."""
        face, weights = self.covered
        ends = np.arange(0, weights.size + 1, 3)
        return np.asarray(csr_array((weights.ravel(), faces[face].ravel(), ends), (len(face), len(values))) @ values)


def rasterise(projected: np.ndarray, faces: np.ndarray, shape: tuple[int, int]) -> Visible:
    """Return the nearest triangle in each pixel, from x, y and the depth of each vertex, shape (n, 3)."""
    seen = z_buffer(projected[:, [1, 0, 2]], faces, shape)
    return Visible(seen.face, seen.weights)


def vertex_normals(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the unit normals at the vertices, shape (n, 3): means over adjacent triangles, weighted by area."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    normals = np.zeros_like(points)
    across = np.cross(b - a, c - a)
    for k in range(3):
        np.add.at(normals, faces[:, k], across)
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
