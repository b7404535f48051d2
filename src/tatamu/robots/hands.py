"""The motion of the hands in a learned fold.

F is the frame of the simulated scene, with z = 0 at the table top. Times are times of the simulation.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tatamu.base.curves import Bezier, arc_lengths, minimum_jerk
from tatamu.base.errors import InputError
from tatamu.folding.manipulation import FRAME_RATE, HANDS, VIA_EVERY, Manipulation, Timing
from tatamu.simulation.scene import Gripper, Scene
from tatamu.study.folder import ResultFolder
from tatamu.study.result import Result


@dataclass(frozen=True)
class HandMotion:
    """The motion of one or two hands, with minimum jerk, from the grasp to the release, the left hand first."""

    timing: Timing
    times: np.ndarray
    """Times of the via-points, from the start of the hands to their rest [s], shape (v,)."""
    curves: tuple[Bezier, ...]

    @classmethod
    def load(cls, path: Path) -> HandMotion:
        """Read the hands' motion from the folder of a learned fold.

        Raises:
            InputError: If the file cannot be read, or a field is wrong.
        """
        folder = ResultFolder(path)
        if not path.is_dir():
            raise InputError(f"{path}: must be the folder of a learned fold, but is not a folder")
        if not folder.manipulation_file.exists():
            steps = ", ".join(str(step.path) for step in folder.learned_steps())
            if steps:
                raise InputError(
                    f"{path}: must be the folder of one fold, given a fold plan of several steps; give the folder of "
                    f"one step: {steps}"
                )
            raise InputError(f"{path}: must be the folder of a learned fold, but has no manipulation.json")
        if folder.scene_file.is_file():
            _check_unpressed(folder.scene, folder.scene_file)
        manipulation = folder.manipulation
        try:
            return cls.exact(manipulation)
        except InputError as error:
            raise InputError(f"{folder.manipulation_file}: {str(error).removeprefix('manipulation: ')}") from None

    @classmethod
    def of(cls, result: Result) -> HandMotion:
        """Return the hands' motion of a learned fold in memory.

        Raises:
            InputError: If a robot cannot do the fold, because it has a press or a hand that does not move.
        """
        _check_unpressed(result.scene, "scene")
        return cls.exact(result.manipulation)

    @classmethod
    def exact(cls, manipulation: Manipulation) -> HandMotion:
        """Return the motion of a manipulation.

        Raises:
            InputError: If there is no hand, or a hand does not move.
        """
        curves = manipulation.curves
        if not curves:
            raise InputError("manipulation: arms: must contain one or two arms, given none")
        for name, curve in zip(HANDS, curves, strict=False):
            if np.isclose(arc_lengths(curve.control)[-1], 0):
                raise InputError(f"manipulation: arms: the {name} hand's control_points must not all be the same")
        knots, _ = manipulation.motion()
        every = np.arange(0, len(knots), VIA_EVERY)
        times = knots[np.unique(np.append(every, len(knots) - 1))]
        return cls(manipulation.timing, times, curves)

    def at(self, times: np.ndarray) -> np.ndarray:
        """Return the positions of the hands at n simulated times [s], in the fold's frame [m], shape (hands, n, 3)."""
        elapsed = np.clip(times, self.times[0], self.times[-1]) - self.timing.starts
        fraction = minimum_jerk(elapsed / (self.timing.arrives - self.timing.starts))
        points = []
        for curve in self.curves:
            u, length = curve.arc_lengths()
            points.append(curve.at(np.interp(length[-1] * fraction, length, u)))
        return np.array(points)

    def evenly(self, count: int) -> np.ndarray:
        """Return `count` times [s]. From each time to the next, the hands travel the same distance."""
        times = np.linspace(self.times[0], self.times[-1], 1001)
        steps = np.linalg.norm(np.diff(self.at(times), axis=1), axis=2).mean(axis=0)
        length = np.append(0.0, np.cumsum(steps + 1e-9))
        return np.interp(np.linspace(0, length[-1], count), length, times)

    def frame(self, time: float) -> int:
        """Return the number of the simulation's frame that belongs to a simulated time [s]."""
        return round(time * FRAME_RATE)

    @property
    def top_speed(self) -> float:
        """The highest speed of any hand during the motion [m/s]."""
        times = np.linspace(self.times[0], self.times[-1], 2000)
        steps = np.linalg.norm(np.diff(self.at(times), axis=1), axis=2)
        return float(steps.max() / (times[1] - times[0]))


def grippers_by_hand(scene: Scene) -> list[list[Gripper]]:
    """Return the grippers of each hand of a scene; the first gripper moves exactly like its hand.

    Raises:
        InputError: If a gripper has no hand.
    """
    for number, gripper in enumerate(scene.grippers):
        if gripper.hand is None:
            raise InputError(
                f"scene.json: grippers.{number}.hand: must be left or right, given none; learn the fold again"
            )
    hands = [[gripper for gripper in scene.grippers if gripper.hand == name] for name in HANDS]
    return [each for each in hands if each]


def _check_unpressed(scene: Scene, source: Path | str) -> None:
    """Refuse a fold in which a body other than the hands moves the cloth, such as a press."""
    others = [body.name for body in scene.bodies if body.hand is None]
    if others:
        raise InputError(
            f"{source}: bodies: must be hands only, given a {others[0]}; robots cannot press creases, so learn the "
            "fold from a fold plan without `press`"
        )
