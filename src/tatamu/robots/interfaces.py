"""The names that an arm's drivers use for its joints and its gripper, in ROS and in LeRobot."""

from __future__ import annotations

from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from tatamu.base.records import Record

Name = Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*$")]
"""A ROS name without the leading slash. The name may contain namespaces."""
Numbers = Annotated[list[Annotated[float, Field(ge=-1000, le=1000)]], Field(min_length=1)]


class RosNames(Record):
    """Names of an arm in ROS. If a name is None, the name is made from the name of the arm."""

    controller: Name | None = None
    """Controller of the joints; None if its name is `larm_controller` or `rarm_controller`."""
    gripper: Name | None = None
    """Controller of the gripper; None if its name is `larm_gripper` or `rarm_gripper`."""
    joints: list[str] | None = None
    """Names of the joints in the messages, from the base outwards; None if they are the same as in the plan."""


class LeRobotNames(Record):
    """Keys and units of an arm in LeRobot. The value of a joint is sign * (angle - zero), in `unit`."""

    joints: list[str] | None = None
    """Keys of the joints, from the base outwards; None if the keys are `left_JOINT.pos` or `right_JOINT.pos`."""
    unit: Literal["rad", "deg"] = "rad"
    zero: Numbers | None = None
    """Angles of the model at which the robot's own values are 0 [rad]; None if all are 0."""
    sign: list[Literal[1, -1]] | None = None
    """Sign of each joint: -1 if the robot counts in the opposite direction of the model; None if all signs are 1."""
    gripper: str | None = None
    """Key of the gripper; None if the key is `left_gripper.pos` or `right_gripper.pos`."""
    open: float | None = None
    """Value of the gripper when the jaw has the width `Jaw.opening`; None if the value is the width itself [m]."""
    closed: float | None = None
    """Value of the gripper when the jaw is closed; None if the value is the width itself [m]."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if (self.open is None) != (self.closed is None):
            raise ValueError("open and closed must be given together")
        return self

    def values(self, angles: np.ndarray) -> np.ndarray:
        """Return the robot's own values for the angles of the model's k joints [rad], shape (.., k)."""
        moved = angles - (0.0 if self.zero is None else np.array(self.zero))
        turned = moved * (1.0 if self.sign is None else np.array(self.sign))
        return np.asarray(np.degrees(turned) if self.unit == "deg" else turned)
