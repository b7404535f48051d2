"""Rough folds, to compare plans without a simulation (see `ideal`): one side lies flat on top of all other cloth."""

from __future__ import annotations

import numpy as np

from tatamu.folding.ideal import FoldLine
from tatamu.garments import Garment


def laid(garment: Garment, state: np.ndarray, line: FoldLine) -> np.ndarray:
    """Return the positions of a cloth whose moving side is mirrored and laid on top [m], shape (n, 3)."""
    across, _ = line.split(state)
    moving = across < 0
    after = state.copy()
    after[moving, :2] = line.mirrored(state)[moving]
    top = float(state[:, 2].max()) + 0.5 * garment.material.thickness
    after[moving, 2] = 2.0 * top - state[moving, 2]
    return after
