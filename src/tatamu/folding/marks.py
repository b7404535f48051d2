"""The marks of a finished fold: six deviations that a person or a camera can measure.

The corners of the moved hem are the first grasp candidates of both hands. The lower hem is the part of the cloth that
does not move and is nearest to the targets of these corners.
"""

from __future__ import annotations

import numpy as np

from tatamu.folding.fold import Fold

MARKS = ("left_along", "left_across", "right_along", "right_across", "slip_along", "slip_across")
"""Names of the deviations of a finished fold from its target [m].

Each deviation is measured in the direction in which the fold moves cloth ("along"), or perpendicular to it ("across",
positive to the left). The left corner of the moved hem has two deviations, the right corner has two, and the slip of
the lower hem has two.
"""


def marks(fold: Fold, final: np.ndarray) -> dict[str, float]:
    """Return the deviations of a finished fold from its target [m], by the names of `MARKS`.

    Args:
        fold: The fold.
        final: Positions of the cloth after the fold [m], shape (n, 3).
    """
    corners = [int(fold.left[0]), int(fold.right[0])]
    moved = [(final - fold.target)[corner, :2] for corner in corners]
    hem = lower_hem(fold, corners)
    shifts = [*moved, (final - fold.start)[hem, :2].mean(axis=0)]
    axes = (fold.normal, fold.crease.along)
    return dict(zip(MARKS, (float(shift @ axis) for shift in shifts for axis in axes), strict=True))


def lower_hem(fold: Fold, corners: list[int]) -> list[int]:
    """For each corner of the moved hem, return the vertex of unmoved cloth that is nearest to the corner's target."""
    still = np.flatnonzero(fold.still())
    if not len(still):
        across, _ = fold.crease.split(fold.start)
        still = np.flatnonzero(across > 0)
    return [
        int(still[np.linalg.norm(fold.start[still, :2] - fold.target[corner, :2], axis=1).argmin()])
        for corner in corners
    ]
