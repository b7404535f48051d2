"""The data model of the file plan.json, which a plan writes and a rehearsal reads."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from tatamu.base.records import OpenRecord
from tatamu.robots.pose import pose, turn
from tatamu.simulation.scene import Points

Place = Annotated[float, Field(ge=-100, le=100)]


class FoldPose(OpenRecord):
    """The pose X_BF of the fold in the robot's base [m, rad]."""

    xyz: tuple[Place, Place, Place]
    yaw: float = Field(ge=-100, le=100)

    @property
    def matrix(self) -> np.ndarray:
        """The pose as a matrix, shape (4, 4)."""
        return pose(turn(2, self.yaw), np.array(self.xyz))


class FingerEvent(OpenRecord):
    """The fingers of one arm close or open at a time [s]."""

    time: float = Field(ge=0)
    arm: Literal["larm", "rarm"]
    event: Literal["close", "open"]


class GripperCommand(OpenRecord):
    """A command to a gripper at a time [s]."""

    time: float = Field(ge=0)
    arm: Literal["larm", "rarm"]
    width: float = Field(ge=0)
    """Commanded distance between the fingertips [m]."""
    force: float = Field(gt=0)
    """Maximum force of the fingers [N]."""
    duration: float = Field(ge=0)
    """Time that the plan allows for the motion of the fingers [s]."""


class Segment(OpenRecord):
    """A part of the motion that starts and ends at rest, so that a program can pause after it [s]."""

    name: Literal["approach", "fold", "leave"]
    start: float = Field(ge=0)
    duration: float = Field(ge=0)
    then: Literal["close", "open", ""]
    """What the grippers do after this part: close, open, or nothing (empty)."""

    @property
    def end(self) -> float:
        """End of the part [s]."""
        return self.start + self.duration


class StageTime(OpenRecord):
    """Start and duration of a stage of the motion [s]."""

    name: str
    start: float
    duration: float


class PlanCheck(OpenRecord):
    """One checked value of a plan, and its limit."""

    value: float
    limit: float
    unit: str
    ok: bool
    where: str = ""
    """The joint or the links that have the worst value, and its time, as text."""
    frame: int = 0
    """Index of the simulated frame with the worst value; the first or the last frame before or after the fold."""

    def failed(self, name: str) -> str:
        """Return the message that reports that a plan fails this check."""
        return (
            f"{name.replace('_', ' ')} is {self.value:.4g} {self.unit}, the limit {self.limit:.4g} {self.unit}, "
            f"{self.where}"
        )


class JawFile(OpenRecord):
    """The grasp of the cloth's edge by one hand."""

    tilt: float
    """Angle from straight down to the direction of approach [rad]."""
    yaw: float
    """Rotation of the jaws about the vertical [rad]; 0 if their plane is at right angles to the edge."""
    opening: float = Field(ge=0)
    """Distance between the fingertips before they close and after they open [m]."""
    thickness: float = Field(0.008, gt=0, le=0.05)
    """Thickness of one finger at its tip, in the direction in which the jaw opens [m]."""
    width: float = Field(0.03, gt=0, le=0.15)
    """Width of one finger along the edge of the cloth [m]."""
    length: float = Field(0.02, ge=0.005, le=0.2)
    """Length of the straight part of one finger, along the finger's axis [m]."""
    depth: float
    """Distance from the edge of the cloth to the place where the fingertips meet [m]."""
    height: float
    """Height above the table at which the fingertips meet [m]."""
    fingertips_in_wrist: list[list[float]] = Field(default_factory=list)
    """Pose X_WT of the tool in the wrist, shape (4, 4)."""
    fingers: dict[str, tuple[float, float]] = Field(default_factory=dict)
    """Joints of robot.xml that move the fingers, with their open and closed positions [rad, m]."""


class ToolViaPoints(OpenRecord):
    """Positions of the simulated hands at the via-points of the fold, in the base B."""

    every_frames: int
    frames: list[int]
    """Index of the simulated frame at each via-point."""
    simulated_times: list[float]
    """Times of the simulated hands [s]."""
    times: list[float]
    """Times of the robot [s]."""
    larm: Points | None = None
    """Positions of the left hand [m], shape (v, 3); None if the right arm folds alone."""
    rarm: Points | None = None


class PlanFile(OpenRecord):
    """The contents of the file plan.json. A rehearsal needs only the fields that have no default."""

    version: Literal[1]
    tatamu: str = ""
    """Version of tatamu that wrote the file."""
    robot: str
    base_frame: str
    task_in_base: FoldPose
    notes: list[str] = Field(default_factory=list)
    """Notes for the user on how the robot's files were read."""
    initial_pose: str = ""
    """Name of the pose in which the motion starts."""
    trunk_turning: float = 0.0
    """Fraction by which the trunk turns towards the middle between the hands; 1 if it faces this middle."""
    tool_in_wrist: dict[str, list[list[float]]] = Field(default_factory=dict)
    """Pose of the simulated hand in each arm's wrist, shape (4, 4). The simulated hand grips the edge of the cloth."""
    jaws: dict[str, JawFile] = Field(default_factory=dict)
    """The grasp of the cloth's edge by each arm."""
    wrist_frame: dict[str, str] = Field(default_factory=dict)
    """Name of the link that each arm's last joint moves."""
    joints: list[str]
    duration: float | None = None
    """Duration of the motion [s]."""
    events: list[FingerEvent]
    gripper_commands: list[GripperCommand] = Field(default_factory=list)
    segments: list[Segment] = Field(default_factory=list)
    speed_scale: float = 1.0
    """Speed of the motion, relative to the highest speed that the robot and the fold allow."""
    hover: float = Field(0.0, ge=0)
    """Height by which the motion is raised [m]. Above 0, the jaws stay open and there are no events."""
    stages: list[StageTime] = Field(default_factory=list)
    checks: dict[str, PlanCheck] = Field(default_factory=dict)
    via_points: ToolViaPoints | None = None
