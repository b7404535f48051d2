"""The models of plan.json: written with a plan, read by a rehearsal. See docs/theory/robot-planning.md."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from tatamu.records import OpenRecord
from tatamu.robots.pose import pose, turn
from tatamu.scene import Points

Place = Annotated[float, Field(ge=-100, le=100)]


class FoldPose(OpenRecord):
    """X_BF: the pose of the fold's frame in the robot's base frame."""

    xyz: tuple[Place, Place, Place]
    """[m]."""
    yaw: float = Field(ge=-100, le=100)
    """[rad]."""

    @property
    def matrix(self) -> np.ndarray:
        """Shape (4, 4)."""
        return pose(turn(2, self.yaw), np.array(self.xyz))


class FingerEvent(OpenRecord):
    """Fingers close or open."""

    time: float = Field(ge=0)
    """[s]."""
    arm: Literal["larm", "rarm"]
    event: Literal["close", "open"]


class GripperCommand(OpenRecord):
    """A command to a gripper."""

    time: float = Field(ge=0)
    """[s]."""
    arm: Literal["larm", "rarm"]
    width: float = Field(ge=0)
    """Wanted distance between the fingertips [m]."""
    force: float = Field(gt=0)
    """Largest force [N]."""
    duration: float = Field(ge=0)
    """Time that the plan allows for it [s]."""


class Segment(OpenRecord):
    """A part of the motion from rest to rest. A program that plays it may pause after it for any time."""

    name: Literal["approach", "fold", "leave"]
    start: float = Field(ge=0)
    """[s]."""
    duration: float = Field(ge=0)
    """[s]."""
    then: Literal["close", "open", ""]
    """The gripper event after this segment; empty if no event follows."""

    @property
    def end(self) -> float:
        """[s]."""
        return self.start + self.duration


class StageTime(OpenRecord):
    """Start and duration of a stage of the motion [s]."""

    name: str
    start: float
    duration: float


class PlanCheck(OpenRecord):
    """One figure of a plan, and its limit."""

    value: float
    limit: float
    unit: str
    ok: bool
    where: str = ""
    """The joint or the links, and the time, as text."""
    frame: int = 0
    """The simulation's frame of the value; the fold's first or last frame for values before or after it."""

    def failed(self, name: str) -> str:
        """The line that refuses a plan."""
        return (
            f"{name.replace('_', ' ')} is {self.value:.4g} {self.unit}, the limit {self.limit:.4g} {self.unit}, "
            f"{self.where}"
        )


class JawFile(OpenRecord):
    """The grasp of the hem by one hand."""

    tilt: float
    """Angle of the approach from straight down [rad]."""
    yaw: float
    """Turn of the jaw's plane from the plane across the hem [rad]."""
    opening: float = Field(ge=0)
    """Distance between the fingertips before they close and after they open [m]."""
    thickness: float = Field(0.008, gt=0, le=0.05)
    """Thickness of one finger at its tip, along the opening [m]."""
    width: float = Field(0.03, gt=0, le=0.15)
    """Width of one finger along the hem [m]."""
    length: float = Field(0.02, ge=0.005, le=0.2)
    """Length of one finger along its axis, as far as it is straight [m]."""
    depth: float
    """Distance beyond the hem's edge at which the fingertips meet [m]."""
    height: float
    """Height over the table at which they meet [m]."""
    fingertips_in_wrist: list[list[float]] = Field(default_factory=list)
    """X_WT: between the ends of the closed fingertips, shape (4, 4)."""
    fingers: dict[str, tuple[float, float]] = Field(default_factory=dict)
    """Joints of robot.xml that move the fingers: open and closed positions [rad, m]."""


class ToolViaPoints(OpenRecord):
    """The simulated hands in B at the via-points of the fold."""

    every_frames: int
    frames: list[int]
    """The simulation's frames."""
    simulated_times: list[float]
    """Times at which the hands of the simulation were there [s]."""
    times: list[float]
    """Times at which the robot is there [s]."""
    larm: Points | None = None
    """[m], shape (v, 3); None if the other arm folds alone."""
    rarm: Points | None = None


class PlanFile(OpenRecord):
    """The file plan.json; a rehearsal needs only the fields without a default."""

    version: Literal[1]
    tatamu: str = ""
    """The version that wrote it."""
    robot: str
    base_frame: str
    task_in_base: FoldPose
    notes: list[str] = Field(default_factory=list)
    """Notes for the user on how the robot's files were read."""
    initial_pose: str = ""
    """Name of the pose that the motion starts from."""
    trunk_turning: float = 0.0
    """Fraction by which the trunk turns with the hands [-]."""
    tool_in_wrist: dict[str, list[list[float]]] = Field(default_factory=dict)
    """The point of each arm's hand that follows the simulated hand, which holds the hem's edge, shape (4, 4)."""
    jaws: dict[str, JawFile] = Field(default_factory=dict)
    """The grasp of the hem by each arm."""
    wrist_frame: dict[str, str] = Field(default_factory=dict)
    """Link of each arm's last joint."""
    joints: list[str]
    duration: float | None = None
    """[s]."""
    events: list[FingerEvent]
    gripper_commands: list[GripperCommand] = Field(default_factory=list)
    segments: list[Segment] = Field(default_factory=list)
    speed_scale: float = 1.0
    """Ratio of the speed of the motion to the fastest that the robot and the fold allow."""
    hover: float = Field(0.0, ge=0)
    """Height of the whole motion above the one that folds [m]; above 0 the jaws stay open and there are no events."""
    stages: list[StageTime] = Field(default_factory=list)
    checks: dict[str, PlanCheck] = Field(default_factory=dict)
    via_points: ToolViaPoints | None = None
