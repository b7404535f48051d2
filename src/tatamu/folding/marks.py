"""The marks of a finished fold: six numbers that a person or a camera measures.

The corners are those of the moved hem, where the first grasp candidates lie. The lower hem is the cloth that lies still
at the targets of these corners.
"""

from __future__ import annotations

import numpy as np

from tatamu.folding.fold import Fold

MARKS = ("left_along", "left_across", "right_along", "right_across", "slip_along", "slip_across")
"""Deviations from the target [m], along the fold and across it (positive to the left): the left and the right corner of
the moved hem, and the lower hem."""


def marks(fold: Fold, final: np.ndarray) -> dict[str, float]:
    """Return the deviations of a finished fold from its target [m], by the names of `MARKS`.

    Args:
        fold: The fold.
        final: The cloth after it [m], shape (n, 3).
    """
    corners = [int(fold.left[0]), int(fold.right[0])]
    moved = [(final - fold.target)[corner, :2] for corner in corners]
    hem = lower_hem(fold, corners)
    shifts = [*moved, (final - fold.start)[hem, :2].mean(axis=0)]
    axes = (fold.normal, fold.crease.along)
    return dict(zip(MARKS, (float(shift @ axis) for shift in shifts for axis in axes), strict=True))


def lower_hem(fold: Fold, corners: list[int]) -> list[int]:
    """Return the vertices that lie still and are nearest to the targets of the corners."""
    still = np.flatnonzero(fold.still())
    if not len(still):
        across, _ = fold.crease.split(fold.start)
        still = np.flatnonzero(across > 0)
    return [
        int(still[np.linalg.norm(fold.start[still, :2] - fold.target[corner, :2], axis=1).argmin()])
        for corner in corners
    ]
