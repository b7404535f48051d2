"""Triangles as pixels. A triangle covers a pixel (i, j) if the centre (i + 0.5, j + 0.5) lies in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit


@dataclass(frozen=True)
class ZBuffer:
    """The highest triangle over each pixel of a grid."""

    heights: np.ndarray
    """Height at the centre of each pixel, shape (columns, rows); -inf if no triangle covers it."""
    face: np.ndarray
    """Index of the highest triangle, shape (columns, rows); -1 if no triangle covers the centre."""
    weights: np.ndarray
    """Barycentric coordinates of each pixel's centre in its triangle, shape (columns, rows, 3)."""


def z_buffer(points: np.ndarray, faces: np.ndarray, shape: tuple[int, int], slack: float = 0.0) -> ZBuffer:
    """Return the highest triangle over each pixel of a grid with `shape` columns and rows.

    The coordinates of points are columns, rows [pixels] and heights. `slack` is a tolerance in barycentric coordinates
    against gaps that rounding would cause between triangles.
    """
    heights = np.full(shape, -np.inf)
    face = np.full(shape, -1, dtype=np.int64)
    weights = np.zeros((*shape, 3))
    _fill(np.ascontiguousarray(points, dtype=float), faces, slack, heights, face, weights)
    return ZBuffer(heights, face, weights)


def mask(points: np.ndarray, faces: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Return which pixels are covered by a triangle, shape (columns, rows), with points in pixels."""
    covered = np.zeros(shape, dtype=np.bool_)
    _cover(np.ascontiguousarray(points, dtype=float), faces, covered)
    return covered


@njit(inline="always")
def _range(a, b, c, size):  # type: ignore[no-untyped-def]
    """Return the pixels that a triangle with the coordinates a, b, c may cover along an axis of `size` pixels."""
    return range(int(max(min(a, b, c), 0.0)), int(min(max(a, b, c) + 1.0, size)))


@njit(cache=True)
def _cover(points, faces, covered):  # type: ignore[no-untyped-def]
    columns, rows = covered.shape
    for t in range(faces.shape[0]):
        ax, ay = points[faces[t, 0]]
        bx, by = points[faces[t, 1]]
        cx, cy = points[faces[t, 2]]
        for i in _range(ax, bx, cx, columns):
            for j in _range(ay, by, cy, rows):
                x = i + 0.5
                y = j + 0.5
                ab = (bx - ax) * (y - ay) - (by - ay) * (x - ax)  # twice the signed areas of the point with each side,
                bc = (cx - bx) * (y - by) - (cy - by) * (x - bx)  # which have the same sign if the point is inside
                ca = (ax - cx) * (y - cy) - (ay - cy) * (x - cx)
                if (ab >= 0 and bc >= 0 and ca >= 0) or (ab <= 0 and bc <= 0 and ca <= 0):
                    covered[i, j] = True


@njit(cache=True)
def _fill(points, faces, slack, heights, face, weights):  # type: ignore[no-untyped-def]
    columns, rows = heights.shape
    for t in range(faces.shape[0]):
        ax, ay, az = points[faces[t, 0]]
        bx, by, bz = points[faces[t, 1]]
        cx, cy, cz = points[faces[t, 2]]
        twice_area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if not 1e-9 <= abs(twice_area) < np.inf:  # seen edge-on, or not finite
            continue
        for i in _range(ax, bx, cx, columns):
            for j in _range(ay, by, cy, rows):
                x = i + 0.5
                y = j + 0.5
                v = ((x - ax) * (cy - ay) - (y - ay) * (cx - ax)) / twice_area
                w = ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / twice_area
                if v < -slack or w < -slack or v + w > 1.0 + slack:
                    continue
                z = az + v * (bz - az) + w * (cz - az)
                if z > heights[i, j]:
                    heights[i, j] = z
                    face[i, j] = t
                    weights[i, j, 0] = 1.0 - v - w
                    weights[i, j, 1] = v
                    weights[i, j, 2] = w
