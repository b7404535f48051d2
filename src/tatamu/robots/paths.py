"""The path of the whole motion in joint angles: approach, lower, enter, fold, raise, return.

As in the paper (section VI-C), the joints of both arms pass smoothly through via-points, one every ten frames.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline

from tatamu.robots.arm import Arm
from tatamu.robots.chain import LENGTH, Chain
from tatamu.robots.hands import HandMotion
from tatamu.robots.model import Robot
from tatamu.robots.placement import LIFT, UNDER, Grip, Hold, Placement, Refused
from tatamu.robots.pose import out_of, pose
from tatamu.simulation.rollout import Rollout
from tatamu.study.folder import ResultFolder
from tatamu.study.result import Result

CLOSE_ENOUGH = 1.5e-4
"""Maximum distance between tools and the hands' curves without a further via-point [m]."""
NEAR, ALIGNED = 1e-4, 1e-3
"""Limits for a tool's distance [m] and angle [rad] from its target pose.

Messages about a missed pose report only distances and angles above these limits.
"""


@dataclass(frozen=True)
class Stage:
    """One part of the motion: the configuration q as a function q(s) of a parameter s."""

    name: str
    spline: CubicSpline
    """Configurations of all joints of the robot [rad] as a function of s."""
    rate: float
    """Upper bound on ds/dt, where t is the time of the robot's motion [s]."""


@dataclass(frozen=True)
class PlacedFold:
    """A fold at a placement in front of a robot."""

    robot: Robot
    hands: HandMotion
    placement: Placement
    holds: tuple[Hold, ...]
    """Orientation of the tool at the grasp, for each hand."""
    source: Result | ResultFolder
    """The learned fold, in memory or in a folder whose files other than `manipulation.json` may be missing."""
    hover: float = 0.0
    """Height by which the whole fold is raised above the table [m]. Above 0, the hands grasp nothing."""

    @property
    def cloth(self) -> Rollout | None:
        """The simulated motion of the cloth; None if the folder of the fold has none."""
        return cloth_of(self.source)

    @property
    def table(self) -> float:
        """Height of the table top in the base B [m]."""
        return self.placement.z - self.hover

    def hovering(self, height: float) -> PlacedFold:
        """Return the same fold, raised above the table by this height [m]."""
        placement = replace(self.placement, z=self.table + height)
        return replace(self, placement=placement, hover=height)

    def trunk(self, times: np.ndarray) -> np.ndarray:
        """Return the trunk's angles [rad] at n simulated times [s], shape (n,)."""
        return self.placement.trunk(self.hands.at(times))

    def tools(self, times: np.ndarray) -> np.ndarray:
        """Return the poses X_BT of each arm's tool T in the base B at n simulated times [s], shape (arms, n, 4, 4)."""
        points = out_of(self.placement.matrix, self.hands.at(times))
        return np.array([pose(R, p + offset) for (R, offset, _), p in zip(self.grips, points, strict=True)])

    @cached_property
    def grips(self) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """The values of `Grip.tool` for each arm."""
        grips = grips_of(self.robot, self.hands)
        return [grip.tool(self.placement.yaw, hold) for grip, hold in zip(grips, self.holds, strict=True)]


def grips_of(robot: Robot, hands: HandMotion) -> list[Grip]:
    """Return the grip of each hand by the arm that follows it."""
    ends = hands.at(hands.times[[0, -1]])
    return [Grip.of(arm.jaw, path) for arm, path in zip(robot.folding, ends, strict=True)]


def cloth_of(fold: Result | ResultFolder) -> Rollout | None:
    """Return the simulated motion of the cloth in a learned fold; None if the folder of the fold has none."""
    return fold.rollout if isinstance(fold, Result) or fold.rollout_file.is_file() else None


def tool_poses(robot: Robot, chains: tuple[Chain, ...], q: np.ndarray) -> np.ndarray:
    """Return the poses X_BT of each arm's tool in configurations [rad], shape (n, nq), as shape (arms, n, 4, 4)."""
    trunk = q[:, robot.columns[robot.trunk]] if robot.trunk else np.zeros(len(q))
    return np.array(
        [
            chain.trunk_pose(trunk) @ chain.tool(q[:, robot.arm_columns(arm)])[0]
            for chain, arm in zip(chains, robot.folding, strict=True)
        ]
    )


@dataclass(frozen=True)
class Missed:
    """A tool pose that has no solution near the previous pose."""

    point: int
    """Index of the pose on the path."""
    arm: str
    distance: float
    """Distance from the tool to its target position [m]."""
    turn: float
    """Angle between the orientation of the tool and its target orientation [rad]."""
    joint: str | None
    """A joint that is at its limit; None if no joint is at its limit."""

    @property
    def reason(self) -> str:
        """Explanation why the pose has no solution, as text."""
        if self.joint:
            why = f"{self.joint} is at its limit"
        elif self.distance > NEAR:
            why = "the hand is out of reach"
        elif self.turn > ALIGNED:
            why = "the hand reaches the position, but cannot turn its jaws as needed"
        else:
            why = "its joints cannot move on from a singular pose"
        distance = f"{1e3 * self.distance:.1f} mm" if self.distance > NEAR else ""
        turn = f"{np.degrees(self.turn):.1f} deg" if self.turn > ALIGNED else ""
        left = " and ".join(filter(None, (distance, turn)))
        return why + (f" ({left} from the target)" if left else "")


def follow(
    robot: Robot, chains: tuple[Chain, ...], tools: np.ndarray, trunk: np.ndarray, start: np.ndarray
) -> tuple[np.ndarray, Missed | None]:
    """Return the configurations of the robot along the arms' tool poses, each solved from the one before.

    Args:
        robot: The robot.
        chains: Chains of the arms that fold.
        tools: Poses X_BT of the tool T in the base B for each arm that folds, shape (arms, n, 4, 4).
        trunk: Given angle of the trunk at each pose [rad], shape (n,).
        start: Angles of all nq joints at the start [rad], shape (nq,).

    Returns:
        Configurations [rad] for the first m poses, shape (m, nq), and the next pose, which has no solution. If all
        n poses have a solution, m is n, and None is returned instead of the next pose.
    """
    found = np.tile(start, (tools.shape[1], 1))
    if robot.trunk is not None:
        found[:, robot.columns[robot.trunk]] = trunk
    missed: list[Missed] = []
    for arm, chain, poses in zip(robot.folding, chains, tools, strict=True):
        columns = robot.arm_columns(arm)
        angles = start[None, columns]
        for point, target in enumerate(chain.before_trunk(poses, trunk)):
            solved, reached = chain.solve(target[None], angles, steps=60, tolerance=2e-6, damping=1e-9)
            if not reached[0]:
                missed.append(_missed(arm, chain, point, solved, target))
                break
            found[point, columns] = angles = solved
    first = min(missed, key=lambda each: each.point, default=None)
    return (found, None) if first is None else (found[: first.point], first)


def _missed(arm: Arm, chain: Chain, point: int, angles: np.ndarray, target: np.ndarray) -> Missed:
    error = chain.error(angles, target[None])[0][0]
    room = np.abs(angles[0, :, None] - chain.limits).min(axis=1)
    joint = arm.joints[int(room.argmin())] if room.min() < 1e-4 else None
    return Missed(point, arm.name, float(np.linalg.norm(error[:3])), float(np.linalg.norm(error[3:])) / LENGTH, joint)


class Paths:
    """Finds the path of the joints for each stage of a placed fold."""

    def __init__(self, task: PlacedFold) -> None:
        self.task = task
        self.chains = tuple(Chain.of(task.robot, arm) for arm in task.robot.folding)

    def stages(self, lower_speed: float, raise_speed: float) -> list[Stage]:
        """Return all stages in order.

        Args:
            lower_speed: Speed of the tools towards the cloth [m/s].
            raise_speed: Speed of the tools along the table and away from the cloth [m/s].

        Raises:
            Refused: If an arm cannot follow the hands.
        """
        first, last = float(self.task.hands.times[0]), float(self.task.hands.times[-1])
        lift, under = np.linspace(0, LIFT, 7), np.linspace(0, UNDER, 5)
        # The tools move along their axes down to the table, next to the edge of the cloth.
        beside = self._beside(first, np.full(len(lift), UNDER), LIFT - lift)
        lower = self._line(first, lift, beside, self._before(), 0.0)
        # They move to the edge of the cloth, with one finger under the cloth and one finger over it.
        enter = self._line(first, under, self._beside(first, UNDER - under), lower(LIFT), 0.0)
        fold = self._fold(enter(UNDER))
        # They leave the folded edge along their axes, so no finger lifts the edge.
        leave = self._line(last, lift, self._back(last, lift), fold(last), 1.0)
        home = self.task.robot.initial
        return [
            Stage("approach", CubicSpline([0, 1], [home, lower(0)]), np.inf),
            Stage("lower", lower, lower_speed),
            Stage("enter", enter, raise_speed),
            Stage("fold", fold, 1.0),  # the robot is never faster than the simulated hands
            Stage("raise", leave, raise_speed),
            Stage("return", CubicSpline([0, 1], [leave(LIFT), home]), np.inf),
        ]

    def _before(self) -> np.ndarray:
        """Return the configuration before the grasp: the tools are next to the cloth's edges and above them."""
        targets = self._beside(float(self.task.hands.times[0]), np.array([UNDER]), LIFT)
        trunk = self.task.trunk(self.task.hands.times[:1])
        angles = [
            chain.solve(chain.before_trunk(X, trunk), arm.initial[None], steps=30)[0][0]
            for chain, X, arm in zip(self.chains, targets, self.task.robot.folding, strict=True)
        ]
        return self.task.robot.configuration(angles, trunk[0])

    def _back(self, time: float, distances: np.ndarray) -> np.ndarray:
        """Return tool poses that are moved back along the tools' axes by n distances [m], shape (arms, n, 4, 4)."""
        offsets = pose(np.eye(3), np.outer(-distances, [0.0, 0.0, 1.0]))
        return self.task.tools(np.array([time])) @ offsets

    def _beside(self, time: float, distances: np.ndarray, back: np.ndarray | float = 0.0) -> np.ndarray:
        """Return tool poses that are moved out from under the edge of the cloth, shape (arms, n, 4, 4)."""
        tools = self._back(time, np.broadcast_to(back, np.broadcast_shapes(np.shape(back), distances.shape)))
        ahead = np.array([ahead for _, _, ahead in self.task.grips])
        tools[:, :, :3, 3] -= distances[None, :, None] * ahead[:, None, :]
        return tools

    def _line(self, time: float, s: np.ndarray, tools: np.ndarray, start: np.ndarray, progress: float) -> CubicSpline:
        trunk = np.full(len(s), self.task.trunk(np.array([time]))[0])
        q, missed = follow(self.task.robot, self.chains, tools, trunk, start)
        if missed:
            raise self._unreachable(missed, time, progress)
        return CubicSpline(s, q)

    def _fold(self, start: np.ndarray) -> CubicSpline:
        times = self.task.hands.times
        for _ in range(4):
            tools = self.task.tools(times)
            q, missed = follow(self.task.robot, self.chains, tools, self.task.trunk(times), start)
            if missed:
                time = float(times[missed.point])
                raise self._unreachable(missed, time, (time - times[0]) / (times[-1] - times[0]))
            spline = CubicSpline(times, q, bc_type="clamped")
            between = (times[1:] + times[:-1]) / 2
            wrong = self._error(spline, between) > CLOSE_ENOUGH
            if not wrong.any():
                break
            times = np.sort(np.append(times, between[wrong]))
        return spline

    def _error(self, spline: CubicSpline, times: np.ndarray) -> np.ndarray:
        """Return the distances between the tools on a path and their wanted positions at n times [m], shape (n,)."""
        wanted, q = self.task.tools(times)[:, :, :3, 3], spline(times)
        reached = tool_poses(self.task.robot, self.chains, q)[:, :, :3, 3]
        return np.linalg.norm(reached - wanted, axis=2).max(axis=0)

    def _unreachable(self, missed: Missed, time: float, progress: float) -> Refused:
        frame = self.task.hands.frame(time)
        return Refused(
            f"{missed.arm} cannot follow its hand at frame {frame} ({time:.2f} s): {missed.reason} "
            f"({self.task.placement})",
            progress,
        )
