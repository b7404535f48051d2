"""Triangles to pixels: which triangle is seen where. A z-buffer in NumPy, for pictures without a browser.

Notation: image x to the right, y down [pixels]; depth grows towards the eye.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


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
    """From the eye to the centre [m]."""

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
    """Its number, -1 where there is none, shape (h, w)."""
    weights: np.ndarray
    """Barycentric coordinates in it, shape (h, w, 3)."""

    @property
    def mask(self) -> np.ndarray:
        """Where any triangle is, shape (h, w)."""
        return self.face >= 0

    def sample(self, values: np.ndarray, faces: np.ndarray) -> np.ndarray:
        """Interpolate values at vertices, shape (n,) or (n, k), over the covered pixels, (p,) or (p, k)."""
        corners = values[faces[self.face[self.mask]]]
        return np.einsum("pc,pc...->p...", self.weights[self.mask], corners)


def rasterise(projected: np.ndarray, faces: np.ndarray, shape: tuple[int, int]) -> Visible:
    """Draw triangles (m, 3) with corners `projected` (x, y, depth), shape (n, 3)."""
    face = np.full(shape, -1, dtype=np.int64)
    weights, nearest = np.zeros((*shape, 3)), np.full(shape, -np.inf)
    corners = projected[faces]
    low = np.clip(np.floor(corners[:, :, 1::-1].min(axis=1) - 0.5), 0, shape).astype(int)
    high = np.clip(np.ceil(corners[:, :, 1::-1].max(axis=1) + 0.5), 0, shape).astype(int)
    for number in np.flatnonzero((high > low).all(axis=1)):
        window = tuple(slice(*span) for span in zip(low[number], high[number], strict=True))
        inside = _barycentric(corners[number], window)
        if inside is None:
            continue
        depth = inside @ corners[number, :, 2]
        seen = (inside.min(axis=-1) >= 0) & (depth > nearest[window])
        nearest[window][seen] = depth[seen]
        face[window][seen] = number
        weights[window][seen] = inside[seen]
    return Visible(face, weights)


def _barycentric(corners: np.ndarray, window: tuple[slice, ...]) -> np.ndarray | None:
    """Barycentric coordinates of the pixel centres in a window, shape (h, w, 3); None for an edge-on triangle."""
    (ax, ay), (bx, by), (cx, cy) = corners[:, :2]
    twice_area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
    if abs(twice_area) < 1e-12:
        return None
    y = np.arange(window[0].start, window[0].stop)[:, None] + 0.5
    x = np.arange(window[1].start, window[1].stop)[None, :] + 0.5
    b = ((x - ax) * (cy - ay) - (cx - ax) * (y - ay)) / twice_area
    c = ((bx - ax) * (y - ay) - (x - ax) * (by - ay)) / twice_area
    return np.stack([1.0 - b - c, b, c], axis=-1)


def vertex_normals(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Unit normals at the vertices, weighted by area, shape (n, 3)."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    normals = np.zeros_like(points)
    across = np.cross(b - a, c - a)
    for k in range(3):
        np.add.at(normals, faces[:, k], across)
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
