"""The description of any dual-arm robot: a short TOML file that names its model, arms, tool frames and limits.

docs/reference/robot-description.md has an example.
"""

from __future__ import annotations

from operator import attrgetter
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field, field_validator, model_validator

from tatamu.base.errors import InputError
from tatamu.base.files import beside, read_toml, validated
from tatamu.base.records import Record
from tatamu.evaluation.disturbances import Disturbances, disturbances_in, read_disturbances
from tatamu.robots.arm import Jaw, LeRobotNames, Numbers, RosNames
from tatamu.robots.modelfile import ModelFile, read_model
from tatamu.robots.pose import from_rpy, pose

Length = Annotated[float, Field(ge=-10, le=10)]
Vector = tuple[Length, Length, Length]


class Frame(Record):
    """A translation [m], and a rotation about fixed x, then y, then z [rad], as in URDF."""

    xyz: Vector = (0.0, 0.0, 0.0)
    rpy: Vector = (0.0, 0.0, 0.0)

    @property
    def matrix(self) -> np.ndarray:
        """The pose as a matrix, shape (4, 4)."""
        return pose(from_rpy(*self.rpy), np.array(self.xyz))


class PoseDescription(Record):
    """A further pose in which motions can start."""

    name: str
    larm: Numbers
    """Joint angles of the left arm [rad]."""
    rarm: Numbers


class TrunkDescription(Record):
    """A joint that carries both arms and turns them about z of the base."""

    joint: str
    speed: Annotated[float, Field(ge=1e-3, le=1000)]
    """Maximum speed [rad/s]."""
    acceleration: Annotated[float, Field(ge=1e-3, le=1000)]
    """Maximum acceleration [rad/s^2]."""


class ArmDescription(Record):
    """Description of one arm."""

    model: str | None = None
    """URDF or MJCF file of this arm, relative to the description; None if one model contains both arms."""
    mount: Frame = Frame()
    """Pose of this arm's model in the base of the robot, if each arm has its own model."""
    joints: list[str]
    """Names of the arm's joints in the model, from the base outwards."""
    link: str
    """Name of the wrist's body in the model: the body that the last joint moves, or a body that is fixed to it."""
    tool: Frame
    """Pose X_WT of the tool T in the wrist W; see `Jaw`."""
    initial: Numbers
    """Joint angles at which motions start [rad]."""
    speed: Numbers
    """Maximum speed of each joint [rad/s]."""
    acceleration: Numbers
    """Maximum acceleration of each joint [rad/s^2]."""
    faster_than_model: list[str] = Field(default_factory=list)
    """Joints for which the limit in `speed` is used even if it is higher than the model's own limit."""
    ros: RosNames = RosNames()
    """Names of the arm's controllers and joints in ROS."""
    lerobot: LeRobotNames = LeRobotNames()
    """Keys and units of the arm in LeRobot."""
    standing: dict[str, float] = Field(default_factory=dict)
    """Positions of this arm's joints that are not in `joints` [rad, m]; only if each arm has its own model."""

    jaw: Jaw = Jaw()
    """The fingers, and how they grasp the edge of the cloth."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        count = len(self.joints)
        if count < 5:
            raise ValueError(
                f"must have at least 5 joints, given {count}; the position of the hand needs three joints, and the "
                "direction of the jaws needs two"
            )
        for name in ("initial", "speed", "acceleration"):
            if len(getattr(self, name)) != count:
                raise ValueError(
                    f"{name} must have one value for each of {count} joints, given {len(getattr(self, name))}"
                )
        for name in ("ros.joints", "lerobot.joints", "lerobot.zero", "lerobot.sign"):
            given = attrgetter(name)(self)
            if given is not None and len(given) != count:
                raise ValueError(f"{name} must have one value for each of {count} joints, given {len(given)}")
        if len(set(self.joints)) < count:
            raise ValueError("joints must not contain the same name twice")
        for name in self.faster_than_model:
            if name not in self.joints:
                raise ValueError(f"faster_than_model must name joints of this arm, given {name!r}")
        if min(*self.speed, *self.acceleration) < 1e-3:
            raise ValueError("speed and acceleration must each be at least 0.001")
        return self


class Description(Record):
    """Description of a whole robot."""

    name: str
    model: str | None = None
    """URDF or MJCF file of the whole robot, relative to the description; None if each arm has its own model."""
    base: str = "world"
    """Name of the body in whose frame plans are written. This body must not move."""
    table_heights: tuple[Length, Length] = (0.0, 0.0)
    """Lowest and highest table top that may be chosen, in the base [m]."""
    lerobot_type: str = ""
    """Type of the robot in LeRobot datasets; empty if the type is the robot's name."""
    front: Length = 0.1
    """Position of the table's near edge along x of the base [m]."""
    packages: dict[str, str] = Field(default_factory=dict)
    """Folders of the ROS packages that URDF files name, relative to the description."""
    standing: dict[str, float] = Field(default_factory=dict)
    """Positions of joints outside the arms [rad, m], by their names in the model of the whole robot."""
    disturbances: str | dict[str, Any] | None = None
    """Disturbances of this robot: path of a file, relative to the description, or the contents of such a file."""
    joints: list[str] = Field(default_factory=list)
    """Names of all joints in the order of the plan; empty for the left arm's joints, then the right arm's."""
    trunk: TrunkDescription | None = None
    """Joint that turns both arms; only with a model of the whole robot."""
    initial_pose: str = "initial"
    """Name of the pose in which both arms have their `initial` angles."""
    poses: list[PoseDescription] = Field(default_factory=list)
    """Further poses in which motions can start, if the arms would hit the table in the first one."""
    larm: ArmDescription
    rarm: ArmDescription

    @field_validator("disturbances", mode="before")
    @classmethod
    def _check_disturbances(cls, value: Any) -> Any:
        if not isinstance(value, dict) and not (isinstance(value, str) and value.endswith(".toml")):
            raise ValueError(f"must be a table or the name of a .toml file, given {value!r}")
        return value

    @property
    def arms(self) -> dict[str, ArmDescription]:
        """The left arm, then the right arm, by their names."""
        return {"larm": self.larm, "rarm": self.rarm}

    @property
    def models(self) -> list[str]:
        """File names of the models that the description names, each only once."""
        named = (self.model, self.larm.model, self.rarm.model)
        return list(dict.fromkeys(name for name in named if name is not None))

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.table_heights[0] > self.table_heights[1]:
            raise ValueError(
                f"table_heights must be [minimum, maximum] with minimum <= maximum, given {list(self.table_heights)}"
            )
        alone = [arm.model is not None for arm in (self.larm, self.rarm)]
        if self.model is None and not all(alone):
            raise ValueError("must have a model for the whole robot, or a model in each arm")
        if self.model is not None and any(alone):
            raise ValueError("must not have both a model for the whole robot and a model in an arm")
        if self.model is None and self.base != "world":
            raise ValueError(
                "base must be 'world' for a pair of single arms, because each mount states the place of its arm"
            )
        if self.model is None and self.standing:
            raise ValueError("standing must be under [larm] and [rarm] for a pair of single arms")
        if self.model is not None and (self.larm.standing or self.rarm.standing):
            raise ValueError(
                "standing must be at the top of the file, not under [larm] or [rarm], if one model describes the whole "
                "robot"
            )
        if self.model is None and self.trunk is not None:
            raise ValueError("trunk must be left out for a pair of single arms")
        arms = {*self.larm.joints, *self.rarm.joints, *([self.trunk.joint] if self.trunk else [])}
        if self.joints and self.model is None:
            raise ValueError("joints must be left out for a pair of single arms")
        if self.joints and not arms <= set(self.joints):
            raise ValueError("joints must contain every joint of the arms and the trunk")
        for further in self.poses:
            if (len(further.larm), len(further.rarm)) != (len(self.larm.joints), len(self.rarm.joints)):
                raise ValueError(f"poses: {further.name} must have as many angles as the arms have joints")
        return self


def disturbances_of(path: Path, description: Description) -> Disturbances | None:
    """Return the disturbances that a robot's description names or contains; None if there are no disturbances.

    Raises:
        InputError: If the file of disturbances cannot be read, or a field is wrong.
    """
    own = description.disturbances
    if own is None:
        return None
    if isinstance(own, str):
        return read_disturbances(beside(path, own))
    return disturbances_in(own, f"{path}: disturbances")


def read_description(path: Path) -> Description:
    """Read and validate a description.

    Raises:
        InputError: If the description cannot be read, or a field is wrong.
    """
    return validated(Description, read_toml(path), path)


def model_of(path: Path, description: Description, model: str) -> ModelFile:
    """Read a model that a description names, with all files that the model names.

    Raises:
        InputError: If one of the files cannot be read.
    """
    file = beside(path, model)
    if not file.is_file():
        raise InputError(f"{path}: model: must be an existing file, given {file}")
    return read_model(file, {name: beside(path, folder) for name, folder in description.packages.items()})
