"""Symmetric 3 x 3 matrices, packed as (K00, K01, K02, K11, K12, K22), for membrane and bending."""

from __future__ import annotations

import numpy as np

UPPER = [0, 1, 2, 4, 5, 8]
"""Indices of the packed elements among the nine elements of a matrix, row by row."""
FULL = [0, 1, 2, 1, 3, 4, 2, 4, 5]
"""For each of the nine elements of a matrix, its index among the six packed elements."""


def pack(matrices: np.ndarray) -> np.ndarray:
    """Pack symmetric matrices, shape (m, 3, 3), as rows, shape (6, m)."""
    return matrices.reshape(-1, 9).T[UPPER]


def unpack(packed: np.ndarray) -> np.ndarray:
    """Unpack rows, shape (6, m), to symmetric matrices, shape (m, 3, 3)."""
    return packed[FULL].T.reshape(-1, 3, 3)
