"""The directions of motion that a fold needs of an arm; they are defined only here.

A fold prescribes the position of a hand in three directions, and its orientation in three more. An arm with six joints
or more can keep all six. An arm with five joints keeps only two directions of the orientation: those of the jaw's
opening axis. This axis lies across the hem and has the jaw's tilt. The free turn is about this axis, in the plane of
the fingers' pads; the cloth between the pads turns with them. If an arm had fewer joints, its jaw could not stay across
the hem.
"""

from __future__ import annotations

import numpy as np

FEWEST = 5
"""Least number of joints of an arm."""
ALL = 6
"""Number of joints from which on an arm keeps its tool's whole orientation."""
OPENING = 1
"""The axis of T along which the jaw opens: y."""


def turns_freely(joints: int) -> bool:
    """Return whether an arm with this number of joints may turn its tool about the jaw's opening axis."""
    return joints < ALL


def weights(joints: int) -> np.ndarray:
    """Return the weights, 1 or 0, of rotations about the axes of T, shape (3,)."""
    counted = np.ones(3)
    if turns_freely(joints):
        counted[OPENING] = 0.0
    return counted


def too_few(joints: int) -> str:
    """Return why an arm with so few joints cannot fold."""
    return (
        f"joints must be at least {FEWEST}, given {joints}: three move the hand and two keep the jaw across the hem at "
        "its tilt; an arm with fewer cannot"
    )
