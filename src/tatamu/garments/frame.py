"""Rotations from the axes of a file to those of a garment: x points away from the hem, y to the left, z up."""

from __future__ import annotations

from typing import Literal

import numpy as np

Axis = Literal["x", "-x", "y", "-y", "z", "-z"]
FLAT = 0.03
"""Largest thickness of a mesh that counts as flat, as a fraction of its width."""


def direction(axis: str) -> np.ndarray:
    """Return the unit vector along an axis of a file, such as -y, shape (3,)."""
    return (-1.0 if axis.startswith("-") else 1.0) * np.eye(3)["xyz".index(axis[-1])]


def plane_turn(up: str, grain: np.ndarray | None = None) -> np.ndarray:
    """Return the rotation of a file's x-y plane that turns `up`, or a grain line, to +x, shape (2, 2).

    A grain line that points away from `up` is reversed, but not one perpendicular to it.
    """
    ahead = direction(up)[:2]
    if grain is not None:
        along = float(grain @ ahead)
        ahead = grain if along >= -np.sin(np.radians(1.0)) else -grain
    return np.array([[ahead[0], ahead[1]], [-ahead[1], ahead[0]]])


def turned(points: np.ndarray, up: str) -> np.ndarray:
    """Rotate points of a file about z so that `up` (along x or y) becomes +x, shape (n, 3)."""
    out = points.astype(float).copy()
    out[:, :2] = points[:, :2] @ plane_turn(up).T
    return out
