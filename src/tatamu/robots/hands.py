"""The motion of the hands in a fold: exact where the manipulation is at hand, fitted where only its file is.

F is the fold's frame: the scene's, z = 0 at the table top. Time is the simulation's.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator

from tatamu.curves import Bezier, arc_lengths, minimum_jerk
from tatamu.errors import InputError
from tatamu.folding.manipulation import FRAME_RATE, HANDS, Manipulation, Timing
from tatamu.results import ManipulationDescription, ResultFolder, ViaPoints
from tatamu.results.manipulation import VIA_EVERY, ArmPath
from tatamu.scene import Gripper, Scene

OFF_CURVE = 2e-3
"""Via-points farther than this from their Bezier curve do not belong to it [m]."""
SAME_PATH = 1e-9
"""Displacements of one hand's grippers differ by a constant shift, to within this [m]."""
SAME_HEIGHT = 1e-6
"""A hand that begins this little above its grasp begins at it [m]."""
ONE_HAND = "arms: must be two, and the fold has one: robots here fold with both; learn it with --hands 2"

Travel = Callable[[np.ndarray], np.ndarray]
"""From times [s] to how far a hand has come along its curve [m]."""


@dataclass(frozen=True)
class HandMotion:
    """Both hands' motion from the grasp to the place of release; the left hand is `larm`'s."""

    frame_rate: float
    every_frames: int
    timing: Timing
    times: np.ndarray
    """Of the via-points [s], from the last still one before the motion to the first after it, shape (v,)."""
    curves: tuple[Bezier, Bezier]
    """Left, right."""
    travelled: tuple[Travel, Travel]
    """Left, right."""
    lift: float = 0.0
    """How high over their grasps the hands begin: the thickness of their lower fingers, as the fold knows it [m]."""

    @property
    def outwards(self) -> np.ndarray:
        """Horizontal directions in which the hands come out from the hems that they have laid down, shape (2, 3)."""
        moved = np.array([curve.control[-1] - curve.control[0] for curve in self.curves]) * [1.0, 1.0, 0.0]
        return np.asarray(moved / np.linalg.norm(moved, axis=1, keepdims=True))

    @classmethod
    def load(cls, path: Path) -> HandMotion:
        """Read the hands' motion from the folder of a learned fold.

        Raises:
            InputError: The file cannot be read, or a field is wrong.
        """
        folder = ResultFolder(path)
        if not path.is_dir():
            raise InputError(f"{path}: must be the folder of a learned fold, and is no folder")
        if not folder.manipulation_file.exists():
            raise InputError(f"{path}: {_no_fold(folder)}")
        return cls.fitted(folder.manipulation, folder.manipulation_file)

    @classmethod
    def exact(cls, manipulation: Manipulation) -> HandMotion:
        """The motion of a manipulation: minimum jerk along its Bezier curves.

        Raises:
            InputError: It has not two hands, or one that does not move.
        """
        curves = manipulation.curves
        if len(curves) != 2:
            raise InputError(f"manipulation: {ONE_HAND if len(curves) == 1 else 'arms: must be two, given none'}")
        for name, curve in zip(HANDS, curves, strict=True):
            _check_moves(curve, name, "manipulation")
        knots, _ = manipulation.motion()
        every = np.arange(0, len(knots), VIA_EVERY)
        times = knots[np.unique(np.append(every, len(knots) - 1))]
        left, right = (_minimum_jerk(curve, manipulation.timing) for curve in curves)
        return cls(
            FRAME_RATE, VIA_EVERY, manipulation.timing, times, (curves[0], curves[1]), (left, right), manipulation.lift
        )

    @classmethod
    def fitted(cls, description: ManipulationDescription, source: Path | str) -> HandMotion:
        """The motion along the Bezier curves that passes the via-points at their times.

        Raises:
            InputError: The description has not two hands or no via-points, or these lie beside the curves; the message
                names `source`.
        """
        via, timing = _of_two_hands(description, source)
        arms = sorted(description.arms, key=lambda arm: arm.name)  # left, right
        curves = [arm.curve for arm in arms]
        values = []
        for arm, curve in zip(arms, curves, strict=True):
            u, distance = curve.in_order(getattr(via, arm.name), OFF_CURVE)
            if not distance.max() <= OFF_CURVE:
                raise InputError(
                    f"{source}: via_points.{arm.name}.{int(distance.argmax())}: must lie on the hand's curve, "
                    f"given {1e3 * distance.max():.1f} mm beside it"
                )
            _check_moves(curve, arm.name, source)
            values.append(u)
        times, moving = _moving(np.array(via.times), np.array(values), timing)
        lengths = [np.interp(u, *curve.arc_lengths()) for curve, u in zip(curves, moving, strict=True)]
        left, right = (_smooth(times, length) for length in lengths)
        return cls(
            description.frame_rate,
            via.every_frames,
            timing,
            times,
            (curves[0], curves[1]),
            (left, right),
            _lift(arms[0]),
        )

    def at(self, times: np.ndarray) -> np.ndarray:
        """Positions of the hands at simulated times [s] (n,): in F [m], shape (2, n, 3)."""
        times = np.clip(times, self.times[0], self.times[-1])
        points = []
        for curve, travelled in zip(self.curves, self.travelled, strict=True):
            u, length = curve.arc_lengths()
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


def grippers_by_hand(scene: Scene) -> list[list[Gripper]]:
    """The grippers of each hand of a scene, which follow one another; the first moves as the hand does.

    A scene file does not say which grippers are one hand's. Fingers that press layers together are several grippers
    with one motion, apart from the constant shift by which the later ones are first pressed onto the first.
    """
    hands: list[list[Gripper]] = []
    for gripper in scene.grippers:
        if hands and _goes_with(gripper, hands[-1][0]):
            hands[-1].append(gripper)
        else:
            hands.append([gripper])
    return hands


def _goes_with(gripper: Gripper, first: Gripper) -> bool:
    """Whether a gripper moves as another does, but for a constant shift that is not zero."""
    count = len(first.times)
    if len(gripper.times) < count:
        return False
    apart = gripper.displacements[-count:] - first.displacements
    return bool(np.ptp(apart, axis=0).max() < SAME_PATH < np.abs(apart).max())


def _lift(arm: ArmPath) -> float:
    """How high over its grasp a hand begins [m]."""
    above = arm.control_points[0][2] - arm.grasp.position[2]
    return above if above > SAME_HEIGHT else 0.0


def _of_two_hands(description: ManipulationDescription, source: Path | str) -> tuple[ViaPoints, Timing]:
    """The parts of a description that a robot needs, which others may lack."""
    if len(description.arms) == 1:
        raise InputError(f"{source}: {ONE_HAND}")
    if sorted(arm.name for arm in description.arms) != ["left", "right"]:
        raise InputError(f"{source}: arms: must be one left and one right hand")
    if description.timing is None:
        raise InputError(f"{source}: timing: Field required")
    via = description.via_points
    if via is None:
        raise InputError(f"{source}: via_points: Field required")
    if via.right is None:
        raise InputError(f"{source}: via_points.right: Field required")
    if len(via.times) < 2:
        raise InputError(f"{source}: via_points.times: must be at least two, given {len(via.times)}")
    return via, description.timing


def _check_moves(curve: Bezier, name: str, source: Path | str) -> None:
    if np.isclose(arc_lengths(curve.control)[-1], 0):
        raise InputError(f"{source}: arms: the {name} hand's control_points must not all be the same")


def _no_fold(folder: ResultFolder) -> str:
    """Why a folder without manipulation.json is no learned fold."""
    steps = folder.learned_steps()
    if not steps:
        return "must be the folder of a learned fold, and has no manipulation.json"
    return f"holds a plan of several steps; give one of {', '.join(str(step.path) for step in steps)}"


def _minimum_jerk(curve: Bezier, timing: Timing) -> Travel:
    """Travel along a curve at rest at both ends."""
    length = curve.arc_lengths()[1][-1]
    duration = timing.arrives - timing.starts
    return lambda times: length * minimum_jerk((times - timing.starts) / duration)


def _moving(times: np.ndarray, values: np.ndarray, timing: Timing) -> tuple[np.ndarray, np.ndarray]:
    """Via-points while the hands move; both ends of the curve are made to be there."""
    if values[:, 0].max() > 1e-6:
        start = min(timing.starts, times[0] - 1e-3)
        times, values = np.append(start, times), np.hstack([np.zeros((2, 1)), values])
    if values[:, -1].min() < 1 - 1e-6:
        end = max(timing.arrives, times[-1] + 1e-3)
        times, values = np.append(times, end), np.hstack([values, np.ones((2, 1))])
    before = np.flatnonzero((values < 1e-6).all(axis=0))
    after = np.flatnonzero((values > 1 - 1e-6).all(axis=0))
    first = int(before[-1])
    last = int(after[0])
    times = times[first : last + 1].copy()
    times[0] = timing.starts if times[0] < timing.starts < times[1] else times[0]
    times[-1] = timing.arrives if times[-2] < timing.arrives < times[-1] else times[-1]
    return times, values[:, first : last + 1]


def _smooth(times: np.ndarray, lengths: np.ndarray) -> Travel:
    """Travel through given lengths [m] at given times [s]: at rest at both ends, and never backwards."""
    spline = CubicSpline(times, lengths, bc_type="clamped")
    fine = np.diff(spline(np.linspace(times[0], times[-1], 40 * len(times))))
    return spline if fine.min() >= -1e-9 else PchipInterpolator(times, lengths)
