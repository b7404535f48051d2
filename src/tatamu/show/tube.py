"""Makes a tube around a path, because a line in a picture needs a width and a light side."""

from __future__ import annotations

import numpy as np


def tube(path: np.ndarray, radius: float, sides: int = 10) -> tuple[np.ndarray, np.ndarray]:
    """Return the points [m], shape (k, 3), and the triangles, shape (m, 3), of a tube around a path, shape (f, 3)."""
    path = _spaced(path, radius)
    along = np.gradient(path, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    # The direction must never be along the path. A hand stays near the vertical plane through the ends of its path,
    # so the direction is across this plane.
    span = path[-1] - path[0]
    side = np.cross(along, [-span[1], span[0], 0.0] if np.hypot(span[0], span[1]) > radius else [0.0, 1.0, 0.0])
    side /= np.maximum(np.linalg.norm(side, axis=1, keepdims=True), 1e-9)
    angles = 2 * np.pi * np.arange(sides) / sides
    ring = np.cos(angles)[:, None, None] * side + np.sin(angles)[:, None, None] * np.cross(side, along)
    points = (path + radius * ring).transpose(1, 0, 2).reshape(-1, 3)
    return points, _bands(len(path), sides)


def _spaced(path: np.ndarray, apart: float) -> np.ndarray:
    """Return those points of a path that are at least `apart` [m] away from the previously returned point."""
    kept = [path[0]]
    for place in path[1:]:
        if np.linalg.norm(place - kept[-1]) >= apart:
            kept.append(place)
    return np.array(kept if len(kept) > 1 else [path[0], path[0] + [apart, 0.0, 0.0]])


def _bands(count: int, sides: int) -> np.ndarray:
    """Return the triangles of a tube, which connect neighbouring rings of points around the path, and face outwards."""
    first = np.arange(sides)
    after = (first + 1) % sides
    band = np.vstack(
        [
            np.column_stack([first, after, first + sides]),
            np.column_stack([after, after + sides, first + sides]),
        ]
    )
    return np.vstack([band + ring * sides for ring in range(count - 1)])
