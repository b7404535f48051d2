"""A hand as rigid bodies: two fingers close on the hem of the cloth, carry it, open and leave.

The hand comes from outside the cloth along the axis of its fingers, and keeps its orientation. At the release, the hem
has therefore turned over round the lower finger, which lies between the hem and the layers below. The upper finger
opens, then the hand draws back along its axis.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.spatial.transform import Rotation

from tatamu.base import curves
from tatamu.folding.fingers import Fingers
from tatamu.folding.manipulation import Hand
from tatamu.simulation.body import Body

AWAY = 0.05
"""Distance between the hem and a hand before it comes and after it has drawn back [m]."""
OPENING, LEAVING = 0.1, 0.3
"""Time in which fingers open, and time in which the hand then draws back [s]."""
FRAME = 1.0 / 60.0
"""Approximate time between neighbouring knots of a motion [s]."""


def leaves(fingers: Fingers) -> float:
    """Return the time that a hand takes to open and to draw back [s]."""
    return OPENING + LEAVING if fingers.stated else 0.0


@dataclass(frozen=True)
class HandPath:
    """Path of the point at the fingertips of a hand."""

    times: np.ndarray
    """Times of the k knots from 0 on [s], shape (k,)."""
    points: np.ndarray
    """Position at each knot [m], shape (k, 3)."""
    closed: float
    """Time at which the fingers have closed [s]."""
    opens: float
    """Time at which the fingers start to open [s]."""


def finger_bodies(hand: Hand, fingers: Fingers, normal: np.ndarray, held: float, path: HandPath) -> list[Body]:
    """Return both fingers of a hand as rigid bodies, the lower one first, round cloth of the thickness `held` [m]."""
    times = _knots(path)
    points = np.column_stack([np.interp(times, path.times, column) for column in path.points.T])
    coming = 1.0 - _passed(times, 0.0, path.closed)
    open_again = _passed(times, path.opens, path.opens + OPENING)
    gone = _passed(times, path.opens + OPENING, path.opens + OPENING + LEAVING)
    axes = fingers.axes(normal)
    axis, _, up = axes.T
    centres = points - (0.5 * fingers.length + AWAY * (coming + gone))[:, None] * axis
    off = 0.5 * (held + fingers.thickness)
    heights = {"lower": np.full(len(times), -off), "upper": off + fingers.opening * (coming + open_again)}
    turned = np.tile(Rotation.from_matrix(axes).as_quat(scalar_first=True), (len(times), 1))
    return [
        Body(
            name=f"{hand} {finger} finger",
            shape="box",
            size=[0.5 * fingers.length, 0.5 * fingers.width, 0.5 * fingers.thickness],
            friction=fingers.friction,
            hand=hand,
            times=times.tolist(),
            positions=centres + height[:, None] * up,
            orientations=turned,
        )
        for finger, height in heights.items()
    ]


def _knots(path: HandPath) -> np.ndarray:
    ends = (path.opens, path.opens + OPENING, path.opens + OPENING + LEAVING)
    coming = np.linspace(0.0, path.closed, max(2, round(path.closed / FRAME) + 1))
    going = [np.linspace(a, b, round((b - a) / FRAME) + 1) for a, b in pairwise(ends)]
    times = np.unique(np.concatenate([coming, path.times, *going]))
    return times[np.concatenate([[True], np.diff(times) > 1e-6])]


def _passed(times: np.ndarray, begins: float, ends: float) -> np.ndarray:
    """Return which fraction of a motion from rest to rest is complete at each of k times [s], shape (k,)."""
    return np.asarray(curves.minimum_jerk(np.clip((times - begins) / (ends - begins), 0.0, 1.0)))
