"""The two arms of a robot that carries out the folds of a dataset.

States and actions are joint angles [rad] and openings of the grippers (1 open, 0 closed), under LeRobot's names. The
hands' positions follow by forward kinematics. Frames: F of the fold, B of the robot's base, T of the tool.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import astuple, dataclass
from functools import cached_property

import numpy as np

from tatamu.base.errors import InputError, TatamuError
from tatamu.base.records import OpenRecord
from tatamu.folding.manipulation import Manipulation
from tatamu.policies.dataset.specification import RobotDraw
from tatamu.policies.envs.motion import Led
from tatamu.robots import load
from tatamu.robots.chain import Chain
from tatamu.robots.clearance import Clearance
from tatamu.robots.hands import HandMotion
from tatamu.robots.model import Robot
from tatamu.robots.pairs import DISTANCES
from tatamu.robots.paths import follow, grips_of, tool_poses
from tatamu.robots.placement import Grip, Hold, Placement, Refused
from tatamu.robots.pose import out_of, pose
from tatamu.robots.reach import best_placements, table_heights


class OutOfReachError(TatamuError):
    """Raised if the arms cannot carry out a fold."""


class Stand(OpenRecord):
    """A robot, and the placement of the fold in front of it."""

    robot: str
    place: list[float]
    """x, y, z [m] and yaw [rad] of F in B, and how far the trunk turns towards the hands (0 to 1)."""
    holds: list[tuple[float, float, bool]]
    """Tilt [rad], yaw [rad] and whether it is turned by half a turn, of each tool."""
    grips: list[tuple[float, float]]
    """Direction in which each hand folds, about z [rad], and height of its grasp [m]."""


def find_stand(wanted: RobotDraw, manipulation: Manipulation) -> Stand:
    """Return the best placement of a fold in front of a robot.

    Raises:
        InputError: If no robot has this name, or it cannot reach the fold.
    """
    robot = load(wanted.name)
    hands = HandMotion.exact(manipulation)
    try:
        heights = table_heights(robot, wanted.table_height)
    except Refused as error:
        raise InputError(f"robot.table_height: {error}") from None
    found = best_placements(robot, hands, heights, place=wanted.place)
    if not found.good:
        raise InputError(f"robot: {wanted.name} must reach the largest fold that may be drawn; give smaller sizes")
    return Stand(
        robot=wanted.name,
        place=list(astuple(found.placements[0])),
        holds=[(hold.tilt, hold.yaw, hold.flipped) for hold in found.holds[0]],
        grips=[(grip.heading, grip.over) for grip in grips_of(robot, hands)],
    )


@dataclass(frozen=True)
class Arms:
    """A robot's two arms, with the placement of a fold in front of the robot."""

    robot: Robot
    placement: Placement
    holds: tuple[Hold, ...]
    grips: tuple[Grip, ...]

    @classmethod
    def at(cls, stand: Stand) -> Arms:
        """Make the arms."""
        robot = load(stand.robot)
        grips = tuple(Grip(arm.jaw, *grip) for arm, grip in zip(robot.arms, stand.grips, strict=True))
        return cls(robot, Placement(*stand.place), tuple(Hold(*hold) for hold in stand.holds), grips)

    def follow(self, lead: Callable[[float], Led], largest: float, start: np.ndarray, rate: float) -> np.ndarray:
        """Return the robot's states before the first step and after each step, float32, shape (steps + 1, k).

        The path is slowed down until no joint is too fast.

        Args:
            lead: Function from the largest motion per step [m] to the path of the hands.
            largest: Largest motion of a hand in a step [m].
            start: Positions of both hands at the start [m], shape (2, 3).
            rate: Steps per second [1/s].

        Raises:
            OutOfReachError: If an arm cannot reach the path, would touch something, or is too slow.
        """
        for _ in range(4):
            led = lead(largest)
            q = self._reach(np.concatenate([start[None], led.places]))
            speed, _ = self.robot.planned()
            slower = float((np.abs(np.diff(q, axis=0)) * rate / speed).max())
            if slower <= 1.0:
                self._check_clearance(q)
                return self._states(q, led)
            largest /= 1.05 * slower
        raise OutOfReachError("the arms are too slow")

    def places(self, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the hands' positions in F [m], shape (n, 2, 3), and whether the grippers are closed, shape (n, 2).

        Args:
            numbers: States or actions, shape (n, k).
        """
        left, right = self._grippers
        angles = numbers.astype(float)
        trunk = angles[:, -1] if self.robot.trunk else 0.0
        q = self.robot.configuration([angles[:, :left], angles[:, left + 1 : right]], trunk)
        X_BF = self.placement.matrix
        offsets = np.array([offset for _, offset, _ in self._tools])[:, None]
        points = (tool_poses(self.robot, self._chains, q)[:, :, :3, 3] - offsets - X_BF[:3, 3]) @ X_BF[:3, :3]
        return points.transpose(1, 0, 2), numbers[:, [left, right]] < 0.5

    def opened(self, state: np.ndarray) -> np.ndarray:
        """Return a copy of a state with open grippers, shape (k,)."""
        found = state.copy()
        found[self._grippers] = 1.0
        return found

    @property
    def _grippers(self) -> list[int]:
        """Indices of the grippers in a state: each comes after the joints of its arm."""
        left, right = (len(arm.joints) for arm in self.robot.arms)
        return [left, left + 1 + right]

    @cached_property
    def _tools(self) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """The values of `Grip.tool` for each arm."""
        return [grip.tool(self.placement.yaw, hold) for grip, hold in zip(self.grips, self.holds, strict=True)]

    @cached_property
    def _chains(self) -> tuple[Chain, ...]:
        return tuple(Chain.of(self.robot, arm) for arm in self.robot.arms)

    def _reach(self, places: np.ndarray) -> np.ndarray:
        """Return configurations [rad] that follow pairs of positions of the tools in F [m], shape (n, 2, 3)."""
        points = out_of(self.placement.matrix, places).transpose(1, 0, 2)
        trunk = self.placement.trunk(places.transpose(1, 0, 2))
        tools = [pose(rotation, path + offset) for (rotation, offset, _), path in zip(self._tools, points, strict=True)]
        start = self.robot.configuration([arm.initial for arm in self.robot.arms])
        q, missed = follow(self.robot, self._chains, np.stack(tools), trunk, start)
        if missed is not None:
            raise OutOfReachError(f"{missed.arm} does not reach step {missed.point}: {missed.reason}")
        return q

    def _check_clearance(self, q: np.ndarray) -> None:
        for kind, found in Clearance(self.robot, table=self.placement.z).least(q).items():
            if not found.value >= DISTANCES[kind].searched:
                first, second = found.pair
                raise OutOfReachError(f"{first} comes too close to {second} at step {found.row}")

    def _states(self, q: np.ndarray, led: Led) -> np.ndarray:
        opening = np.where(np.append(False, led.closed), 0.0, 1.0)[:, None]
        parts = [part for arm in self.robot.arms for part in (q[:, self.robot.arm_columns(arm)], opening)]
        trunk = [] if self.robot.trunk is None else [q[:, [self.robot.columns[self.robot.trunk]]]]
        return np.hstack([*parts, *trunk]).astype(np.float32)
