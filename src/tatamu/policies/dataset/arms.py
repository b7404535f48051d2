"""The two arms of a robot that carries out the folds of a dataset.

States and actions are joint angles [rad] and openings of the grippers (1 open, 0 closed), under LeRobot's names. The
hands' positions follow by forward kinematics. Frames: F of the fold, B of the robot's base, T of the tool.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import astuple, dataclass
from functools import lru_cache

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
from tatamu.robots.pose import into, out_of, pose
from tatamu.robots.reach import best_placements, table_heights


class OutOfReachError(TatamuError):
    """Raised if the arms cannot carry out a fold."""


class Stand(OpenRecord):
    """A robot, and the placement of the fold in front of it."""

    robot: str
    place: tuple[float, ...]
    """x, y, z [m] and yaw [rad] of F in B, and how far the trunk turns towards the hands (0 to 1)."""
    holds: tuple[tuple[float, float, bool], ...]
    """Tilt [rad], yaw [rad] and whether it is turned by half a turn, of each tool."""
    grips: tuple[tuple[float, float], ...]
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
    best = best_placements(robot, hands, heights, place=wanted.place)[0]
    if not best.is_good:
        raise InputError(
            f"robot: {wanted.name} cannot reach the largest fold of the dataset; give a smaller width and length"
        )
    return Stand(
        robot=wanted.name,
        place=astuple(best.placement),
        holds=tuple((hold.tilt, hold.yaw, hold.flipped) for hold in best.holds),
        grips=tuple((grip.heading, grip.over) for grip in grips_of(robot, hands)),
    )


@dataclass(frozen=True)
class Arms:
    """A robot's two arms, with the placement of a fold in front of the robot."""

    robot: Robot
    placement: Placement
    tools: list[tuple[np.ndarray, np.ndarray, np.ndarray]]
    """The values of `Grip.tool` for each arm."""
    chains: tuple[Chain, ...]

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
        offsets = np.array([offset for _, offset, _ in self.tools])[:, None]
        points = into(self.placement.matrix, tool_poses(self.robot, self.chains, q)[:, :, :3, 3] - offsets)
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

    def _reach(self, places: np.ndarray) -> np.ndarray:
        """Return configurations [rad] that follow pairs of positions of the tools in F [m], shape (n, 2, 3)."""
        points = out_of(self.placement.matrix, places).transpose(1, 0, 2)
        trunk = self.placement.trunk(places.transpose(1, 0, 2))
        tools = [pose(rotation, path + offset) for (rotation, offset, _), path in zip(self.tools, points, strict=True)]
        start = self.robot.configuration([arm.initial for arm in self.robot.arms])
        q, missed = follow(self.robot, self.chains, np.stack(tools), trunk, start)
        if missed is not None:
            raise OutOfReachError(f"{missed.arm} does not reach point {missed.point} of its path: {missed.reason}")
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


@lru_cache(maxsize=1)
def arms_at(stand: Stand) -> Arms:
    """Return the arms of a robot. The last ones are kept, because they take long to make."""
    robot, placement = load(stand.robot), Placement(*stand.place)
    tools = [
        Grip(arm.jaw, *grip).tool(placement.yaw, Hold(*hold))
        for arm, grip, hold in zip(robot.arms, stand.grips, stand.holds, strict=True)
    ]
    return Arms(robot, placement, tools, tuple(Chain.of(robot, arm) for arm in robot.arms))
