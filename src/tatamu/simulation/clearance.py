"""The distance between cloth and a rigid body. Faces are tested too, because a thin finger may pierce a triangle.

The signed distance of a body is convex, so its tangent planes at the corners of a triangle are lower bounds over the
triangle. If no bound decides, nested golden sections find the minimum: the inner one along a line parallel to a side,
the outer one over the position of this line, because the minimum along the line is convex in its position.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tatamu.simulation.body import Body


def deepest(body: Body, points: np.ndarray, faces: np.ndarray, time: float = 0.0) -> float:
    """Return the depth of the cloth's mid-surface in a body at a time [s], in metres; negative outside."""
    return -float(distances(body, points, faces, time, below=0.0).min())


def distances(body: Body, points: np.ndarray, faces: np.ndarray, time: float, below: float = np.inf) -> np.ndarray:
    """Return the minimum signed distance of each triangle from a body at a time [s], in metres, shape (m,).

    For a triangle that is entirely farther than `below` [m], it is the distance of the nearest corner.
    """
    local = body.local(points, time)
    at_vertices = body.distance(local)
    least = np.asarray(at_vertices[faces].min(axis=1))
    unclear = np.flatnonzero(_bound(body, local, at_vertices, faces) < below)
    if len(unclear):
        least[unclear] = np.minimum(least[unclear], _minimum(body, local[faces[unclear]]))
    return least


def _bound(body: Body, local: np.ndarray, at_vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return a lower bound of each triangle's distance [m], shape (m,), from tangent planes at its corners."""
    normals = _normals(body, local)
    corners = local[faces]
    bounds = [
        (np.einsum("mk,mck->mc", normals[faces[:, c]], corners - corners[:, c, None]).min(axis=1))
        + at_vertices[faces[:, c]]
        for c in range(3)
    ]
    return np.asarray(np.max(bounds, axis=0))


def _normals(body: Body, local: np.ndarray) -> np.ndarray:
    """Return the unit normal of a body's surface near each of n points, in the frame of the body, shape (n, 3)."""
    q = np.abs(local) - body.core
    signs = np.where(local >= 0.0, 1.0, -1.0)
    outside = np.maximum(q, 0.0)
    length = np.linalg.norm(outside, axis=1, keepdims=True)
    inside = np.eye(3)[np.argmax(q, axis=1)]
    return np.asarray(signs * np.where(length > 0.0, outside / np.maximum(length, 1e-300), inside))


def _minimum(body: Body, corners: np.ndarray) -> np.ndarray:
    """Return the minimum distance from each triangle [m], shape (k,); its corners are in the body's frame."""
    a, b, c = (corners[:, k] for k in range(3))

    def along(part: np.ndarray) -> np.ndarray:
        """Return the minimum along a line parallel to the side b-c, at `part` of the way from the corner a to it."""
        start = a + part[:, None] * (b - a)
        side = part[:, None] * (c - b)
        return _golden(lambda s: body.distance(start + s[:, None] * side), len(a))

    return _golden(along, len(a))


def _golden(values: Callable[[np.ndarray], np.ndarray], count: int) -> np.ndarray:
    """Return the minima of `count` convex functions on the interval from 0 to 1, shape (count,)."""
    golden = 0.5 * (np.sqrt(5.0) - 1.0)
    low, high = np.zeros(count), np.ones(count)
    left, right = high - golden * (high - low), low + golden * (high - low)
    at_left, at_right = values(left), values(right)
    least = np.minimum(np.minimum(values(low), values(high)), np.minimum(at_left, at_right))
    for _ in range(24):  # sections reduce 20 mm to 0.2 micrometres
        lower = at_left < at_right
        high = np.where(lower, right, high)
        low = np.where(lower, low, left)
        left, right = high - golden * (high - low), low + golden * (high - low)
        at_left, at_right = values(left), values(right)
        least = np.minimum(least, np.minimum(at_left, at_right))
    return np.asarray(least)
