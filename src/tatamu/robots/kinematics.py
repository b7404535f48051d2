"""Inverse kinematics along the tool paths of all arms that fold at the same time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tatamu.robots.arm import Arm
from tatamu.robots.chain import LENGTH, Chain
from tatamu.robots.model import Robot

REACHED = 2e-6
"""Limit for the error of a tool pose [m]. If the error is smaller, the tool has reached its target pose.

Rotation errors [rad] are converted to metres by the factor `chain.LENGTH` [m per rad].
"""
STEPS, DAMPING = 60, 1e-9
"""Maximum number of iterations for a pose, and the damping of their steps."""
NEAR, ALIGNED = 1e-4, 1e-3
"""Limits for a tool's distance [m] and angle [rad] from its target pose.

Messages about a missed pose report only distances and angles above these limits.
"""


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
            why = "the hand gets there, but cannot turn its jaws as needed"
        else:
            why = "its joints cannot move on from a singular pose"
        left = [
            *([f"{1e3 * self.distance:.1f} mm"] if self.distance > NEAR else []),
            *([f"{np.degrees(self.turn):.1f} deg"] if self.turn > ALIGNED else []),
        ]
        return why + (f", {' and '.join(left)} are left" if left else "")


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
            solved, reached = chain.solve(target[None], angles, STEPS, REACHED, DAMPING)
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
