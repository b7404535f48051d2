"""The file plan.json, which a plan writes and a rehearsal reads, and the folder of a plan that has been read."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from tatamu.base.errors import InputError
from tatamu.base.files import read_text
from tatamu.base.records import OpenRecord
from tatamu.robots.pose import pose, turn
from tatamu.simulation.scene import Points
from tatamu.study.folder import ResultFolder

FOLD = "fold"
"""Folder of the learned fold inside the plan's folder."""

MAX_DURATION = 3600.0
"""Longest duration of a valid plan [s]."""
MAX_ANGLE = 100.0
"""Maximum angle of a joint in a valid plan [rad]."""
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

    @property
    def arms(self) -> tuple[str, ...]:
        """Names of the arms that fold, the left arm first."""
        named = set(self.jaws) if self.hover else {event.arm for event in self.events}
        return tuple(arm for arm in ("larm", "rarm") if arm in named)


@dataclass(frozen=True)
class Planned:
    """A plan that has been read from its folder."""

    folder: Path
    plan: PlanFile
    times: np.ndarray
    """Times of the samples [s], shape (n,)."""
    angles: np.ndarray
    """Angles of the j joints in `plan.joints` at each sample [rad], shape (n, j)."""

    @classmethod
    def load(cls, folder: Path) -> Planned:
        """Read the files plan.json and joint_trajectory.csv of a plan's folder.

        Raises:
            InputError: If a file is missing or wrong.
        """
        if not folder.is_dir():
            raise InputError(f"{folder}: must be the folder of a plan, but is not a folder")
        path = folder / "plan.json"
        if not path.exists():
            raise InputError(f"{folder}: must be the folder of a plan, but has no plan.json")
        plan = PlanFile.load(path)
        _check_events(path, plan)
        table = folder / "joint_trajectory.csv"
        times, angles = _table(table, plan.joints)
        if times[-1] < max((event.time for event in plan.events), default=0.0):
            raise InputError(f"{table}: must last until the last event in plan.json, but ends at {times[-1]:.2f} s")
        planned = cls(folder, plan, times, angles)
        if any(planned.event(arm, "open") <= planned.event(arm, "close") for arm in planned.arms):
            raise InputError(f"{path}: events: the jaws of each arm must close before they open")
        return planned

    @property
    def arms(self) -> tuple[str, ...]:
        """Names of the arms that fold, the left arm first."""
        return self.plan.arms

    @property
    def fold(self) -> ResultFolder:
        """Folder of the learned fold inside the plan's folder. Some of its files may be missing."""
        return ResultFolder(self.folder / FOLD)

    def angles_at(self, times: np.ndarray) -> np.ndarray:
        """Return the angles of the plan's j joints at n times [rad], shape (n, j)."""
        return np.array([np.interp(times, self.times, column) for column in self.angles.T]).T

    def fingers(self, times: np.ndarray) -> dict[str, np.ndarray]:
        """Return the positions of the finger joints at n times [s], by the names of the joints.

        The fingers are open at first, then closed, then open again.
        """
        lasting = {stage.name: stage.duration for stage in self.plan.stages}
        found: dict[str, np.ndarray] = {}
        for arm, jaw in self.plan.jaws.items():
            if arm in self.arms:
                close, opening = (self.event(arm, event) for event in ("close", "open"))
                knots = [close, close + lasting.get("close", 0.0), opening, opening + lasting.get("open", 0.0)]
                closed = np.interp(times, np.maximum.accumulate(knots), [0.0, 1.0, 1.0, 0.0])
                found |= {name: start + closed * (end - start) for name, (start, end) in jaw.fingers.items()}
        return found

    def event(self, arm: str, event: str) -> float:
        """Return the time at which an arm's fingers close or open [s].

        The fingers stay open if the plan only hovers above the table. In this case, return the time at which they would
        close or open.
        """
        if self.plan.hover:
            return self.plan.segments[("close", "open").index(event)].end
        return next(found.time for found in self.plan.events if (found.arm, found.event) == (arm, event))


def _check_events(path: Path, plan: PlanFile) -> None:
    """Raise an error if a hand of the plan does not close exactly once and open exactly once."""
    if plan.hover:
        if [segment.name for segment in plan.segments] != ["approach", "fold", "leave"]:
            raise InputError(f"{path}: segments: must be approach, fold and leave in a plan that hovers")
    elif not plan.events or sorted((event.arm, event.event) for event in plan.events) != [
        (arm, event) for arm in plan.arms for event in ("close", "open")
    ]:
        raise InputError(f"{path}: events: must contain one close and one open for each arm that folds")


def _table(path: Path, joints: list[str]) -> tuple[np.ndarray, np.ndarray]:
    try:
        rows = list(csv.reader(io.StringIO(read_text(path))))
    except csv.Error as error:
        raise InputError(f"{path}: must be a table of numbers ({error})") from None
    if not rows or rows[0] != ["time", *joints]:
        raise InputError(f"{path}: header: must be time, then the joints of plan.json in the same order")
    try:
        table = np.array(rows[1:], dtype=float)
    except ValueError:
        raise InputError(f"{path}: must contain a number in every field") from None
    if table.ndim != 2 or len(table) < 2 or not np.isfinite(table).all():
        raise InputError(f"{path}: must contain at least two rows of finite numbers")
    times, angles = table[:, 0], table[:, 1:]
    if not (times[0] >= 0 and times[-1] <= MAX_DURATION and (times[1:] > times[:-1]).all()):
        raise InputError(f"{path}: time: must increase from row to row, and lie between 0 and {MAX_DURATION:g} s")
    if not np.abs(angles).max(initial=0.0) <= MAX_ANGLE:
        row, column = np.unravel_index(int(np.abs(angles).argmax()), angles.shape)
        raise InputError(
            f"{path}: {joints[column]}: must be within ±{MAX_ANGLE:g} rad, given {angles[row, column]:.4g} at "
            f"{times[row]:g} s"
        )
    return times, angles
