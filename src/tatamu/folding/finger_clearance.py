"""Heights at which hands must carry the cloth so that their lower fingers clear the cloth below."""

from __future__ import annotations

import numpy as np

from tatamu.folding.fold import Fold
from tatamu.folding.layers import Surface

LIES = 0.02
"""Distance from its grasp over which a hand comes to have cloth below it [m]; nearer, the cloth hangs from the hand."""


def lowest_lift(fold: Fold, vertex: int, moved: np.ndarray) -> np.ndarray:
    """Return the least displacement upwards at which the lower finger clears the cloth below it [m], shape (k,).

    Args:
        fold: The fold.
        vertex: The grasped vertex.
        moved: Displacements of the hand [m], shape (k, 3).
    """
    half = 0.5 * fold.garment.material.thickness
    underside = fold.start[fold.patch(vertex), 2].min() - half
    come = np.linalg.norm(moved[:, :2], axis=1)
    below = _lying(fold).height(fold.start[vertex, :2] + moved[:, :2])
    return np.clip(come / LIES, 0.0, 1.0) * below + fold.lift - underside


def raise_clear(fold: Fold, vertex: int, moved: np.ndarray) -> np.ndarray:
    """Return displacements of a hand [m], shape (k, 3), raised if its lower finger would touch the cloth below it.

    The release stays unchanged, because it has the height that the finger needs over the layers there.
    """
    if not fold.lift:
        return moved
    raised = moved.copy()
    raised[:-1, 2] = np.maximum(moved[:-1, 2], lowest_lift(fold, vertex, moved)[:-1])
    return raised


def _lying(fold: Fold) -> Surface:
    """Return the upper surface of the cloth before the fold, its loops pressed."""
    garment = fold.garment
    pressed = np.column_stack([fold.start[:, :2], fold.stacks.middle])
    return Surface.of(pressed, garment.faces, garment.material.thickness, 0.5 * garment.spacing)
