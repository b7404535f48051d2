"""Determines the pose of a board in the robot's base frame, which the user gives or the robot touches."""

from __future__ import annotations

import numpy as np

from tatamu.base.errors import InputError
from tatamu.cameras.pose import Pose

MAX_POSITION = 10.0
"""Maximum coordinate in the robot's base frame [m]."""
TOUCHED = 0.005
"""Maximum distance between a touched mark and its place on the board [m]."""
LEVEL = 0.01
"""Maximum difference in height between the touched marks [m]."""


def parse_pose(text: str, option: str) -> Pose:
    """Read the pose of a board from a text "x,y,yaw" [m, m, rad] of the command's `option`."""
    values = _numbers(text, option, "x,y,yaw in metres and radians", (3,))
    if max(abs(values[0]), abs(values[1])) > MAX_POSITION or abs(values[2]) > 6.3:
        raise InputError(f"{option}: x and y must be within {MAX_POSITION:g} m and yaw within 6.3 rad, given {text!r}")
    return Pose(*values)


def parse_touched(text: str) -> np.ndarray:
    """Read three touched marks [m] from a text "x,y[,z] x,y[,z] x,y[,z]", shape (3, 2) or (3, 3)."""
    parts = text.split()
    if len(parts) != 3:
        raise InputError(f"touch: must be the three marks A, B and C, each as x,y or x,y,z in metres, given {text!r}")
    places = [_numbers(part, "touch", "x,y or x,y,z in metres", (2, 3)) for part in parts]
    if len({len(place) for place in places}) != 1:
        raise InputError(f"touch: must have two numbers for each mark, or three for each, given {text!r}")
    found = np.array(places)
    if np.abs(found).max() > MAX_POSITION:
        raise InputError(f"touch: must be within {MAX_POSITION:g} m, given {text!r}")
    return found


def touched_pose(marks: np.ndarray, touched: np.ndarray) -> Pose:
    """Return the pose of a board in the robot's base frame, in which its marks A, B and C were touched.

    Raises:
        InputError: If the touched positions do not fit the board, or the table is not level.
    """
    pose = Pose.moving(marks, touched[:, :2])
    off = np.linalg.norm(pose.place(marks) - touched[:, :2], axis=1)
    if off.max() > TOUCHED:
        worst = "ABC"[int(off.argmax())]
        raise InputError(
            f"touch: the marks must lie as on the board within {1e3 * TOUCHED:.0f} mm, but mark {worst} is off by "
            f"{1e3 * off.max():.0f} mm; touch A, B, C in this order, and check `bar` in the board's file"
        )
    if touched.shape[1] == 3 and np.ptp(touched[:, 2]) > LEVEL:
        raise InputError(
            f"touch: the marks must be at the same height within {1e3 * LEVEL:.0f} mm, "
            f"given heights that differ by {1e3 * np.ptp(touched[:, 2]):.0f} mm"
        )
    return pose


def _numbers(text: str, option: str, what: str, counts: tuple[int, ...]) -> list[float]:
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) not in counts or not np.isfinite(values).all():
        raise InputError(f"{option}: must be {what}, given {text!r}")
    return values
