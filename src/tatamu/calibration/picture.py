"""Style and projection that the drawings of the tests share; each test draws itself."""

from __future__ import annotations

import numpy as np

CLOTH = "plot"
"""Colour of the cloth."""
DASH = 4.0
"""Length of the dashes of lines that only help to read a length [pixels]."""


def strip_profile(along: np.ndarray, positions: np.ndarray) -> np.ndarray:
    """Return a strip from the side: the mean of each of its rows [m], shape (rows, 2).

    Args:
        along: Coordinate of each vertex along the unfolded strip [m], shape (n,).
        positions: Positions [m], shape (n, 3).
    """
    along = along.round(6)
    return np.array([positions[along == row][:, [0, 2]].mean(axis=0) for row in np.unique(along)])
