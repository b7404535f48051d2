"""The two fingers of a hand as bodies of a MuJoCo model. They slide along the axis on which the jaw opens."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from tatamu.folding.fingers import FingerSize
from tatamu.robots.extras import needed
from tatamu.robots.jaw import HELD, Jaw
from tatamu.robots.pose import to_quaternion

MASS = 0.01
"""Mass of one finger [kg]."""


class FingerShape(NamedTuple):
    """The shape of one finger, which consists of two boxes: the tip, and the part above the tip [m]."""

    hand: str
    """Name of the hand in `tatamu.folding.fingers.PRESETS`, which gives the size of the tip."""
    root: tuple[float, float]
    """Thickness and width of the finger above the tip [m]."""
    length: float
    """Length of the whole finger, including its tip [m]."""
    depth: float = Jaw().depth
    """Distance from the edge of the cloth to the place where the tips meet [m].

    It is larger for thick fingers, because the cloth rises to the tips.
    """


def jaw_of(arm: str, shape: FingerShape, widest: float) -> Jaw:
    """Return the jaw of an arm's hand, with the two fingers that `add_fingers` adds to the robot's model."""
    names = finger_names(arm)
    return Jaw.of_hand(
        shape.hand,
        widest=widest,
        depth=shape.depth,
        fingers={name: (Jaw().opening / 2, HELD) for name in names},
        links=list(names),
    )


def finger_names(arm: str) -> tuple[str, str]:
    """Return the names of the bodies of an arm's two fingers. The joints of the fingers have the same names."""
    return f"{arm}_finger1", f"{arm}_finger2"


def add_fingers(wrist: Any, arm: str, X_WT: np.ndarray, shape: FingerShape, widest: float) -> None:
    """Add two fingers to a wrist of the robot's model.

    The tool frame T is between the ends of the closed fingertips, and the jaw opens along its y axis.
    """
    mujoco = needed("mujoco")
    tip = FingerSize.of_hand(shape.hand)
    parts = (("tip", 0.0, tip.length, tip.thickness, tip.width), ("root", tip.length, shape.length, *shape.root))
    for name, side in zip(finger_names(arm), (-1.0, 1.0), strict=True):
        body = wrist.add_body(name=name, pos=X_WT[:3, 3], quat=to_quaternion(X_WT[:3, :3]))
        body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[0, side, 0], range=[0.0, widest / 2])
        for part, start, end, thick, width in parts:
            if end > start:
                body.add_geom(
                    name=f"{name}_{part}",
                    type=mujoco.mjtGeom.mjGEOM_BOX,
                    size=[width / 2, thick / 2, (end - start) / 2],
                    pos=[0.0, side * thick / 2, -(start + end) / 2],
                    mass=MASS * (end - start) / shape.length,
                    rgba=[0.3, 0.3, 0.35, 1],
                )
