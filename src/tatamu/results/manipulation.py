"""The models of `manipulation.json`: grasps, control points, timing, via-points.

docs/reference/result-folder.md explains every field.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, field_validator, model_validator

from tatamu.curves import Bezier
from tatamu.folding.fold import Fold
from tatamu.folding.manipulation import FRAME_RATE, HANDS, Manipulation, Timing
from tatamu.records import OpenRecord
from tatamu.scene import Index, Points

VIA_EVERY = 10
"""The robot's via-points lie this many frames apart (paper, section VI-C)."""


class GraspPoint(OpenRecord):
    """Where a hand takes the cloth."""

    vertex: Index
    position: Annotated[list[float], Field(min_length=3, max_length=3)]
    """[m], shape (3,)."""
    patch: list[Index] = Field(default_factory=list)
    """The held vertices."""


class ArmPath(OpenRecord):
    """One arm's part of the manipulation."""

    name: str
    """`left` or `right`."""
    grasp: GraspPoint
    control_points: Points
    """P0..P3 [m], shape (4, 3)."""

    @field_validator("control_points")
    @classmethod
    def _four(cls, points: np.ndarray) -> np.ndarray:
        if len(points) != 4:
            raise ValueError(f"must be four points P0..P3, given {len(points)}")
        return points

    @property
    def curve(self) -> Bezier:
        """The path of the hand."""
        return Bezier(self.control_points)


class ViaPoints(OpenRecord):
    """The path in steps of `every_frames`, as a robot is given it."""

    UNSAID: ClassVar[frozenset[str]] = frozenset({"right"})

    every_frames: int = Field(ge=1)
    times: list[float]
    """[s]."""
    left: Points
    """[m], one for each of `times`."""
    right: Points | None = None
    """None where one hand folds."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        hands = [self.left] if self.right is None else [self.left, self.right]
        if any(len(points) != len(self.times) for points in hands):
            raise ValueError("left, right and times must be equally many")
        if not all(late > early for early, late in pairwise(self.times)):
            raise ValueError("times must increase")
        return self


class ManipulationDescription(OpenRecord):
    """The manipulation of a learned fold as people, robots and other programs are given it."""

    version: Literal[1] = 1
    frame_rate: float = Field(60.0, gt=0)
    """Frames per second [1/s]."""
    arms: Annotated[list[ArmPath], Field(min_length=1)]
    """Left before right."""
    timing: Timing | None = None
    via_points: ViaPoints | None = None

    @property
    def timing_values(self) -> dict[str, float]:
        """The timing by name, as far as the file has it."""
        return self.timing.model_dump(exclude_none=True) if self.timing else {}


def describe_manipulation(fold: Fold, manipulation: Manipulation) -> ManipulationDescription:
    """A manipulation on Bezier curves as `manipulation.json` holds it.

    Raises:
        ValueError: The paths are no cubic Bezier curves.
    """
    times, displacements = manipulation.motion()
    via = np.unique(np.append(np.arange(0, len(times), VIA_EVERY), len(times) - 1))
    arms = []
    paths = {}
    hands = zip(HANDS, manipulation.grasps, manipulation.positions, manipulation.curves, displacements, strict=False)
    for name, vertex, position, curve, displacement in hands:
        grasp = GraspPoint(vertex=int(vertex), position=position.tolist(), patch=fold.patch(vertex))
        arms.append(ArmPath(name=name, grasp=grasp, control_points=curve.control))
        paths[name] = position + displacement[via]
    return ManipulationDescription(
        version=1,
        frame_rate=FRAME_RATE,
        arms=arms,
        timing=manipulation.timing,
        via_points=ViaPoints(every_frames=VIA_EVERY, times=times[via].tolist(), **paths),
    )
