"""Describes the pose of a coordinate frame on the table: two coordinates and an angle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Pose:
    """The position and direction of a frame on the table, given in another frame, the outer frame."""

    x: float = 0.0
    """Coordinate x of the frame's origin in the outer frame [m]."""
    y: float = 0.0
    """Coordinate y of the frame's origin in the outer frame [m]."""
    yaw: float = 0.0
    """Angle from the outer frame's x axis to this frame's x axis, counter-clockwise [rad]."""

    @property
    def rotation(self) -> np.ndarray:
        """Matrix that converts directions from this frame to the outer frame, shape (2, 2)."""
        cosine, sine = np.cos(self.yaw), np.sin(self.yaw)
        return np.array([[cosine, -sine], [sine, cosine]])

    def place(self, points: np.ndarray) -> np.ndarray:
        """Convert n points, shape (n, 2), from this frame to the outer frame."""
        return np.asarray(points @ self.rotation.T + [self.x, self.y])

    def seen_from(self, points: np.ndarray) -> np.ndarray:
        """Convert n points, shape (n, 2), from the outer frame to this frame."""
        return np.asarray((points - [self.x, self.y]) @ self.rotation)

    def within(self, outer: Pose) -> Pose:
        """Return the pose of this frame in the frame in which its outer frame has the pose `outer`."""
        x, y = outer.place(np.array([[self.x, self.y]]))[0]
        return Pose(float(x), float(y), wrapped(self.yaw + outer.yaw))

    @classmethod
    def moving(cls, points: np.ndarray, places: np.ndarray) -> Pose:
        """Return the pose that moves points onto places by least squares, shape (n, 2) each."""
        a, b = points - points.mean(axis=0), places - places.mean(axis=0)
        yaw = float(np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a * b).sum()))
        x, y = places.mean(axis=0) - cls(yaw=yaw).place(points).mean(axis=0)
        return cls(float(x), float(y), yaw)

    def __str__(self) -> str:
        return f"{self.x:.4f},{self.y:.4f},{self.yaw:.4f}"


def wrapped(angle: float) -> float:
    """Return an angle [rad] changed by full turns to a value between -pi and pi."""
    return float(np.arctan2(np.sin(angle), np.cos(angle)))
