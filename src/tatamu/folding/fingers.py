"""The two equal fingers of a hand, one under the hem and one over it. Their shape is defined here.

    a   axis of the fingers, from the hand to their tips: towards the side that stays, `tilt` below the horizontal
    u   opening axis, from the lower finger to the upper one: in the vertical plane across the hem, as a is
    w   along the hem

The held row of vertices lies at the tips, between both fingers. The lower finger then reaches f cos(tilt) below it, f
its thickness: by so much a closing hand lifts the hem, and so much above the layers below it lets go.
"""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from pydantic import Field, model_validator

from tatamu.material import Number
from tatamu.records import Record

PRESETS = {
    # the box of the rubber tip in franka_description/robots/common/franka_hand.xacro of frankaemika/franka_ros
    "franka-hand": {"thickness": 0.0152, "width": 0.0175, "length": 0.0185},
    # the pad with the plate behind it in hironx_moveit_config/models/meshes/LHAND_JOINT1_Link_mesh.dae of
    # start-jsk/rtmros_hironx: y from 0.0085 to 0.0180, z from -0.014 to 0.014
    "hironx": {"thickness": 0.0095, "width": 0.028},
    # the pad's two boxes, one behind the other, in robotiq_2f85/2f85.xml of google-deepmind/mujoco_menagerie: half
    # sizes 0.011, 0.004 and 0.009375
    "robotiq-2f-85": {"thickness": 0.008, "width": 0.022, "length": 0.0375},
}
"""Fingers of known hands [m], each from the collision shapes of a published model."""


class Fingers(Record):
    """Shape of the fingers of a hand; by default hands are points, without fingers."""

    thickness: Annotated[Number, Field(ge=0.0, le=0.05)] = 0.0
    """Thickness of each finger [m]; 0 for a hand without fingers."""
    width: Annotated[Number, Field(gt=0.0, le=0.15)] = 0.03
    """Width of a finger along the edge [m]."""
    length: Annotated[Number, Field(ge=0.005, le=0.2)] = 0.02
    """Length of the straight part of a finger [m]."""
    opening: Annotated[Number, Field(ge=0.002, le=0.2)] = 0.02
    """Distance of the upper finger from the lower one before it closes and after it has opened [m]."""
    tilt: Annotated[Number, Field(ge=0.0, le=1.4)] = 0.5
    """Angle of the fingers below the horizontal [rad]."""
    friction: Annotated[Number, Field(ge=0.0, le=10.0)] = 0.5
    """Coulomb coefficient of cloth on the fingers [-]."""
    compliance: Annotated[Number, Field(ge=0.0, le=0.1)] = 0.0067
    """Largest depth below the table's top to which a hand may be commanded without failing [m].

    The default is that of an arm of 3000 N/m that stops at 20 N (`setDefaultBehavior` in examples/examples_common.cpp
    of frankaemika/libfranka)."""

    @model_validator(mode="before")
    @classmethod
    def _of_preset(cls, given: Any) -> Any:
        """Replace the name of a hand by its sizes; sizes that are given too replace those of the name."""
        if not isinstance(given, dict) or "preset" not in given:
            return given
        name, own = given["preset"], {field: value for field, value in given.items() if field != "preset"}
        if not isinstance(name, str) or name not in PRESETS:
            raise ValueError(f"preset must be one of {', '.join(PRESETS)}, given {name!r}")
        return {**PRESETS[name], **own}

    @property
    def stated(self) -> bool:
        """Whether the hand has fingers."""
        return self.thickness > 0.0

    @property
    def lift(self) -> float:
        """Depth of the lower finger below the hem that lies on it [m]."""
        return float(self.thickness * np.cos(self.tilt))

    @property
    def setback(self) -> float:
        """Length of the cloth around the tip of the lower finger [m]; the hem is released this much earlier."""
        return float(self.thickness * (1.0 - np.sin(self.tilt)))

    def axes(self, normal: np.ndarray) -> np.ndarray:
        """Return a, w and u as columns, shape (3, 3): a right-handed rotation.

        Args:
            normal: Horizontal unit vector from the moving side to the side that stays, shape (2,).
        """
        cos, sin = np.cos(self.tilt), np.sin(self.tilt)
        axis = np.array([*(cos * normal), -sin])
        opening = np.array([*(sin * normal), cos])
        return np.column_stack([axis, np.cross(opening, axis), opening])
