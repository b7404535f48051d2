"""A z-buffer for pictures without a browser: the triangle that is visible at each pixel.

Notation: image x to the right, y down [pixels]; depth grows towards the eye.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tatamu.zbuffer import z_buffer


@dataclass(frozen=True)
class View:
    """An eye that looks at `centre` from the direction `rotation[2]`; `distance` = inf sees in parallel."""

    centre: np.ndarray
    """[m], shape (3,); lands in the middle of the image."""
    rotation: np.ndarray
    """World to eye, shape (3, 3): rows right, up, towards the eye."""
    scale: float
    """Pixels per metre at the centre."""
    shape: tuple[int, int]
    """Height and width of the image [pixels]."""
    distance: float = np.inf
    """Distance from the eye to the centre [m]."""

    def project(self, points: np.ndarray) -> np.ndarray:
        """Image x, y [pixels] and depth of points [m], both of shape (n, 3)."""
        right, up, near = (points - self.centre).dot(self.rotation.T).T
        # Depth as 1 / distance is linear over the image, as the interpolation inside a triangle needs it.
        shrink = 1.0 / (1.0 - near / self.distance)
        depth = near if np.isinf(self.distance) else shrink
        height, width = self.shape
        x, y = right * shrink * self.scale + width / 2, height / 2 - up * shrink * self.scale
        return np.column_stack([x, y, depth])

    def towards_eye(self, points: np.ndarray) -> np.ndarray:
        """Unit vectors from points to the eye, shape (n, 3)."""
        if np.isinf(self.distance):
            return np.broadcast_to(self.rotation[2], points.shape)
        away = self.centre + self.distance * self.rotation[2] - points
        return away / np.linalg.norm(away, axis=1, keepdims=True)


@dataclass(frozen=True)
class Visible:
    """The nearest triangle in each pixel."""

    face: np.ndarray
    """Number of the triangle, -1 if there is none, shape (h, w)."""
    weights: np.ndarray
    """Barycentric coordinates in it, shape (h, w, 3)."""

    @cached_property
    def mask(self) -> np.ndarray:
        """The pixels that any triangle covers, shape (h, w)."""
        return self.face >= 0

    @cached_property
    def covered(self) -> tuple[np.ndarray, np.ndarray]:
        """Triangle and barycentric coordinates of the covered pixels, shapes (p,) and (p, 3)."""
        return self.face[self.mask], self.weights[self.mask]

    def sample(self, values: np.ndarray, faces: np.ndarray) -> np.ndarray:
        """Interpolate values at vertices, shape (n,) or (n, k), over the covered pixels, (p,) or (p, k)."""
        face, weights = self.covered
        return np.einsum("pc,pc...->p...", weights, values[faces[face]])


def rasterise(projected: np.ndarray, faces: np.ndarray, shape: tuple[int, int]) -> Visible:
    """Draw triangles (m, 3) with corners `projected` (x, y, depth), shape (n, 3)."""
    seen = z_buffer(projected[:, [1, 0, 2]], faces, shape)
    return Visible(seen.face, seen.weights)


def vertex_normals(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Unit normals at the vertices, weighted by area, shape (n, 3)."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    normals = np.zeros_like(points)
    across = np.cross(b - a, c - a)
    for k in range(3):
        np.add.at(normals, faces[:, k], across)
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
