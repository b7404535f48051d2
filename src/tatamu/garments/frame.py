"""Rotations from the axes of a file to the axes of a garment.

The x axis of a garment points away from the hem, y points to the left, and z points up from the table.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

Axis = Literal["x", "-x", "y", "-y", "z", "-z"]
FLAT = 0.03
"""Largest thickness of a mesh that counts as flat, as a fraction of its width."""
SQUARE = np.sin(np.radians(1.0))
"""Sine of an angle of one degree.

If a grain line deviates by less than this angle from the direction across the piece, it counts as exactly across.
"""


def direction(axis: str) -> np.ndarray:
    """Return the unit vector in the direction of an axis of a file, such as -y, shape (3,)."""
    return (-1.0 if axis.startswith("-") else 1.0) * np.eye(3)["xyz".index(axis[-1])]


def plane_turn(up: str, grain: np.ndarray | None = None) -> np.ndarray:
    """Return the rotation of a file's x-y plane that turns the direction `up` to +x, shape (2, 2).

    If a grain line is given, the grain line points along +x instead.

    Args:
        up: Axis of the file that points away from the hem.
        grain: Direction of the grain line in the file; None if there is no grain line. If this direction points away
            from `up`, it is reversed. A grain line perpendicular to `up` is not reversed.
    """
    ahead = direction(up)[:2]
    if grain is not None:
        along = float(grain @ ahead)
        ahead = grain if along >= -SQUARE else -grain
    return np.array([[ahead[0], ahead[1]], [-ahead[1], ahead[0]]])


def turned(points: np.ndarray, up: str) -> np.ndarray:
    """Rotate points of a file about the z axis so that the direction `up` (along x or y) becomes +x, shape (n, 3)."""
    out = points.astype(float).copy()
    out[:, :2] = points[:, :2] @ plane_turn(up).T
    return out
