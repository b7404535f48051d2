"""The motion of one arm along the path of one hand, for many placements and holds.

Each point is solved from the joint angles of the point before, so a path that needs a jump counts as unreachable.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tatamu.robots.arm import Arm
from tatamu.robots.chain import Chain
from tatamu.robots.model import Robot
from tatamu.robots.placement import Hold, Placement, tool_paths

GOOD_MARGIN = 0.2
"""Distance from joint limits above which the quality of a motion does not improve [rad]."""
GOOD_SINGULARITY = 0.2
"""Value of `Chain.singularity` above which the quality of a motion does not improve."""
HOPELESS = -1.0
"""Quality of a motion that is not considered further."""
CLEAR = 3
"""Maximum number of holds that are kept for each arm and placement."""


@dataclass(frozen=True)
class ArmReach:
    """The motion of one arm along the path of one hand, for every placement and hold."""

    arm: Arm
    holds: list[Hold]
    """Orientations of the hand."""
    quality: np.ndarray
    """1 if the motion is comfortable, 0 if just possible, negative if impossible, shape (placements, holds)."""
    reached: np.ndarray
    """Number of path points that the arm reaches before the first failure, shape (placements, holds)."""
    angles: np.ndarray
    """Joint angles [rad], shape (placements, holds, points, k) for k joints."""

    def way(self, placement: int, hold: int) -> np.ndarray:
        """Return the joint angles from the initial pose along the path and back to the initial pose [rad]."""
        return from_start(self.angles[placement, hold], self.arm.initial)

    def best(self, placement: int) -> np.ndarray:
        """Return the indices of the best holds at a placement, the best first."""
        order = np.argsort(-self.quality[placement], kind="stable")[:CLEAR]
        return order[self.quality[placement][order] > HOPELESS]


def follow(
    robot: Robot,
    arm: Arm,
    placements: list[Placement],
    holds: list[Hold],
    trunk: np.ndarray,
    path: np.ndarray,
    steps: np.ndarray,
) -> ArmReach:
    """Follow one hand's path from every placement with every hold.

    Args:
        robot: The robot.
        arm: The arm that follows the path.
        placements: Candidate placements.
        holds: Candidate orientations.
        trunk: The trunk's angles from approach to retreat [rad], shape (placements, n + 2).
        path: The hand's path in F [m], shape (n, 3).
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
    shallow = np.array([0.3 * (1 - hold.tilt / (np.pi / 2)) + 0.3 * abs(hold.yaw) for hold in holds])
    quality = quality.reshape(shape)
    quality = np.where(quality > 0, quality / (1 + shallow), quality)
    return ArmReach(arm, holds, quality, reached.reshape(shape), angles.reshape(*shape, *angles.shape[1:]))


def from_start(angles: np.ndarray, start: np.ndarray | float) -> np.ndarray:
    """Return a motion [rad] with three poses each on the way from the initial pose and back to it."""
    way = np.array([0.25, 0.5, 0.75]).reshape(-1, *([1] * np.ndim(start)))
    there, back = start + way * (angles[0] - start), start + way[::-1] * (angles[-1] - start)
    return np.concatenate([there, angles, back])


def _track(chain: Chain, targets: np.ndarray, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the joint angles along each motion, and the number of points that the arm reaches in the motion."""
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
    """Return the quality of each of n motions of an arm, shape (n,)."""
    count, points, width = angles.shape
    margin = chain.margin(angles.reshape(-1, width)).reshape(count, points).min(axis=1) / GOOD_MARGIN
    some = angles[:, ::2]
    singular = chain.singularity(some.reshape(-1, width)).reshape(some.shape[:2]).min(axis=1) / GOOD_SINGULARITY
    return np.minimum(1.0, np.minimum(margin, singular)) / np.sqrt(slowing(arm, angles[:, 1:-1], steps))


def slowing(arm: Arm, angles: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Estimate by which factor, at least 1, each of n motions must be slowed down, shape (n,).

    `angles` [rad] have the shape (n, m, k), and `steps` [s], from point to point, the shape (m - 1,).
    """
    speed = np.diff(angles, axis=1) / steps[:, None]
    rate = np.diff(speed, axis=1) / ((steps[1:] + steps[:-1]) / 2)[:, None]
    fast = (np.abs(speed) / arm.planned_speed).max(axis=(1, 2))
    hard = (np.abs(rate) / arm.planned_acceleration).max(axis=(1, 2))
    return np.maximum(1.0, np.maximum(fast, np.sqrt(hard)))
