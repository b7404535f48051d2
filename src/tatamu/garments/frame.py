"""From the axes of a file to those of a garment: x away from the hem, y to the left, z up from the table."""

from __future__ import annotations

import numpy as np

AWAY = {"y": (0, 1), "-y": (0, -1), "x": (1, 0), "-x": (-1, 0)}
"""Directions of a file's x-y plane that can point away from the hem."""
FLAT = 0.03
"""A mesh is flat if it is at most this part of its width thick."""


def turned(points: np.ndarray, up: str) -> np.ndarray:
    """Points (n, 2) or (n, 3) of a file turned about z so that its direction `up` becomes +x."""
    cosine, sine = AWAY[up]
    out = points.astype(float).copy()
    out[:, 0] = cosine * points[:, 0] + sine * points[:, 1]
    out[:, 1] = -sine * points[:, 0] + cosine * points[:, 1]
    return out
