"""A manipulation: the grasps and the paths of the hands, and the times at which they move and let go."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, field_validator, model_validator

from tatamu.base import curves
from tatamu.base.curves import Bezier
from tatamu.base.errors import InputError
from tatamu.base.files import write_json
from tatamu.base.records import OpenRecord
from tatamu.folding.fold import Fold
from tatamu.simulation.scene import Index, Points

TOP_SPEED = 0.6
"""Top speed of a hand [m/s]. At twice this speed, the results of folds change (De Gusseme and wyffels 2022)."""
WAIT, HOLD, SETTLE = 0.1, 0.4, 0.7
"""Times until the hands move, from their arrival until they open, and from then until the fold is scored [s]."""
FRAME_RATE = 60.0
"""Frames per second of the hands' and of the cloth's recorded motion [1/s]."""

Hand = Literal["left", "right"]
HANDS: tuple[Hand, Hand] = ("left", "right")
VIA_EVERY = 10
"""Number of frames between via-points, which a robot follows (paper, section VI-C)."""
Two = Annotated[list[float], Field(min_length=2, max_length=2)]


class Timing(OpenRecord):
    """Times at which the hands close, start to move, arrive and open, and time at which the simulation ends [s]."""

    closes: float = Field(ge=0)
    starts: float
    arrives: float
    opens: float
    ends: float
    top_speed: float | None = None
    """Top speed of the faster hand [m/s]; None if unknown."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        for early, late in pairwise(("closes", "starts", "arrives", "opens", "ends")):
            if getattr(self, late) < getattr(self, early):
                raise ValueError(f"`{late}` must not be earlier than `{early}`")
        if not self.arrives > self.starts:
            raise ValueError("`arrives` must be later than `starts`")
        return self


class GraspPoint(OpenRecord):
    """The point at which a hand grasps the cloth."""

    vertex: Index
    position: Annotated[list[float], Field(min_length=3, max_length=3)]
    """Position of the grasped vertex [m], shape (3,)."""
    patch: list[Index] = Field(default_factory=list)


class ArmPath(OpenRecord):
    """The path of one arm in `manipulation.json`."""

    name: Literal["left", "right"]
    grasp: GraspPoint
    control_points: Points
    """P0 to P3 of the hand's curve in the scene, from grasp to release [m], shape (4, 3)."""
    from_grasp: Points | None = None
    """P0 to P3 relative to the grasp, without the file's `lift` [m], shape (4, 3); None in files of other programs."""

    @field_validator("control_points", "from_grasp")
    @classmethod
    def _four(cls, points: np.ndarray | None) -> np.ndarray | None:
        if points is not None and len(points) != 4:
            raise ValueError(f"must be the four control points P0 to P3, given {len(points)}")
        return points

    @property
    def curve(self) -> Bezier:
        return Bezier(self.control_points)


class ViaPoints(OpenRecord):
    """Points on the paths of the hands that a robot follows, one in every `every_frames` frames."""

    UNSAID: ClassVar[frozenset[str]] = frozenset({"right"})

    every_frames: int = Field(ge=1)
    times: list[float]
    """Times of the points [s]."""
    left: Points
    right: Points | None = None

    @model_validator(mode="after")
    def _check(self) -> Self:
        hands = [self.left] if self.right is None else [self.left, self.right]
        if any(len(points) != len(self.times) for points in hands):
            raise ValueError("left, right and times must have the same length")
        if not all(late > early for early, late in pairwise(self.times)):
            raise ValueError("times must increase")
        return self


class ManipulationFile(OpenRecord):
    """The file `manipulation.json`: a manipulation on Bezier curves, with timing and via-points for other programs."""

    version: Literal[1] = 1
    frame_rate: float = Field(60.0, gt=0)
    arms: Annotated[list[ArmPath], Field(min_length=1, max_length=2)]
    """Arms, left before right."""
    timing: Timing | None = None
    lift: float | None = None
    """Height by which the closing fingers lift the cloth [m]; None in files of other programs."""
    settle: float = SETTLE
    via_points: ViaPoints | None = None

    @model_validator(mode="after")
    def _check(self) -> Self:
        names = [arm.name for arm in self.arms]
        if len(set(names)) < len(names):
            raise ValueError(f"arms must have different names, given {' and '.join(names)}")
        return self

    @property
    def timing_values(self) -> dict[str, float]:
        return self.timing.model_dump(exclude_none=True) if self.timing else {}


@dataclass(frozen=True, eq=False)
class Course:
    """The course of one hand in one trial: its grasp and its path."""

    vertex: int
    """Index of the grasped vertex."""
    position: np.ndarray
    """Position of the grasp [m], shape (3,)."""
    path: np.ndarray
    """Path from (0, 0, 0) at the grasp to the release [m], shape (s, 3)."""
    control_points: np.ndarray | None = None
    """P0 to P3 of the curve, relative to the grasp [m], shape (4, 3); None for a path that is no cubic Bezier."""
    patch: tuple[int, ...] = ()

    @classmethod
    def on_curve(cls, vertex: int, position: np.ndarray, points: np.ndarray, patch: Sequence[int] = ()) -> Course:
        """Return the motion along the Bezier curve with the control points `points` [m], shape (4, 3)."""
        return cls(vertex, position, curves.sampled_bezier(points), points, tuple(patch))


@dataclass(frozen=True, eq=False)
class Manipulation:
    """The motion of one hand or two hands in one trial."""

    hands: tuple[Course, ...]
    """The left hand before the right one."""
    lift: float = 0.0
    """Height by which the closing fingers lift the cloth [m]."""
    settle: float = SETTLE

    @property
    def grasps(self) -> tuple[int, ...]:
        """Index of the grasped vertex of each hand, left before right."""
        return tuple(hand.vertex for hand in self.hands)

    @property
    def positions(self) -> tuple[np.ndarray, ...]:
        """Position of each grasp [m], shape (3,)."""
        return tuple(hand.position for hand in self.hands)

    @property
    def paths(self) -> tuple[np.ndarray, ...]:
        """Path of each hand from (0, 0, 0) at its grasp to its release [m], shape (s, 3)."""
        return tuple(hand.path for hand in self.hands)

    def __repr__(self) -> str:
        hands = "one hand" if len(self.hands) == 1 else "two hands"
        return (
            f"<Manipulation: {hands} at the vertices {' and '.join(map(str, self.grasps))}, {self.timing.ends:.2f} s>"
        )

    def describe(self) -> ManipulationFile:
        """Return the content of `manipulation.json`. The paths must be cubic Bezier curves."""
        times, displacements = self.motion()
        via = np.unique(np.append(np.arange(0, len(times), VIA_EVERY), len(times) - 1))
        arms = [
            ArmPath(
                name=name,
                grasp=GraspPoint(vertex=hand.vertex, position=hand.position.tolist(), patch=list(hand.patch)),
                control_points=curve.control,
                from_grasp=hand.control_points,
            )
            for name, hand, curve in zip(HANDS, self.hands, self.curves, strict=False)
        ]
        hands = zip(HANDS, self.hands, displacements, strict=False)
        return ManipulationFile(
            frame_rate=FRAME_RATE,
            arms=arms,
            timing=self.timing,
            lift=self.lift,
            settle=self.settle,
            via_points=ViaPoints(
                every_frames=VIA_EVERY,
                times=times[via].tolist(),
                **{name: hand.position + moved[via] for name, hand, moved in hands},
            ),
        )

    @classmethod
    def of(cls, file: ManipulationFile) -> Manipulation:
        """Return the manipulation that a file describes, exactly as it was saved."""
        arms = sorted(file.arms, key=lambda arm: arm.name)
        lift = file.lift
        if lift is None:
            lift = max(0.0, float(arms[0].control_points[0][2]) - arms[0].grasp.position[2])
        hands = []
        for arm in arms:
            points = arm.control_points - arm.control_points[0] if arm.from_grasp is None else arm.from_grasp
            grasp = arm.grasp
            hands.append(Course.on_curve(grasp.vertex, np.array(grasp.position), points, grasp.patch))
        made = cls(tuple(hands), lift, file.settle)
        made.check_via_points(file.via_points)
        return made

    def check_via_points(self, via: ViaPoints | None) -> None:
        """Check that via-points lie within 2 mm of the curves of the hands, because a robot follows them."""
        if via is None:
            return
        times, moved = self.motion()
        for name, hand, path in zip(HANDS, self.hands, moved, strict=False):
            points = getattr(via, name)
            wanted = hand.position + np.column_stack([np.interp(via.times, times, column) for column in path.T])
            distance = np.inf if points is None else float(np.linalg.norm(points - wanted, axis=1).max(initial=0.0))
            if not distance <= 2e-3:
                raise InputError(
                    f"via_points.{name}: must lie on the path of the hand, given a point {1e3 * distance:.1f} mm away "
                    "from the path"
                )

    def save(self, path: Path | str) -> None:
        write_json(Path(path), self.describe().model_dump())

    @classmethod
    def load(cls, path: Path | str) -> Manipulation:
        """Read `manipulation.json`. Errors name the file and the field."""
        file = ManipulationFile.load(Path(path))
        try:
            return cls.of(file)
        except InputError as error:
            raise InputError(f"{path}: {error}") from None

    @property
    def curves(self) -> tuple[Bezier, ...]:
        """Bezier curve of each hand in the scene. The paths must be cubic Bezier curves."""
        found = []
        for hand in self.hands:
            if hand.control_points is None:
                raise ValueError("curves: the paths of the hands must be Bezier curves, given polylines")
            found.append(Bezier(hand.position + hand.control_points + self._up))
        return tuple(found)

    @property
    def _up(self) -> np.ndarray:
        return np.array([0.0, 0.0, self.lift])

    @property
    def trajectory_length(self) -> float:
        """Trajectory length l_x of Eq. (10): the mean length of the hands' paths [m]."""
        return sum(map(curves.length, self.paths)) / len(self.hands)

    @property
    def move_seconds(self) -> float:
        """Time during which the hands move [s]: whole frames, by the longer of the paths."""
        longest = max(map(curves.length, self.paths))
        return float(np.ceil(curves.minimum_jerk_duration(longest, TOP_SPEED) * FRAME_RATE) / FRAME_RATE)

    @property
    def timing(self) -> Timing:
        arrives = WAIT + self.move_seconds
        return Timing(
            closes=0.0,
            starts=WAIT,
            arrives=round(arrives, 9),
            opens=round(arrives + HOLD, 9),
            ends=round(arrives + HOLD + self.settle, 9),
            top_speed=TOP_SPEED,
        )

    def motion(self) -> tuple[np.ndarray, list[np.ndarray]]:
        """Return the times of k knots [s], shape (k,), one a frame, and each hand's displacements [m], shape (k, 3)."""
        count = round(self.move_seconds * FRAME_RATE)
        fraction = curves.minimum_jerk(np.arange(count + 1) / count)
        times = WAIT + np.arange(count + 1) / FRAME_RATE
        return times, [curves.along(hand.path, fraction) + self._up for hand in self.hands]


def bezier_manipulation(
    fold: Fold, grasps: tuple[int, ...], x1: float, z1: float, x2: float, z2: float
) -> Manipulation:
    """Return the paper's manipulation of Eq. (9), made from the inner control points P1 and P2 of a Bezier curve.

    P1 and P2 are relative to the grasp P0, with x along the motion of the fold and z up [m], for a hand whose release
    is one span away. The curve of another hand is enlarged by the ratio of the distances, so that both hands turn the
    cloth about the fold line together.
    """
    across = np.array([*fold.normal, 0.0])
    up = np.array([0.0, 0.0, 1.0])
    hands = []
    for vertex in grasps:
        larger = fold.span_of(vertex) / fold.span
        inner = [larger * (x1 * across + z1 * up), larger * (x2 * across + z2 * up)]
        points = np.stack([np.zeros(3), *inner, fold.translation(vertex)])
        hands.append(Course.on_curve(vertex, fold.place(vertex), points, fold.patch(vertex)))
    return Manipulation(tuple(hands), fold.fingers.lift)


def trajectory_lengths(fold: Fold, parameters: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return l_x of Eq. (10) of p manipulations [m], shape (p,), from parameters of this shape, without sampling."""
    x1, z1, x2, z2 = (parameters[name] for name in ("x1", "z1", "x2", "z2"))
    zero = np.zeros_like(x1)
    total = zero
    for name, releases in zip(("g1", "g2"), fold.releases, strict=False):
        chosen = np.minimum(parameters[name].astype(int), fold.candidates - 1)
        spans, rises = releases[chosen].T
        larger = spans / fold.span
        ahead = np.stack([zero, larger * x1, larger * x2, spans - fold.fingers.setback], axis=1)
        up = np.stack([zero, larger * z1, larger * z2, rises], axis=1)
        total = total + curves.bezier_lengths(np.stack([ahead, up], axis=2))
    return total / fold.hands


def polyline_manipulation(fold: Fold, grasps: tuple[int, ...], paths: Sequence[np.ndarray]) -> Manipulation:
    """Return a manipulation along polylines of s points relative to each hand's grasp [m], shape (s, 3)."""
    hands = [Course(vertex, fold.place(vertex), path) for vertex, path in zip(grasps, paths, strict=True)]
    return Manipulation(tuple(hands), fold.fingers.lift)


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
    known = [(hand, hand.control_points) for hand in manipulation.hands]
    curved = [(hand, points) for hand, points in known if points is not None]
    if len(curved) < len(known):
        raise InputError("shift: must be left out for hands that do not follow Bezier curves")
    if len(shifts) < len(known):
        raise InputError(f"shift: must have one correction per hand ({len(known)}), given {len(shifts)}")
    if all(shift.is_none for shift in shifts):
        return manipulation
    hands = []
    for (hand, points), shift in zip(curved, shifts, strict=False):
        grasp, release = (fold.vector(*each) for each in (shift.grasp, shift.release))
        position = hand.position + grasp + [0.0, 0.0, shift.height]
        moved = points + np.outer([0.0, 0.0, 1.0, 1.0], release - grasp)
        hands.append(Course.on_curve(hand.vertex, position, moved, hand.patch))
    return replace(manipulation, hands=tuple(hands))
