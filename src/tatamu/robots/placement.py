"""Placements of the fold in front of the robot, and orientations of the tools. `reach` rates these candidates.

B is the robot's base, F the fold's frame, T the tool.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tatamu.base.errors import TatamuError
from tatamu.robots.arm import Arm, Jaw
from tatamu.robots.chain import Chain
from tatamu.robots.model import Robot
from tatamu.robots.pose import out_of, pose, turn

LIFT = 0.06
"""Distance of the tool from the cloth before the grasp and after the release, along its approach [m]."""
UNDER = 0.02
"""Horizontal distance from the grasp to the place where the tool comes down to the table [m]."""


class Refused(TatamuError):
    """A placement was refused; `progress` is larger if more steps succeeded before."""

    def __init__(self, message: str, progress: float) -> None:
        super().__init__(message)
        self.progress = progress


@dataclass(frozen=True)
class Placement:
    """The pose X_BF of the fold in the robot's base, rotated only about z."""

    x: float
    y: float
    z: float
    """Height of the table top [m]."""
    yaw: float
    turning: float = 0.0
    """Fraction by which the trunk turns towards the middle between the hands; 1 if it faces this middle."""

    def trunk(self, points: np.ndarray) -> np.ndarray:
        """Return the trunk's angles [rad] at positions of the hands in F, shape (arms, n, 3), as shape (n,)."""
        middle = out_of(self.matrix, points.mean(axis=0))
        return self.turning * np.arctan2(middle[:, 1], middle[:, 0])

    @property
    def matrix(self) -> np.ndarray:
        """The pose X_BF, shape (4, 4)."""
        return pose(turn(2, self.yaw), np.array([self.x, self.y, self.z]))

    def __str__(self) -> str:
        turning = f", trunk turning by {self.turning:.0%}" if self.turning else ""
        return (
            f"x {self.x:.3f} m, y {self.y:.3f} m, yaw {np.degrees(self.yaw):.0f} deg, table at {self.z:.3f} m{turning}"
        )


@dataclass(frozen=True)
class Hold:
    """The orientation of one hand, constant from grasp to release."""

    tilt: float
    """Angle from straight down to the direction of approach, which leans towards the cloth [rad]."""
    yaw: float = 0.0
    """Rotation of the jaws about the vertical [rad]; 0 if their plane is at right angles to the edge of the cloth."""
    flipped: bool = False
    """Whether the two fingers have swapped places."""

    def rotation(self, heading: float) -> np.ndarray:
        """Return R_BT, shape (3, 3), for a hand that folds in the direction `heading`, an angle from x of B [rad].

        Before the turn by heading and yaw, the approach z of T is (sin tilt, 0, -cos tilt), and the jaws open along y
        of T, (cos tilt, 0, sin tilt).
        """
        cosine, sine = np.cos(self.tilt), np.sin(self.tilt)
        across = np.array([[0.0, cosine, sine], [1.0, 0.0, 0.0], [0.0, sine, -cosine]])
        flip = turn(2, np.pi) if self.flipped else np.eye(3)
        return turn(2, heading + self.yaw) @ across @ flip


@dataclass(frozen=True)
class Grip:
    """The grip of one hand in F: its jaws, and the direction and height of the simulated hand."""

    jaw: Jaw
    heading: float
    """Direction in which the hand folds, an angle from x of F [rad]."""
    over: float
    """Height of the simulated hand above the table at the grasp [m]."""

    @classmethod
    def of(cls, jaw: Jaw, path: np.ndarray) -> Grip:
        """Return the grip of a hand with a path in F [m], shape (n, 3)."""
        x, y = (path[-1] - path[0])[:2]
        return cls(jaw, float(np.arctan2(y, x)), float(path[0, 2]))

    def tool(self, yaw: float, hold: Hold) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return R_BT, shape (3, 3), and two vectors in B, shape (3,), for the yaw of a placement [rad].

        The vectors are the constant offset from the simulated hand, at the edge of the cloth, to T [m], and the
        horizontal direction in which the open jaws move over the edge. The fingertips meet at `jaw.depth` from the edge
        and as low as the lower finger allows.
        """
        heading = yaw + self.heading
        across = self.jaw.depth * np.array([np.cos(heading), np.sin(heading)])
        offset = np.append(across, self.jaw.height(hold.tilt) - self.over)
        ahead = np.array([np.cos(heading + hold.yaw), np.sin(heading + hold.yaw), 0.0])
        return hold.rotation(heading), offset, ahead


def tool_paths(placements: Sequence[Placement], holds: Sequence[Hold], points: np.ndarray, jaw: Jaw) -> np.ndarray:
    """Return the poses X_BT along a hand's path of n points in F [m], shape (placements, holds, n + 2, 4, 4).

    The first pose is the approach, and the last is the retreat.
    """
    grip = Grip.of(jaw, points)
    X_BF = np.stack([placement.matrix for placement in placements])
    yaws, which = np.unique([placement.yaw for placement in placements], return_inverse=True)
    tools = [[grip.tool(float(yaw), hold) for hold in holds] for yaw in yaws]
    R_BT, offset, ahead = (np.array([[tool[part] for tool in row] for row in tools])[which] for part in range(3))
    p_BT = points @ X_BF[:, :3, :3].transpose(0, 2, 1) + X_BF[:, None, :3, 3]  # (placements, n, 3)
    p_BT = np.concatenate([p_BT[:, :1], p_BT, p_BT[:, -1:]], axis=1)
    p_BT = p_BT[:, None] + offset[:, :, None]
    for end in (0, -1):
        p_BT[:, :, end] -= LIFT * R_BT[:, :, :, 2]
    p_BT[:, :, 0] -= UNDER * ahead
    return pose(R_BT[:, :, None], p_BT)


def holds_of(arm: Arm, fine: bool = False) -> list[Hold]:
    """Return the orientations of a hand that are tried, within the limits of its jaws; more if `fine` is true.

    The hand comes from outside the cloth, and a hand with a yaw is turned towards the other hand.
    """
    tilts = (12, 20, 30, 42) if fine else (15, 30, 45)  # [degrees]
    yaws = (0, 15, 30, 45, 60) if fine else (0, 30, 60)
    (least, greatest), inwards = arm.jaw.tilt, -1.0 if arm.name == "larm" else 1.0
    tilted = [tilt for tilt in np.radians(tilts) if least <= tilt <= greatest and arm.jaw.takes_at(tilt)] or [least]
    turned = [inwards * yaw for yaw in np.radians(yaws) if yaw <= arm.jaw.yaw]
    return [Hold(float(tilt), float(yaw), flip) for tilt in tilted for yaw in turned for flip in (False, True)]


TURNS = [
    (0.0, (0.0,)),
    *(
        (float(np.radians(yaw)), trunk)
        for degrees, trunk in ((25, (0.0, 1.0)), (50, (0.5, 1.0)), (75, (0.5, 1.0)))
        for yaw in (degrees, -degrees)
    ),
]
"""Directions of the fold from straight ahead [rad], each with the values of `Placement.turning` that are tried."""


def grid(robot: Robot, points: np.ndarray, heights: tuple[float, float], straight: bool = False) -> list[Placement]:
    """Return a grid of placements in front of the robot, which differ in distance, side, height and yaw.

    Args:
        robot: The robot.
        points: Paths of the hands in F [m], shape (arms, n, 3).
        heights: Lowest and highest table top [m].
        straight: Whether the hands must move straight ahead.
    """
    chains = [Chain.of(robot, arm) for arm in robot.folding]
    shoulder = np.mean([chain.shoulder for chain in chains], axis=0)
    reach = min(chain.reach for chain in chains)
    levels = np.linspace(*heights, 1 if heights[0] == heights[1] else 4)
    x, y = (points[:, -1] - points[:, 0]).mean(axis=0)[:2]
    heading = float(np.arctan2(y, x))  # direction in which the hands move
    return [
        _beginning(
            robot.front + ahead * reach, shoulder[1] + aside * reach, float(level), yaw - heading, points, turning
        )
        for ahead in np.linspace(0, 0.36, 7)
        for aside in (-0.15, 0.0, 0.15)
        for yaw, turnings in TURNS[: 1 if straight else None]
        for level in levels
        for turning in (turnings if robot.trunk else (0.0,))
    ]


def neighbours(best: Placement, points: np.ndarray, heights: tuple[float, float], front: float) -> list[Placement]:
    """Return placements around a good placement, at about half the distance that placements in `grid` have."""
    steps = np.array(
        [
            *([x, y, z, 0.0] for x in (-0.02, 0.0, 0.02) for y in (-0.03, 0.0, 0.03) for z in (-0.02, 0.0, 0.02)),
            *([0.0, 0.0, 0.0, yaw] for yaw in np.radians([-12, 12])),
        ]
    )
    found = [Placement(best.x + x, best.y + y, best.z + z, best.yaw + yaw, best.turning) for x, y, z, yaw in steps]
    return [
        place
        for place in found
        if heights[0] <= place.z <= heights[1] and (points @ place.matrix[0, :3]).min() + place.x >= front
    ]


def _beginning(x: float, y: float, z: float, yaw: float, points: np.ndarray, turning: float) -> Placement:
    """Return the placement at which the smallest x of all `points` is `x`, and the middle of their y is `y`."""
    ahead, aside = (points @ row for row in pose(turn(2, yaw), np.zeros(3))[:2, :3])
    return Placement(float(x - ahead.min()), float(y - (aside.min() + aside.max()) / 2), z, float(yaw), turning)
