"""What the hands of a learned fold do: manipulation.json, read and made continuous.

F is the fold's frame: the scene's, z = 0 at the table top. Time is the simulation's.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator
from scipy.interpolate import CubicSpline, PchipInterpolator

from tatamu.errors import InputError
from tatamu.files import read_json, validated

OFF_CURVE = 2e-3
"""Via-points farther than this from their Bezier curve do not belong to it [m]."""
Vector = tuple[float, float, float]


class _Record(BaseModel):
    model_config = ConfigDict(frozen=True, extra="ignore", allow_inf_nan=False)


class Grasp(_Record):
    """Where a hand takes the cloth."""

    vertex: int = Field(ge=0)
    position: Vector
    """In F [m]."""


class Hand(_Record):
    """One hand."""

    name: Literal["left", "right"]
    grasp: Grasp
    control_points: Annotated[list[Vector], Field(min_length=4, max_length=4)]
    """P0..P3 of the cubic Bezier curve in F [m]."""


class Timing(_Record):
    """When hands close, move and open [s]."""

    closes: float = Field(ge=0)
    starts: float
    arrives: float
    opens: float
    ends: float

    @model_validator(mode="after")
    def _check(self) -> Self:
        order = ("closes", "starts", "arrives", "opens", "ends")
        for early, late in pairwise(order):
            if getattr(self, late) < getattr(self, early):
                raise ValueError(f"{late} must not be before {early}")
        if not self.arrives > self.starts:
            raise ValueError("arrives must be after starts")
        return self


class ViaPoints(_Record):
    """Where both hands are at every so many frames."""

    every_frames: int = Field(ge=1)
    times: Annotated[list[float], Field(min_length=2)]
    left: list[Vector]
    right: list[Vector]

    @model_validator(mode="after")
    def _check(self) -> Self:
        if not len(self.left) == len(self.right) == len(self.times):
            raise ValueError("left, right and times must be equally many")
        if not all(late > early for early, late in pairwise(self.times)):
            raise ValueError("times must increase")
        return self


class Manipulation(_Record):
    """The file manipulation.json of a learned fold. See docs/reference/result-folder.md."""

    version: Literal[1]
    frame_rate: float = Field(gt=0)
    arms: Annotated[list[Hand], Field(min_length=2, max_length=2)]
    timing: Timing
    via_points: ViaPoints

    @field_validator("arms", mode="before")
    @classmethod
    def _refuse_one_hand(cls, arms: object) -> object:
        if isinstance(arms, list) and len(arms) == 1:
            raise ValueError("must be two, and the fold has one: robots here fold with both; learn it with --hands 2")
        return arms

    @model_validator(mode="after")
    def _check(self) -> Self:
        if {hand.name for hand in self.arms} != {"left", "right"}:
            raise ValueError("arms must be one left and one right hand")
        return self


@dataclass(frozen=True)
class Bezier:
    """A cubic curve in F (paper, Fig. 3)."""

    control: np.ndarray
    """P0..P3 [m], shape (4, 3)."""

    def at(self, u: np.ndarray) -> np.ndarray:
        """Points at parameters u (n,) in [0, 1], shape (n, 3)."""
        u = np.asarray(u, dtype=float)[:, None]
        basis = np.hstack([(1 - u) ** 3, 3 * u * (1 - u) ** 2, 3 * u * u * (1 - u), u**3])
        return basis @ self.control

    def along(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Parameters (n,) of points that follow one another along the curve, and their distances from it [m] (n,).

        A curve may cross itself or turn back, so each point is looked for from the one before it onwards.
        """
        u = np.linspace(0, 1, 4001)
        curve = self.at(u)
        first, found, distances = 0, [], []
        for point in points:
            distance = np.linalg.norm(curve[first:] - point, axis=1)
            near = distance < OFF_CURVE
            start = int(near.argmax()) if near.any() else int(distance.argmin())
            end = start + int((~near[start:]).argmax()) if (~near[start:]).any() else len(near)
            first += start + int(distance[start : max(end, start + 1)].argmin())
            found.append(u[first])
            distances.append(np.linalg.norm(curve[first] - point))
        return np.array(found), np.array(distances)

    def lengths(self) -> tuple[np.ndarray, np.ndarray]:
        """Parameters and the length of the curve up to each [m], shape (4001,) both."""
        u = np.linspace(0, 1, 4001)
        steps = np.linalg.norm(np.diff(self.at(u), axis=0), axis=1)
        return u, np.append(0.0, np.cumsum(steps))

    def nearest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Parameters (n,) of the nearest points of the curve, and their distances [m] (n,)."""
        u = np.linspace(0, 1, 2001)
        curve = self.at(u)
        best = np.array([np.argmin(((curve - point) ** 2).sum(axis=1)) for point in points])
        low, high = u[np.maximum(best - 1, 0)], u[np.minimum(best + 1, 2000)]
        for _ in range(40):  # golden section, all points together
            a, b = high - (high - low) * 0.618034, low + (high - low) * 0.618034
            nearer = self._squares(a, points) < self._squares(b, points)
            low, high = np.where(nearer, low, a), np.where(nearer, b, high)
        u = (low + high) / 2
        return u, np.sqrt(self._squares(u, points))

    def _squares(self, u: np.ndarray, points: np.ndarray) -> np.ndarray:
        return ((self.at(u) - points) ** 2).sum(axis=1)


@dataclass(frozen=True)
class Hands:
    """Both hands' motion from the grasp to the place of release; the left hand is `larm`'s."""

    frame_rate: float
    every_frames: int
    timing: Timing
    times: np.ndarray
    """Of the via-points [s], from the last still one before the motion to the first after it, shape (v,)."""
    curves: tuple[Bezier, Bezier]
    """Left, right."""
    _travelled: tuple[PchipInterpolator | CubicSpline, ...]
    """How far each hand has come along its curve [m], over time."""

    @classmethod
    def load(cls, folder: Path) -> Hands:
        """Read the hands' motion of a learned fold.

        Raises:
            InputError: The file cannot be read, or a field is wrong.
        """
        path = folder / "manipulation.json"
        if not folder.is_dir():
            raise InputError(f"{folder}: must be the folder of a learned fold, and is no folder")
        if not path.exists():
            raise InputError(f"{folder}: {_no_fold(folder)}")
        return cls.of(validated(Manipulation, read_json(path), path), path)

    @classmethod
    def of(cls, manipulation: Manipulation, source: Path) -> Hands:
        """The motion through the via-points."""
        hands = sorted(manipulation.arms, key=lambda hand: hand.name)  # left, right
        curves = [Bezier(np.array(hand.control_points)) for hand in hands]
        points = [np.array(getattr(manipulation.via_points, hand.name)) for hand in hands]
        times = np.array(manipulation.via_points.times)
        values = []
        for hand, curve, point in zip(hands, curves, points, strict=True):
            u, distance = curve.along(point)
            if not distance.max() <= OFF_CURVE:
                raise InputError(
                    f"{source}: via_points.{hand.name}.{int(distance.argmax())}: must lie on the hand's curve, "
                    f"given {1e3 * distance.max():.1f} mm beside it"
                )
            if np.isclose(curve.lengths()[1][-1], 0):
                raise InputError(f"{source}: arms: the {hand.name} hand's control_points must not all be the same")
            values.append(u)
        times, moving = _moving(times, np.array(values), manipulation.timing)
        lengths = [np.interp(u, *curve.lengths()) for curve, u in zip(curves, moving, strict=True)]
        return cls(
            manipulation.frame_rate,
            manipulation.via_points.every_frames,
            manipulation.timing,
            times,
            (curves[0], curves[1]),
            tuple(_smooth(times, length) for length in lengths),
        )

    def at(self, times: np.ndarray) -> np.ndarray:
        """Where the hands are at simulated times [s] (n,): positions in F [m], shape (2, n, 3)."""
        times = np.clip(times, self.times[0], self.times[-1])
        points = []
        for curve, travelled in zip(self.curves, self._travelled, strict=True):
            u, length = curve.lengths()
            points.append(curve.at(np.interp(travelled(times), length, u)))
        return np.array(points)

    def evenly(self, count: int) -> np.ndarray:
        """Times [s] (count,) between which the hands go equally far."""
        times = np.linspace(self.times[0], self.times[-1], 1001)
        steps = np.linalg.norm(np.diff(self.at(times), axis=1), axis=2).mean(axis=0)
        length = np.append(0.0, np.cumsum(steps + 1e-9))
        return np.interp(np.linspace(0, length[-1], count), length, times)

    def frame(self, time: float) -> int:
        """The simulation's frame at a simulated time [s]."""
        return round(time * self.frame_rate)

    @property
    def top_speed(self) -> float:
        """The fastest that either hand moves [m/s]."""
        times = np.linspace(self.times[0], self.times[-1], 2000)
        steps = np.linalg.norm(np.diff(self.at(times), axis=1), axis=2)
        return float(steps.max() / (times[1] - times[0]))


def _no_fold(folder: Path) -> str:
    """Why a folder without manipulation.json is no learned fold."""
    steps = [file.parent.name for file in folder.glob("step-*/manipulation.json")]
    if not steps:
        return "must be the folder of a learned fold, and has no manipulation.json"
    steps.sort(key=lambda name: (len(name), name))
    return f"holds a plan of several steps; give one of {', '.join(str(folder / name) for name in steps)}"


def _moving(times: np.ndarray, values: np.ndarray, timing: Timing) -> tuple[np.ndarray, np.ndarray]:
    """Via-points while the hands move; both ends of the curve are made to be there."""
    if values[:, 0].max() > 1e-6:
        start = min(timing.starts, times[0] - 1e-3)
        times, values = np.append(start, times), np.hstack([np.zeros((2, 1)), values])
    if values[:, -1].min() < 1 - 1e-6:
        end = max(timing.arrives, times[-1] + 1e-3)
        times, values = np.append(times, end), np.hstack([values, np.ones((2, 1))])
    still = np.flatnonzero((values < 1e-6).all(axis=0)), np.flatnonzero((values > 1 - 1e-6).all(axis=0))
    first, last = int(still[0][-1]), int(still[1][0])
    times = times[first : last + 1].copy()
    times[0] = timing.starts if times[0] < timing.starts < times[1] else times[0]
    times[-1] = timing.arrives if times[-2] < timing.arrives < times[-1] else times[-1]
    return times, values[:, first : last + 1]


def _smooth(times: np.ndarray, lengths: np.ndarray) -> PchipInterpolator | CubicSpline:
    """Way travelled [m]: at rest at both ends, and never backwards."""
    spline = CubicSpline(times, lengths, bc_type="clamped")
    fine = np.diff(spline(np.linspace(times[0], times[-1], 40 * len(times))))
    return spline if fine.min() >= -1e-9 else PchipInterpolator(times, lengths)
