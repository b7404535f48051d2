"""Fingers: one under the cloth and one over it. The lower finger limits how low a hand can carry the cloth.

A hand that closes lifts the cloth off the table by the thickness of its lower finger. It carries the cloth no lower
than that over the table or the layers below, and opens at that height. The cloth then falls by the finger's thickness,
and the finger is drawn out from under it.
"""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field, model_validator

from tatamu.material import Number
from tatamu.records import Record

PRESETS = {
    # the box of the rubber tip in franka_description/robots/common/franka_hand.xacro of frankaemika/franka_ros
    "franka-hand": {"thickness": 0.0152, "width": 0.0175},
    # the pad with the plate behind it in hironx_moveit_config/models/meshes/LHAND_JOINT1_Link_mesh.dae of
    # start-jsk/rtmros_hironx: y from 0.0085 to 0.0180, z from -0.014 to 0.014
    "hironx": {"thickness": 0.0095, "width": 0.028},
    # twice the half sizes of the pad's boxes in robotiq_2f85/2f85.xml of google-deepmind/mujoco_menagerie
    "robotiq-2f-85": {"thickness": 0.008, "width": 0.022},
}
"""Fingers of known hands [m], each from the collision shapes of a published model."""


class Fingers(Record):
    """Size of the fingers of a hand; by default, cloth is carried as if they had no thickness."""

    thickness: Annotated[Number, Field(ge=0.0, le=0.05)] = 0.0
    """Thickness of the lower finger [m]."""
    width: Annotated[Number, Field(gt=0.0, le=0.15)] = 0.03
    """Width of the finger pad along the edge [m]."""

    @model_validator(mode="before")
    @classmethod
    def _of_preset(cls, given: Any) -> Any:
        """Replace the name of a hand by its sizes; sizes given as well as the name override its own."""
        if not isinstance(given, dict) or "preset" not in given:
            return given
        name, own = given["preset"], {field: value for field, value in given.items() if field != "preset"}
        if not isinstance(name, str) or name not in PRESETS:
            raise ValueError(f"preset must be one of {', '.join(PRESETS)}, given {name!r}")
        return {**PRESETS[name], **own}
