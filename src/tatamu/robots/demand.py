"""The directions of motion that a fold needs of an arm; they are defined only here.

A hand keeps its place in three directions, and its orientation. An arm of six joints or more keeps all of it. An arm
of five keeps the jaw's opening axis, which lies across the hem and has the jaw's tilt: two directions. The fifth joint
more or less is a turn about that axis, in the plane of the fingers' pads, with which the cloth between them turns. With
fewer joints the jaw could not stay across the hem.
"""

from __future__ import annotations

import numpy as np

FEWEST = 5
"""Joints that an arm needs."""
ALL = 6
"""Joints with which an arm keeps its tool's whole orientation."""
OPENING = 1
"""The axis of T along which the jaw opens: y."""


def turns_freely(joints: int) -> bool:
    """Return whether an arm with this number of joints may turn its tool about the jaw's opening axis."""
    return joints < ALL


def weights(joints: int) -> np.ndarray:
    """Which of the turns about the axes of T count, 1 or 0, shape (3,)."""
    counted = np.ones(3)
    if turns_freely(joints):
        counted[OPENING] = 0.0
    return counted


def too_few(joints: int) -> str:
    """Why an arm of so few joints cannot fold."""
    return (
        f"joints must be at least {FEWEST}, given {joints}: three move the hand and two keep the jaw across the hem at "
        "its tilt; an arm with fewer cannot"
    )
