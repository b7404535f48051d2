"""The motion of one arm along the path of one hand, for many placements and holds.

A placement is a pose of the fold in front of the robot. A hold is an orientation in which the hand grasps the cloth.

The inverse kinematics is solved from point to point by damped least squares. The solution for a point starts from the
joint angles of the previous point. A path that would need a jump of the joints therefore counts as unreachable.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tatamu.robots.chain import Chain
from tatamu.robots.model import Arm, Robot
from tatamu.robots.placement import ASIDE, SHALLOW, Hold, Placement, tool_paths

GOOD_MARGIN = 0.2
"""Sufficient distance of an arm from its joint limits [rad].

A larger distance does not improve the quality of a motion.
"""
GOOD_SINGULARITY = 0.2
"""Sufficient distance of an arm from singularities, as computed by `Chain.singularity`.

A larger distance does not improve the quality of a motion.
"""
HOPELESS = -1.0
"""Lower limit for the quality of an arm's motion. Only motions above this limit are considered further."""
CLEAR = 3
"""Largest number of holds that are kept for each arm and placement: those with the best quality.

A hold is an orientation of the hand at the grasp.
"""


@dataclass(frozen=True)
class ArmReach:
    """The motion of one arm along the path of one hand, for every placement and hold.

    A placement is a pose of the fold in front of the robot. A hold is an orientation of the hand at the grasp.
    """

    quality: np.ndarray
    """Quality of the motion for each placement and hold, shape (placements, holds).

    The quality is 1 if the motion is comfortable, 0 if it is just possible, and negative if it is impossible.
    """
    reached: np.ndarray
    """Number of path points that the arm reaches before the first failure, shape (placements, holds)."""
    angles: np.ndarray
    """Joint angles [rad], shape (placements, holds, points, k) for k joints."""

    def best(self, placement: int) -> np.ndarray:
        """Return the indices of the best holds at a placement, in the order of their quality, the best first."""
        order = np.argsort(-self.quality[placement], kind="stable")[:CLEAR]
        return order[self.quality[placement][order] > HOPELESS]


def follow(
    robot: Robot,
    arm: Arm,
    placements: list[Placement],
    holds: Sequence[Hold],
    trunk: np.ndarray,
    path: np.ndarray,
    steps: np.ndarray,
) -> ArmReach:
    """Follow one hand's path from every placement.

    Args:
        robot: The robot.
        arm: The arm that follows the path.
        placements: Candidate poses of the fold in front of the robot.
        holds: Candidate orientations of the hand at the grasp.
        trunk: The trunk's angle [rad] for each placement and point, shape (placements, n + 2). The two additional
            points are the approach before the path and the retreat after it.
        path: The n points of the hand's path in the frame F of the fold [m], shape (n, 3).
        steps: Times from point to point [s], shape (n - 1,).
    """
    chain = Chain.of(robot, arm)
    shape = (len(placements), len(holds))
    targets = chain.before_trunk(tool_paths(placements, holds, path, arm.jaw), trunk[:, None])
    targets = targets.reshape(-1, len(path) + 2, 4, 4)
    angles, reached = _track(chain, targets, arm.initial)
    whole = np.flatnonzero(reached == targets.shape[1])
    quality = np.full(len(targets), 2 * HOPELESS)
    quality[whole] = _quality(chain, arm, angles[whole], steps)
    shallow = np.array([SHALLOW * (1 - hold.tilt / (np.pi / 2)) + ASIDE * abs(hold.yaw) for hold in holds])
    quality = quality.reshape(shape)
    quality = np.where(quality > 0, quality / (1 + shallow), quality)
    return ArmReach(quality, reached.reshape(shape), angles.reshape(*shape, *angles.shape[1:]))


def _track(chain: Chain, targets: np.ndarray, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the joint angles along each motion, and the number of points that the arm reaches in the motion.

    `targets` has the poses of n motions with m points each, shape (n, m, 4, 4). The joint angles have the shape (n, m,
    k) for k joints, and the numbers have the shape (n,). Only points before the first failure count as reached.
    """
    count, points = targets.shape[:2]
    angles = np.full((count, points, len(start)), np.nan)
    reached = np.zeros(count, dtype=np.int64)
    alive = np.flatnonzero(chain.near(targets[:, :, :3, 3]))
    last = np.tile(start, (len(alive), 1))
    for point in range(points):
        last, there = chain.solve(targets[alive, point], last, steps=25 if point == 0 else 6)
        alive, last = alive[there], last[there]
        angles[alive, point] = last
        reached[alive] = point + 1
    return angles, reached


def _quality(chain: Chain, arm: Arm, angles: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Return the quality of each of n motions of an arm, shape (n,).

    `angles` are the joint angles of each motion at m points for k joints, shape (n, m, k).

    The smallest distance from joint limits is divided by GOOD_MARGIN, and the smallest distance from singularities is
    divided by GOOD_SINGULARITY. The smaller of these two ratios, or 1 if both are above 1, is then divided by the
    square root of `slowing`. The result is the quality. Motions that the arm must slow down therefore have a lower
    quality.
    """
    count, points, width = angles.shape
    margin = chain.margin(angles.reshape(-1, width)).reshape(count, points).min(axis=1) / GOOD_MARGIN
    some = angles[:, ::2]
    singular = chain.singularity(some.reshape(-1, width)).reshape(some.shape[:2]).min(axis=1) / GOOD_SINGULARITY
    return np.minimum(1.0, np.minimum(margin, singular)) / np.sqrt(slowing(arm, angles[:, 1:-1], steps))


def slowing(arm: Arm, angles: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Estimate by which factor each of n motions must be slowed down to respect the arm's limits, shape (n,).

    The factor is at least 1. `angles` [rad] are the angles of k joints at the m points of each motion, shape (n, m, k).
    `steps` [s] are the times from point to point, shape (m - 1,).
    """
    speed = np.diff(angles, axis=1) / steps[:, None]
    rate = np.diff(speed, axis=1) / ((steps[1:] + steps[:-1]) / 2)[:, None]
    fast = (np.abs(speed) / arm.planned_speed).max(axis=(1, 2))
    hard = (np.abs(rate) / arm.planned_acceleration).max(axis=(1, 2))
    return np.maximum(1.0, np.maximum(fast, np.sqrt(hard)))
