"""Describes the pose of a coordinate frame on the table: two coordinates and an angle.

The pose of a board in the robot's base frame is given by the user, or found by touching its marks with the robot.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tatamu.base.errors import InputError

MAX_POSITION = 10.0
"""Maximum coordinate in the robot's base frame [m]."""


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


def parse_pose(text: str, option: str) -> Pose:
    """Read the pose of a board from a text "x,y,yaw" [m, m, rad] of the command's `option`."""
    values = _numbers(text, option, "x,y,yaw in metres and radians", (3,))
    if max(abs(values[0]), abs(values[1])) > MAX_POSITION or abs(values[2]) > 6.3:
        raise InputError(
            f"{option}: x and y must be within ±{MAX_POSITION:g} m, and yaw within ±6.3 rad, given {text!r}"
        )
    return Pose(*values)


def parse_touched(text: str) -> np.ndarray:
    """Read three touched marks [m] from a text "x,y[,z] x,y[,z] x,y[,z]", shape (3, 2) or (3, 3)."""
    parts = text.split()
    if len(parts) != 3:
        raise InputError(f"touch: must be the three marks A, B and C, each as x,y or x,y,z in metres, given {text!r}")
    places = [_numbers(part, "touch", "x,y or x,y,z in metres", (2, 3)) for part in parts]
    if len({len(place) for place in places}) != 1:
        raise InputError(f"touch: z must be given for all three marks or for none, given {text!r}")
    found = np.array(places)
    if np.abs(found).max() > MAX_POSITION:
        raise InputError(f"touch: coordinates must be within ±{MAX_POSITION:g} m, given {text!r}")
    return found


def touched_pose(marks: np.ndarray, touched: np.ndarray) -> Pose:
    """Return the pose of a board in the robot's base frame, in which its marks A, B and C were touched.

    Raises:
        InputError: If the touched positions do not fit the board, or the table is not level.
    """
    pose = Pose.moving(marks, touched[:, :2])
    off = np.linalg.norm(pose.place(marks) - touched[:, :2], axis=1)
    if off.max() > 0.005:
        worst = f"mark {'ABC'[int(off.argmax())]} is off by {1e3 * off.max():.0f} mm"
        raise InputError(
            f"touch: must agree with the marks on the board within 5 mm, but {worst}; touch A, B and C in this order, "
            "and check `bar` in the board's file"
        )
    if touched.shape[1] == 3 and np.ptp(touched[:, 2]) > 0.01:
        given = f"given {1e3 * np.ptp(touched[:, 2]):.0f} mm"
        raise InputError(f"touch: the heights of the marks must differ by at most 10 mm, {given}")
    return pose


def _numbers(text: str, option: str, what: str, counts: tuple[int, ...]) -> list[float]:
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) not in counts or not np.isfinite(values).all():
        raise InputError(f"{option}: must be {what}, given {text!r}")
    return values
