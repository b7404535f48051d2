"""A pinch: fingers that close press the layers between them together, one on the other."""

from __future__ import annotations

import numpy as np

SAME_PLACE = 0.55
"""What is nearer than this many cells from above lies over or under one another."""
APART = 1.05
"""Pressed layers are this many thicknesses apart."""
NOTICEABLE = 1.0
"""What is pressed down by less than this many thicknesses stays as it lies."""


def pressed(points: np.ndarray, thickness: float, spacing: float) -> np.ndarray:
    """How far closing fingers move what is between them.

    A vertex comes to lie as many thicknesses over the lowest as there are vertices under it. Layers that lie flat on
    each other stay where they are.

    Args:
        points: The vertices under the finger pad [m], shape (k, 3).
        thickness: Of the cloth [m].
        spacing: Of its mesh [m].

    Returns:
        By how much each moves up [m], shape (k,); negative or zero, zero for the lowest.
    """
    height = points[:, 2]
    beside = np.linalg.norm(points[:, None, :2] - points[None, :, :2], axis=2) < SAME_PLACE * spacing
    under = (beside & (height[None, :] < height[:, None] - 0.5 * thickness)).sum(axis=1)
    moved = np.minimum(height.min() + APART * thickness * under - height, 0.0)
    return np.where(moved < -NOTICEABLE * thickness, moved, 0.0)
