"""Style and projection that the drawings of all calibration tests share."""

from __future__ import annotations

import numpy as np

CLOTH = "plot"
"""Name of the colour with which drawings show cloth."""
DASH = 4.0
"""Length of the dashes of auxiliary lines [pixels]."""


def strip_profile(along: np.ndarray, positions: np.ndarray) -> np.ndarray:
    """Return the side view of a strip: the mean position of each row of vertices [m], shape (rows, 2).

    Args:
        along: Coordinate of each vertex along the unfolded strip [m], shape (n,).
        positions: Positions [m], shape (n, 3).
    """
    along = along.round(6)
    return np.array([positions[along == row][:, [0, 2]].mean(axis=0) for row in np.unique(along)])
