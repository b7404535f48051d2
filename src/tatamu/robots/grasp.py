"""The grasp of the hem in a plan, measured from the poses that the robot reaches. See docs/theory/grasp.md."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tatamu.robots.jaw import Jaw
from tatamu.robots.motion import Motion
from tatamu.robots.paths import PlacedFold

UNDERNEATH = 0.003
"""Largest height of the lower finger over the table [m]; a higher finger would pass over the hem."""
ASKEW = 5e-3
"""Amount by which the jaw's angle to the plane across the hem may exceed `Jaw.yaw` [rad]."""


@dataclass(frozen=True)
class Take:
    """One hand at the moment when its jaw starts to close."""

    arm: str
    jaw: Jaw
    depth: float
    """Distance beyond the hem's edge at which the fingertips will meet, across the hem [m]."""
    height: float
    """Height of T over the table [m]."""
    askew: float
    """Angle between the jaw's opening, seen from above, and the direction across the hem [rad]."""
    rise: float
    """Sine of the angle of the jaw's opening from level."""

    @property
    def lowest(self) -> float:
        """Height of the lower finger of the open jaw over the table [m]."""
        return self.height - (self.jaw.opening / 2 + self.jaw.thickness) * self.rise

    @property
    def held(self) -> float:
        """Depth of cloth between the fingertips when they have closed [m]."""
        return self.jaw.held(self.depth, self.height)


def takes(task: PlacedFold, motion: Motion, tools: np.ndarray) -> tuple[int, list[Take]]:
    """Return the row at which the jaws start to close, and the grasp of each hand.

    Args:
        task: The fold before the robot.
        motion: The robot's motion.
        tools: X_BT of each arm at its samples, shape (arms, n, 4, 4).
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
