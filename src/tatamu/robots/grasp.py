"""The grasp of the cloth's edge in a plan, measured from the poses that the robot reaches. See docs/theory/grasp.md."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tatamu.robots.arm import Jaw
from tatamu.robots.motion import Motion
from tatamu.robots.paths import PlacedFold

UNDERNEATH = 0.003
"""Maximum height of the lower finger above the table when the jaws start to close [m]."""
ASKEW = 5e-3
"""Tolerance by which the angle of the jaws about the vertical may exceed `Jaw.yaw` [rad]."""


@dataclass(frozen=True)
class Take:
    """The grasp of one hand at the moment when its jaw starts to close."""

    arm: str
    jaw: Jaw
    depth: float
    """Distance from the cloth's edge to the place where the fingertips will meet [m]."""
    height: float
    """Height above the table of the tool T, a point between the fingertips [m]."""
    askew: float
    """Angle by which the jaw deviates from the plane at right angles to the cloth's edge, seen from above [rad]."""
    rise: float
    """Sine of the angle between the horizontal and the direction in which the jaw opens."""

    @property
    def lowest(self) -> float:
        """Height of the lower finger of the open jaw above the table [m]."""
        return self.height - (self.jaw.opening / 2 + self.jaw.thickness) * self.rise

    @property
    def held(self) -> float:
        """Depth to which the cloth is between the fingertips after the jaw has closed [m]."""
        return self.jaw.held(self.depth, self.height)


def takes(task: PlacedFold, motion: Motion, tools: np.ndarray) -> tuple[int, list[Take]]:
    """Return the index of the sample at which the jaws start to close, and the grasp of each hand.

    Args:
        task: The fold, placed in front of the robot.
        motion: The robot's motion.
        tools: Poses X_BT of each arm's tool T in the base B at the samples of the motion, shape (arms, n, 4, 4).
    """
    row = int(motion.rows("close")[0])
    X_BF = task.placement.matrix
    found = []
    for arm, curve, X_BT in zip(task.robot.folding, task.hands.curves, tools[:, row], strict=True):
        control = curve.control
        across = X_BF[:2, :2] @ (control[-1] - control[0])[:2]
        across = across / np.linalg.norm(across)
        hem = X_BF[:3, :3] @ (control[0] * [1.0, 1.0, 0.0]) + X_BF[:3, 3]
        opening = X_BT[:3, 1] * (1.0 if X_BT[2, 1] >= 0 else -1.0)
        seen = opening[:2] / max(float(np.linalg.norm(opening[:2])), 1e-9)
        found.append(
            Take(
                arm=arm.name,
                jaw=arm.jaw,
                depth=float((X_BT[:3, 3] - hem)[:2] @ across),
                height=float(X_BT[2, 3] - hem[2]),
                askew=float(np.arccos(np.clip(seen @ across, -1.0, 1.0))),
                rise=float(opening[2]),
            )
        )
    return row, found
