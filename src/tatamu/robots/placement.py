"""Placements of the fold before the robot, and orientations of the tools: the candidates that reach rates.

B is the robot's base, F the fold's frame, T the tool. A placement is X_BF, turned about z only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tatamu.robots.chain import Chain
from tatamu.robots.pose import pose, turn

LIFT = 0.06
"""Retreat of the tool from the cloth before the grasp and after the release, along its approach [m]."""


@dataclass(frozen=True)
class Placement:
    """X_BF."""

    x: float
    """Origin of F in B [m]."""
    y: float
    z: float
    """Height of the table top in B [m]."""
    yaw: float
    """Rotation about z [rad]."""
    turning: float = 0.0
    """Fraction by which the trunk turns with the hands: 0 not at all, 1 facing the middle between them."""

    def trunk(self, points: np.ndarray) -> np.ndarray:
        """The trunk's angle [rad] (n,) when the hands are at points (2, n, 3) of F."""
        middle = points.mean(axis=0) @ self.matrix[:3, :3].T + self.matrix[:3, 3]
        return self.turning * np.arctan2(middle[:, 1], middle[:, 0])

    @property
    def matrix(self) -> np.ndarray:
        """X_BF, shape (4, 4)."""
        return pose(turn(2, self.yaw), np.array([self.x, self.y, self.z]))

    def begins(self, points: np.ndarray) -> float:
        """Distance of the nearest of points (.., 3) of F before the robot, along x of B [m]."""
        return float((points @ self.matrix[0, :3]).min() + self.x)

    def __str__(self) -> str:
        turning = f", trunk turning by {self.turning:.0%}" if self.turning else ""
        return (
            f"x {self.x:.3f} m, y {self.y:.3f} m, yaw {np.degrees(self.yaw):.0f} deg, table at {self.z:.3f} m{turning}"
        )


@dataclass(frozen=True)
class Hold:
    """Orientation of one tool while it holds the cloth, constant from grasp to release."""

    tilt: float
    """Angle of the approach direction from straight down [rad]."""
    azimuth: float
    """Heading of the lean, about z from the base's x [rad]."""

    @property
    def rotation(self) -> np.ndarray:
        """R_BT, shape (3, 3): z of T is the approach; the fingers stay side by side along y as nearly as can be."""
        down = np.array([[-1.0, 0, 0], [0, 1.0, 0], [0, 0, -1.0]])
        return turn(2, self.azimuth) @ turn(1, -self.tilt) @ turn(2, -self.azimuth) @ down


def tool_paths(placements: Sequence[Placement], holds: Sequence[Hold], points: np.ndarray) -> np.ndarray:
    """X_BT for points in F (n, 3) [m], before and after them the tool drawn back by LIFT.

    Returns:
        Shape (placements, holds, n + 2, 4, 4).
    """
    X_BF = np.stack([placement.matrix for placement in placements])
    R_BT = np.stack([hold.rotation for hold in holds])
    p_BT = points @ X_BF[:, :3, :3].transpose(0, 2, 1) + X_BF[:, None, :3, 3]  # (placements, n, 3)
    p_BT = np.concatenate([p_BT[:, :1], p_BT, p_BT[:, -1:]], axis=1)
    p_BT = np.repeat(p_BT[:, None], len(holds), axis=1)
    for end in (0, -1):
        p_BT[:, :, end] -= LIFT * R_BT[:, :, 2]
    return pose(R_BT[None, :, None], p_BT)


def _leaning(degrees: Sequence[float]) -> list[Hold]:
    leaning = [Hold(float(tilt), azimuth * np.pi / 4) for tilt in np.radians(degrees) for azimuth in range(8)]
    return [Hold(0.0, 0.0), *leaning]


HOLDS = _leaning([15, 30])
"""Straight down, and leaning in eight directions."""
FINE_HOLDS = _leaning([8, 15, 22, 30])
"""Finer leans, for the neighbourhood of a good placement."""


TURNS = [
    (float(np.radians(yaw)), trunk)
    for yaw, trunk in (
        (0, (0.0,)),
        (25, (0.0, 1.0)),
        (-25, (0.0, 1.0)),
        (50, (0.5, 1.0)),
        (-50, (0.5, 1.0)),
        (75, (0.5, 1.0)),
        (-75, (0.5, 1.0)),
    )
]
"""Headings of the fold in B, from straight ahead [rad], each with the fraction by which the trunk may turn: a fold that
goes sideways needs it."""


def grid(
    chains: tuple[Chain, Chain], points: np.ndarray, heights: tuple[float, float], front: float, trunk: bool
) -> list[Placement]:
    """Placements before the robot: near to far, left to right, low to high, and turned.

    Args:
        chains: Both arms.
        points: Both hands' paths in F [m], shape (2, n, 3).
        heights: Lowest and highest table top in B [m].
        front: Near edge of the table, along x of B [m].
        trunk: Whether the robot can turn its trunk; it does for folds that go sideways.
    """
    shoulder = np.mean([chain.shoulder for chain in chains], axis=0)
    reach = min(chain.reach for chain in chains)
    levels = np.linspace(*heights, 1 if heights[0] == heights[1] else 4)
    heading = _heading(points)
    return [
        _beginning(front + ahead * reach, shoulder[1] + aside * reach, float(level), yaw - heading, points, turning)
        for ahead in np.linspace(0, 0.36, 7)
        for aside in (-0.15, 0.0, 0.15)
        for yaw, turnings in TURNS
        for level in levels
        for turning in (turnings if trunk else (0.0,))
    ]


def neighbours(best: Placement, points: np.ndarray, heights: tuple[float, float], front: float) -> list[Placement]:
    """Placements around a good one, half a step of the grid away."""
    steps = np.array(
        [
            *([x, y, z, 0.0] for x in (-0.02, 0.0, 0.02) for y in (-0.03, 0.0, 0.03) for z in (-0.02, 0.0, 0.02)),
            *([0.0, 0.0, 0.0, yaw] for yaw in np.radians([-12, 12])),
        ]
    )
    found = [Placement(best.x + x, best.y + y, best.z + z, best.yaw + yaw, best.turning) for x, y, z, yaw in steps]
    return [place for place in found if heights[0] <= place.z <= heights[1] and place.begins(points) >= front]


def _heading(points: np.ndarray) -> float:
    """Heading of the hands, about z from x of F [rad]: not every step of a plan goes along x."""
    x, y = (points[:, -1] - points[:, 0]).mean(axis=0)[:2]
    return float(np.arctan2(y, x))


def _beginning(x: float, y: float, z: float, yaw: float, points: np.ndarray, turning: float) -> Placement:
    """The placement that brings the nearest of points (.., 3) of F to x of B, and their middle to y."""
    ahead, aside = (points @ row for row in pose(turn(2, yaw), np.zeros(3))[:2, :3])
    return Placement(float(x - ahead.min()), float(y - (aside.min() + aside.max()) / 2), z, float(yaw), turning)
