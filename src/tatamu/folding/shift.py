"""A correction of a manipulation: it shifts the points where hands grasp and let go, and the height of their paths."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Annotated

import numpy as np
from pydantic import Field

from tatamu.base.curves import sampled_bezier
from tatamu.base.errors import InputError
from tatamu.base.records import OpenRecord
from tatamu.folding.fold import Fold
from tatamu.folding.manipulation import Manipulation

Two = Annotated[list[float], Field(min_length=2, max_length=2)]


class HandShift(OpenRecord):
    """The correction of the path of one hand [m]."""

    grasp: Two = Field(default_factory=lambda: [0.0, 0.0])
    """Shift of the grasp [m]: in the direction of the fold, and to the left of it."""
    release: Two = Field(default_factory=lambda: [0.0, 0.0])
    """Shift of the release [m], in the same directions."""
    height: float = 0.0
    """Upward shift of the whole path [m]."""

    @property
    def is_none(self) -> bool:
        return not any((*self.grasp, *self.release, self.height))


def shifted(fold: Fold, manipulation: Manipulation, shifts: Sequence[HandShift]) -> Manipulation:
    """Return a manipulation with corrected paths of its hands, left before right.

    A shift of the grasp moves the control points P0 and P1 of a hand's curve. A shift of the release moves P2 and P3.

    Raises:
        InputError: If there are fewer shifts than hands, or the paths are not Bezier curves.
    """
    if manipulation.control_points is None or len(shifts) < len(manipulation.grasps):
        raise InputError(
            f"shift: must be one correction for each of {len(manipulation.grasps)} hands, given {len(shifts)}"
        )
    if all(shift.is_none for shift in shifts):
        return manipulation
    positions = []
    points = []
    for position, control, shift in zip(manipulation.positions, manipulation.control_points, shifts, strict=False):
        grasp, release = (fold.vector(*each) for each in (shift.grasp, shift.release))
        positions.append(position + grasp + [0.0, 0.0, shift.height])
        points.append(control + np.outer([0.0, 0.0, 1.0, 1.0], release - grasp))
    paths = tuple(map(sampled_bezier, points))
    return replace(manipulation, positions=tuple(positions), control_points=tuple(points), paths=paths)
