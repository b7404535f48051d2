"""Symmetric 3 x 3 matrices in packed form, for membrane and bending.

K = [[0, 1, 2],
[1, 3, 4],      packed as (K00, K01, K02, K11, K12, K22)
[2, 4, 5]]
"""

from __future__ import annotations

import numpy as np

UPPER = [0, 1, 2, 4, 5, 8]
"""Indices of the upper triangle among the nine elements of a matrix, row by row."""
FULL = [0, 1, 2, 1, 3, 4, 2, 4, 5]
"""For each of the nine elements of a matrix, its index among the six packed elements."""


def pack(matrices: np.ndarray) -> np.ndarray:
    """Pack the upper triangles of m symmetric matrices, shape (m, 3, 3), as rows, shape (6, m)."""
    return matrices.reshape(-1, 9).T[UPPER]


def unpack(packed: np.ndarray) -> np.ndarray:
    """Return the symmetric matrices, shape (m, 3, 3), that are packed as rows of shape (6, m)."""
    return packed[FULL].T.reshape(-1, 3, 3)
