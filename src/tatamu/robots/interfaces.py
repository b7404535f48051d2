"""The names that the drivers of an arm use for its joints and gripper, in ROS and in LeRobot."""

from __future__ import annotations

from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from tatamu.records import Record

Name = Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*$")]
"""A name of ROS without its leading slash, which may have namespaces."""
Numbers = Annotated[list[Annotated[float, Field(ge=-1000, le=1000)]], Field(min_length=1)]


class RosNames(Record):
    """Names of an arm in ROS; None for those that follow from the arm's name."""

    controller: Name | None = None
    """Controller of the joints; None for `larm_controller` or `rarm_controller`."""
    gripper: Name | None = None
    """Controller of the gripper; None for `larm_gripper` or `rarm_gripper`."""
    joints: list[str] | None = None
    """Names of the joints in the messages, from the base outwards; None for those of the plan."""


class LeRobotNames(Record):
    """Keys and units of an arm in LeRobot: value = sign * (angle - zero), in `unit`."""

    joints: list[str] | None = None
    """Keys of the joints, from the base outwards; None for `left_JOINT.pos` or `right_JOINT.pos`."""
    unit: Literal["rad", "deg"] = "rad"
    zero: Numbers | None = None
    """Angles of the model at which the robot counts 0 [rad]; None for 0."""
    sign: list[Literal[1, -1]] | None = None
    """-1 for joints that the robot counts the other way; None for 1."""
    gripper: str | None = None
    """Key of the gripper; None for `left_gripper.pos` or `right_gripper.pos`."""
    open: float | None = None
    """Value of the gripper when the jaw is as far open as `opening` says; None for the width itself [m]."""
    closed: float | None = None
    """Value of the gripper when the jaw is closed; None for the width itself [m]."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if (self.open is None) != (self.closed is None):
            raise ValueError("open and closed must be given together")
        return self

    def values(self, angles: np.ndarray) -> np.ndarray:
        """The robot's values of angles [rad] (.., k)."""
        moved = angles - (0.0 if self.zero is None else np.array(self.zero))
        turned = moved * (1.0 if self.sign is None else np.array(self.sign))
        return np.asarray(np.degrees(turned) if self.unit == "deg" else turned)
