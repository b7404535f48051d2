"""Approximation of a folded cloth: one side is mirrored over the fold line and lies flat on top of all other cloth.

This approximation compares proposed plans without a simulation. Simulated folds are scored against the more exact shape
of `ideal`.
"""

from __future__ import annotations

import numpy as np

from tatamu.folding.ideal import FoldLine
from tatamu.garments import Garment


def laid(garment: Garment, state: np.ndarray, line: FoldLine) -> np.ndarray:
    """Return the positions of a cloth after one side is mirrored over the fold line and laid on top [m], shape (n, 3).

    Args:
        garment: The garment to fold.
        state: The cloth before the fold [m], shape (n, 3).
        line: The fold line and its moving side.
    """
    across, _ = line.split(state)
    moving = across < 0
    after = state.copy()
    after[moving, :2] = line.mirrored(state)[moving]
    top = float(state[:, 2].max()) + 0.5 * garment.material.thickness
    after[moving, 2] = 2.0 * top - state[moving, 2]
    return after
