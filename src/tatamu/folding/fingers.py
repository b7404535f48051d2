"""The two equal fingers of a hand: one is under the hem of the cloth, the other is over it.

The axes of a hand are:

    a   axis of the fingers, from the hand to their tips; it points towards the side of the cloth that stays, and
        down by the angle `tilt` from the horizontal
    u   opening axis, from the lower finger to the upper finger; it is perpendicular to the axes a and w
    w   axis along the hem

The held row of vertices lies at the tips, between both fingers. The lowest point of the lower finger, whose thickness
is f, is f cos(tilt) below it. A closing hand therefore lifts the hem by this height, and releases it as high above the
layers below.
"""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from pydantic import Field, model_validator

from tatamu.base.records import Record
from tatamu.simulation.material import Number

PAD = 0.01
"""Length of the cloth between the finger pads, from the hem inwards [m]."""
PRESETS = {
    # the box of the rubber tip in franka_description/robots/common/franka_hand.xacro of frankaemika/franka_ros
    "franka-hand": {"thickness": 0.0152, "width": 0.0175, "length": 0.0185},
    # the pad with the plate behind it in hironx_moveit_config/models/meshes/LHAND_JOINT1_Link_mesh.dae of
    # start-jsk/rtmros_hironx: y from 0.0085 to 0.0180, z from -0.014 to 0.014
    "hironx": {"thickness": 0.0095, "width": 0.028, "length": 0.030},
    # the inner finger with its tip and pad in grippers/robotiq_gripper_85.xml of robosuite 1.5.2; the pad alone is 8 mm
    "robotiq-2f-85": {"thickness": 0.0136, "width": 0.022, "length": 0.030},
    # the finger's mesh in grippers/xarm7_gripper.xml of robosuite 1.5.2
    "xarm-gripper": {"thickness": 0.014, "width": 0.032, "length": 0.040},
    # the jaws' meshes in so_arm_description/urdf/so101.urdf of example-robot-data 6.0.0
    "so101": {"thickness": 0.0101, "width": 0.013, "length": 0.015},
    # the finger's mesh in assets/vx300s_left.xml of gym-aloha 0.1.5
    "viperx-300": {"thickness": 0.0081, "width": 0.021, "length": 0.020},
    # the finger's collision mesh in v2/openarm_bimanual.xml of openarm-mujoco 2.3.0
    "openarm": {"thickness": 0.021, "width": 0.055, "length": 0.0235},
}
"""Fingers of known hands [m]. The comments name the shapes, in published models, that were measured."""


class FingerSize(Record):
    """Size of both fingers at their tips, and how far they open."""

    thickness: Annotated[Number, Field(ge=0.0, le=0.05)] = 0.008
    """Thickness along the opening axis [m]."""
    width: Annotated[Number, Field(gt=0.0, le=0.15)] = 0.03
    """Width along the hem [m]."""
    length: Annotated[Number, Field(ge=0.005, le=0.2)] = 0.02
    """Length of the straight part of each finger, along its axis [m]."""
    opening: Annotated[Number, Field(ge=0.002, le=0.2)] = 0.012
    """Distance between the fingertips before they close and after they have opened [m]."""

    @model_validator(mode="before")
    @classmethod
    def _of_preset(cls, given: Any) -> Any:
        """Replace the name of a known hand by its sizes. Sizes that are also given have priority."""
        if not isinstance(given, dict) or "preset" not in given:
            return given
        name, own = given["preset"], {field: value for field, value in given.items() if field != "preset"}
        if not isinstance(name, str) or name not in PRESETS:
            raise ValueError(f"preset must be one of {', '.join(PRESETS)}, given {name!r}")
        return {**PRESETS[name], **own}


class Fingers(FingerSize):
    """Fingers of a simulated hand. By default there are none, and the hand is simulated as a point."""

    thickness: Annotated[Number, Field(ge=0.0, le=0.05)] = 0.0
    """Thickness of each finger [m]; 0 for a hand without fingers."""
    opening: Annotated[Number, Field(ge=0.002, le=0.2)] = 0.02
    tilt: Annotated[Number, Field(ge=0.0, le=1.4)] = 0.5
    """Angle of the fingers below the horizontal [rad]."""
    friction: Annotated[Number, Field(ge=0.0, le=10.0)] = 0.5
    """Coulomb coefficient of friction between cloth and fingers [-]."""
    compliance: Annotated[Number, Field(ge=0.0, le=0.1)] = 0.0067
    """Maximum depth below the table to which a hand may be commanded without failing [m]. The default is that of an arm
    with 3000 N/m, which then presses with 20 N (`setDefaultBehavior` in examples/examples_common.cpp of
    frankaemika/libfranka)."""

    @property
    def stated(self) -> bool:
        """Whether the hand has fingers."""
        return self.thickness > 0.0

    @property
    def lift(self) -> float:
        """Height of the hem, which lies on the lower finger, above the lowest point of this finger [m]."""
        return float(self.thickness * np.cos(self.tilt))

    @property
    def setback(self) -> float:
        """Length of the grasped cloth round the tip of the lower finger [m], by which the hand's motion is shorter."""
        return float(self.thickness * (1.0 - np.sin(self.tilt)))

    def axes(self, normal: np.ndarray) -> np.ndarray:
        """Return a, w and u as the columns of a rotation, shape (3, 3), from `FoldLine.normal`, shape (2,)."""
        cos, sin = np.cos(self.tilt), np.sin(self.tilt)
        axis = np.array([*(cos * normal), -sin])
        opening = np.array([*(sin * normal), cos])
        return np.column_stack([axis, np.cross(opening, axis), opening])
