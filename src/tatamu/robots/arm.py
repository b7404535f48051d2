"""One arm of a robot: its joints and their limits, the jaws of its hand, and the names that its drivers use.

docs/theory/grasp.md has a drawing of the jaws.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from tatamu.base.records import Record
from tatamu.folding.fingers import FingerSize

GAP = 0.001
"""Height at which the lower finger of the open jaw passes over the table [m]. It is less than the cloth's thickness."""
MIN_HELD = 0.005
"""Minimum depth of cloth between the closed fingertips [m]."""
HELD = 0.0005
"""Distance of each closed fingertip from the jaw's middle [m]: half the thickness of a thin cloth."""
Length = Annotated[float, Field(ge=0, le=0.2)]
Angle = Annotated[float, Field(ge=0, le=float(np.pi / 2))]


class Jaw(FingerSize):
    """Two fingers that open and close in parallel, one under and one over the edge of the cloth.

    The tool T is between the ends of the closed fingertips, z is the direction of approach, and the jaws open along y.
    """

    widest: Length = 0.05
    """Maximum opening of the jaw [m]."""
    force: Annotated[float, Field(gt=0, le=500)] = 20.0
    """Force with which the fingers grip the cloth [N]."""
    depth: Length = 0.011
    """Distance from the edge of the cloth to the place where the fingertips meet, at right angles to the edge [m]."""
    tilt: tuple[Angle, Angle] = (0.17, 1.05)
    """Minimum and maximum angle from straight down to the direction of approach [rad]."""
    yaw: Angle = 1.05
    """Maximum rotation about the vertical, towards the other hand [rad]; 0 is at right angles to the edge."""
    fingers: dict[str, tuple[float, float]] = Field(default_factory=dict)
    """Joints that move the fingers, with their positions at the width `opening` and closed [rad, m]."""
    links: list[str] = Field(default_factory=list)
    """Links that are fingers, which may come closer to the table than other links."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.tilt[0] > self.tilt[1]:
            raise ValueError(f"tilt must be [minimum, maximum] with minimum <= maximum, given {list(self.tilt)}")
        if self.opening <= 2 * HELD:
            raise ValueError(f"opening must be more than {2 * HELD:g} m, given {self.opening:g}")
        return self

    def held(self, depth: float, height: float) -> float:
        """Return the depth of cloth between fingertips that meet at `depth` from the edge and at `height` [m].

        The cloth rises to the fingertips at 45 degrees, so it needs more length than cloth that lies flat.
        """
        return depth - (float(np.sqrt(2)) - 1) * height

    def takes_at(self, tilt: float) -> bool:
        """Return whether a closed jaw with this tilt [rad] has enough cloth between its fingertips."""
        return self.held(self.depth, self.height(tilt)) >= MIN_HELD

    def height(self, tilt: float) -> float:
        """Return the height of T above the table [m] at which the lower finger passes over it at the distance GAP."""
        return float(GAP + (self.opening / 2 + self.thickness) * np.sin(tilt))

    def prefixed(self, prefix: str) -> Jaw:
        """Return the same jaw for a model whose names have a prefix."""
        return self.model_copy(
            update={
                "fingers": {prefix + name: positions for name, positions in self.fingers.items()},
                "links": [prefix + name for name in self.links],
            }
        )


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
            raise ValueError("open and closed must be given together or left out together")
        return self

    def values(self, angles: np.ndarray) -> np.ndarray:
        """Return the robot's own values for the angles of the model's k joints [rad], shape (.., k)."""
        moved = angles - (0.0 if self.zero is None else np.array(self.zero))
        turned = moved * (1.0 if self.sign is None else np.array(self.sign))
        return np.asarray(np.degrees(turned) if self.unit == "deg" else turned)


@dataclass(frozen=True)
class Arm:
    """One arm with k joints, from the base to the tool."""

    name: str
    """`larm` or `rarm`."""
    joints: tuple[str, ...]
    link: str
    """The body that the last joint moves. Its frame is the wrist frame W."""
    tool_in_wrist: np.ndarray
    """Pose X_WT of the tool T in the wrist W, shape (4, 4); see `Jaw`."""
    initial: np.ndarray
    """Angles at the start and the end of motions [rad], shape (k,)."""
    planned_speed: np.ndarray
    """Maximum speeds in plans [rad/s], shape (k,)."""
    planned_acceleration: np.ndarray
    """Maximum accelerations in plans [rad/s^2], shape (k,)."""
    jaw: Jaw = field(default_factory=Jaw)
    ros: RosNames = field(default_factory=RosNames)
    lerobot: LeRobotNames = field(default_factory=LeRobotNames)

    @property
    def site(self) -> str:
        """The name of the tool frame T in the model."""
        return f"{self.name}_tool"

    @property
    def controller(self) -> str:
        """The name of the ROS controller of the joints."""
        return self.ros.controller or f"{self.name}_controller"

    @property
    def gripper_controller(self) -> str:
        """The name of the ROS controller of the gripper."""
        return self.ros.gripper or f"{self.name}_gripper"

    @property
    def ros_joints(self) -> tuple[str, ...]:
        """The names of the joints in ROS."""
        return self.joints if self.ros.joints is None else tuple(self.ros.joints)
