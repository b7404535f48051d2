"""The directions of motion that a fold requires from an arm. They are defined only in this module.

A fold prescribes the position of a hand in three directions, and the orientation of the hand in three more. An arm with
six or more joints can keep all six directions.

An arm with five joints can keep only two directions of the orientation. With them, the arm controls the
direction of the axis along which the jaw opens. This axis stays at right angles to the edge of the cloth, and keeps the
jaw's tilt. The jaw may turn freely about this axis, in the plane of the finger pads. The cloth between the pads turns
with the pads. If an arm had fewer than five joints, its jaw could not stay across the edge.
"""

from __future__ import annotations

import numpy as np

FEWEST = 5
"""Smallest number of joints with which an arm can be used."""
ALL = 6
"""Smallest number of joints with which an arm can keep its tool's whole orientation."""
OPENING = 1
"""Index of the axis of the tool T along which the jaw opens: y."""


def turns_freely(joints: int) -> bool:
    """Return whether an arm has too few joints to control the rotation of its tool about the jaw's opening axis."""
    return joints < ALL


def weights(joints: int) -> np.ndarray:
    """Return the weights of rotations about the axes of the tool T, shape (3,).

    The weight is 1 if an arm with this number of joints controls the rotation about an axis, and 0 if not.
    """
    counted = np.ones(3)
    if turns_freely(joints):
        counted[OPENING] = 0.0
    return counted


def too_few(joints: int) -> str:
    """Return a message that explains why an arm with this number of joints cannot fold."""
    return (
        f"joints must be at least {FEWEST}, given {joints}: three move the hand and two keep the jaw across the hem at "
        "its tilt; an arm with fewer cannot"
    )
