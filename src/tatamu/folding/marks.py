"""The marks of a finished fold: six deviations that a person or a camera can measure.

The corners of the moved hem are the first grasp candidates of both hands. The lower hem is the part of the cloth that
does not move and is nearest to the targets of these corners.
"""

from __future__ import annotations

import numpy as np

from tatamu.folding.fold import Fold

MARKS = ("left_along", "left_across", "right_along", "right_across", "slip_along", "slip_across")
"""Deviations of both corners of the moved hem, and of the lower hem (slip), from their targets [m]: along the direction
in which the fold moves cloth, and across it, positive to the left."""


def marks(fold: Fold, final: np.ndarray) -> dict[str, float]:
    """Return the deviations `MARKS` of a cloth that ends at `final` [m], shape (n, 3), by their names."""
    corners = [int(fold.left[0]), int(fold.right[0])]
    moved = [(final - fold.target)[corner, :2] for corner in corners]
    hem = lower_hem(fold, corners)
    shifts = [*moved, (final - fold.start)[hem, :2].mean(axis=0)]
    axes = (fold.normal, fold.crease.along)
    return dict(zip(MARKS, (float(shift @ axis) for shift in shifts for axis in axes), strict=True))


def lower_hem(fold: Fold, corners: list[int]) -> list[int]:
    """Return the vertex of unmoved cloth that is nearest to each corner's target."""
    still = np.flatnonzero(fold.still())
    if not len(still):
        across, _ = fold.crease.split(fold.start)
        still = np.flatnonzero(across > 0)
    return [
        int(still[np.linalg.norm(fold.start[still, :2] - fold.target[corner, :2], axis=1).argmin()])
        for corner in corners
    ]
