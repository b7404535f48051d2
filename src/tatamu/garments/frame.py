"""Rotation from the axes of a file to those of a garment: x away from the hem, y to the left, z up from the table."""

from __future__ import annotations

from typing import Literal

import numpy as np

Axis = Literal["x", "-x", "y", "-y", "z", "-z"]
FLAT = 0.03
"""Largest thickness of a flat mesh, as a fraction of its width."""
SQUARE = np.sin(np.radians(1.0))
"""A grain line that lies this near to square across points neither up nor down."""


def direction(axis: str) -> np.ndarray:
    """Unit vector of an axis of a file, shape (3,)."""
    return (-1.0 if axis.startswith("-") else 1.0) * np.eye(3)["xyz".index(axis[-1])]


def plane_turn(up: str, grain: np.ndarray | None = None) -> np.ndarray:
    """Return the rotation of a file's x-y plane after which `up`, or the grain line, points along +x, shape (2, 2).

    Args:
        up: The file's direction away from the hem.
        grain: Direction of the grain line in the file; of its two senses the one nearer to `up` is taken, and where
            it lies square across, the one towards its second point.
    """
    ahead = direction(up)[:2]
    if grain is not None:
        along = float(grain @ ahead)
        ahead = grain if along >= -SQUARE else -grain
    return np.array([[ahead[0], ahead[1]], [-ahead[1], ahead[0]]])


def turned(points: np.ndarray, up: str) -> np.ndarray:
    """Return points (n, 3) of a file turned about z so that its direction `up`, x or y, becomes +x."""
    out = points.astype(float).copy()
    out[:, :2] = points[:, :2] @ plane_turn(up).T
    return out
