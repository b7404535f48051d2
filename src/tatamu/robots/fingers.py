"""The two fingers of a hand as bodies of a MuJoCo model, which slide along the jaw's opening axis."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from tatamu.robots.extras import needed
from tatamu.robots.jaw import HELD, Jaw
from tatamu.robots.pose import to_quaternion

MASS = 0.01
"""Mass of one finger [kg]."""


class FingerShape(NamedTuple):
    """One finger as boxes, from its tip upwards [m]."""

    thickness: float
    """At the tip, along the opening."""
    width: float
    """Width along the hem [m]."""
    tip: float
    """Length of the tip."""
    root: float
    """Thickness above the tip."""
    length: float
    """Length of the finger, with its tip."""
    depth: float = Jaw().depth
    """Distance beyond the hem's edge at which the tips meet; more for thick fingers, because cloth rises to them."""


def jaw_of(arm: str, shape: FingerShape, widest: float) -> Jaw:
    """The jaw of an arm's hand whose fingers `add_fingers` makes."""
    opening = Jaw().opening
    names = finger_names(arm)
    return Jaw(
        thickness=shape.thickness,
        widest=widest,
        depth=shape.depth,
        fingers={name: (opening / 2, HELD) for name in names},
        links=list(names),
    )


def finger_names(arm: str) -> tuple[str, str]:
    """Names of the bodies of an arm's fingers, and of their joints."""
    return f"{arm}_finger1", f"{arm}_finger2"


def add_fingers(wrist: Any, arm: str, X_WT: np.ndarray, shape: FingerShape, widest: float) -> None:
    """Add both fingers to a wrist; T is between the ends of the closed fingertips, y the opening."""
    mujoco = needed("mujoco")
    for name, side in zip(finger_names(arm), (-1.0, 1.0), strict=True):
        body = wrist.add_body(name=name, pos=X_WT[:3, 3], quat=to_quaternion(X_WT[:3, :3]))
        body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[0, side, 0], range=[0.0, widest / 2])
        parts = ((0.0, shape.tip, shape.thickness), (shape.tip, shape.length, shape.root))
        for number, (start, end, thick) in enumerate(parts):
            if end > start:
                body.add_geom(
                    name=f"{name}_{'tip' if number == 0 else 'root'}",
                    type=mujoco.mjtGeom.mjGEOM_BOX,
                    size=[shape.width / 2, thick / 2, (end - start) / 2],
                    pos=[0.0, side * thick / 2, -(start + end) / 2],
                    mass=MASS * (end - start) / shape.length,
                    rgba=[0.3, 0.3, 0.35, 1],
                )
