"""Triangles to pixels: which triangle is seen where. A z-buffer in NumPy, for pictures without a browser.

Notation: image x to the right, y down [pixels]; depth grows towards the eye.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

BLOCK = 300_000
"""About how many pixels are looked at together; bounds the memory."""


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
    face, nearest = np.full(shape, -1, dtype=np.int64), np.full(shape, -np.inf)
    weights = np.zeros((*shape, 3))
    corners = projected[faces]
    low = np.clip(np.floor(corners[:, :, :2].min(axis=1) - 0.5), 0, shape[::-1]).astype(int)
    high = np.clip(np.ceil(corners[:, :, :2].max(axis=1) + 0.5), 0, shape[::-1]).astype(int)
    for block in _blocks((high - low).prod(axis=1)):
        owner, column, row = _candidates(block, low, high)
        shares = _barycentric(corners[owner], column + 0.5, row + 0.5)
        inside = np.flatnonzero(shares.min(axis=1) >= 0)
        owner, column, row, shares = owner[inside], column[inside], row[inside], shares[inside]
        depth = np.einsum("pc,pc->p", shares, corners[owner, :, 2])
        kept = _front(row * shape[1] + column, depth)
        kept = kept[depth[kept] > nearest[row[kept], column[kept]]]
        at = row[kept], column[kept]
        nearest[at], face[at], weights[at] = depth[kept], owner[kept], shares[kept]
    return Visible(face, weights)


def _blocks(areas: np.ndarray) -> list[np.ndarray]:
    """Triangles in groups whose windows hold about BLOCK pixels together."""
    drawn = np.flatnonzero(areas > 0)
    group = np.cumsum(areas[drawn]) // BLOCK
    return np.split(drawn, np.flatnonzero(np.diff(group)) + 1) if len(drawn) else []


def _candidates(block: np.ndarray, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, ...]:
    """Triangle, column and row of every pixel in the windows of some triangles, shapes (p,)."""
    width, height = (high - low)[block].T
    owner = np.repeat(block, width * height)
    first = np.cumsum(width * height) - width * height
    place = np.arange(len(owner)) - np.repeat(first, width * height)
    across = np.repeat(width, width * height)
    return owner, low[owner, 0] + place % across, low[owner, 1] + place // across


def _barycentric(corners: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Barycentric coordinates of places in their triangles, shape (p, 3); -1 where edge-on."""
    a, b, c = (corners[:, k, :2] for k in range(3))
    (ux, uy), (vx, vy) = (b - a).T, (c - a).T
    wx, wy = x - a[:, 0], y - a[:, 1]
    twice_area = ux * vy - vx * uy
    flat = np.abs(twice_area) < 1e-12
    safe = np.where(flat, 1.0, twice_area)
    second, third = (wx * vy - vx * wy) / safe, (ux * wy - wx * uy) / safe
    weights = np.column_stack([1.0 - second - third, second, third])
    return np.where(flat[:, None], -1.0, weights)


def _front(pixel: np.ndarray, depth: np.ndarray) -> np.ndarray:
    """The nearest candidate of each pixel, as indices."""
    order = np.lexsort((depth, pixel))
    sorted_pixel = pixel[order]
    return order[np.append(sorted_pixel[1:] != sorted_pixel[:-1], True)[: len(order)]]


def vertex_normals(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Unit normals at the vertices, weighted by area, shape (n, 3)."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    normals = np.zeros_like(points)
    across = np.cross(b - a, c - a)
    for k in range(3):
        np.add.at(normals, faces[:, k], across)
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
