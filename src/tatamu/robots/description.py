"""Any dual-arm robot: a short TOML file that names its model, arms, tool frames and limits.

docs/reference/robot-description.md has an example.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field, field_validator, model_validator

from tatamu.disturbances import Disturbances, disturbances_in, read_disturbances
from tatamu.errors import InputError
from tatamu.files import read_toml, validated
from tatamu.records import Record
from tatamu.robots.clearance import Clearance
from tatamu.robots.extras import needed, one_line
from tatamu.robots.model import Arm, Robot, StartPose
from tatamu.robots.pose import from_rpy, pose, to_quaternion

Vector = tuple[float, float, float]
Numbers = Annotated[list[float], Field(min_length=1)]


class Frame(Record):
    """A pose: translation, and rotation about fixed x, then y, then z, as in URDF."""

    xyz: Vector = (0.0, 0.0, 0.0)
    """Translation [m]."""
    rpy: Vector = (0.0, 0.0, 0.0)
    """Rotation about fixed x, y, z [rad]."""

    @property
    def matrix(self) -> np.ndarray:
        """As a matrix, shape (4, 4)."""
        return pose(from_rpy(*self.rpy), np.array(self.xyz))


class ArmDescription(Record):
    """Description of one arm."""

    model: str | None = None
    """URDF or MJCF of this arm alone, when two single arms make a pair; beside the description."""
    mount: Frame = Frame()
    """Pose of that arm's model in the pair's base."""
    joints: Annotated[list[str], Field(min_length=5)]
    """Joint names of the model, from the base outwards."""
    link: str
    """The body of the last joint, or one fixed to it: the wrist."""
    tool: Frame
    """X_WT, the fingertips in the wrist; z is the direction of approach."""
    initial: Numbers
    """Joint angles at which motions start [rad]."""
    speed: Numbers
    """Greatest speed of each joint [rad/s]."""
    acceleration: Numbers
    """Greatest acceleration of each joint [rad/s^2]."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        for name in ("initial", "speed", "acceleration"):
            if len(getattr(self, name)) != len(self.joints):
                raise ValueError(f"{name} must be as many as joints ({len(self.joints)})")
        if len(set(self.joints)) < len(self.joints):
            raise ValueError("joints must differ")
        if min(self.speed) <= 0 or min(self.acceleration) <= 0:
            raise ValueError("speed and acceleration must be above 0")
        return self


class Description(Record):
    """Description of a robot."""

    name: str
    model: str | None = None
    """URDF or MJCF of the whole robot; beside the description."""
    base: str = "world"
    """The body that plans are written in; it must not move."""
    table_heights: tuple[float, float] = (0.0, 0.0)
    """Lowest and highest table top that may be chosen, in the base [m]."""
    front: float = 0.1
    """Near edge of the table, along x of the base [m]."""
    disturbances: str | dict[str, Any] | None = None
    """Of this robot: a file of disturbances beside the description, or what such a file holds."""
    larm: ArmDescription
    rarm: ArmDescription

    @field_validator("disturbances", mode="before")
    @classmethod
    def _check_disturbances(cls, value: Any) -> Any:
        if not isinstance(value, dict) and not (isinstance(value, str) and value.endswith(".toml")):
            raise ValueError(f"must be the name of a file .toml, or a table, given {value!r}")
        return value

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.table_heights[0] > self.table_heights[1]:
            raise ValueError("table_heights must be the lower, then the higher")
        alone = [arm.model is not None for arm in (self.larm, self.rarm)]
        if self.model is None and not all(alone):
            raise ValueError("must have a model for the whole robot, or one in each arm")
        if self.model is not None and any(alone):
            raise ValueError("must have a model for the whole robot, or one in each arm, not both")
        if self.model is None and self.base != "world":
            raise ValueError("base must be 'world' for a pair of single arms: each arm's mount says where it stands")
        return self


def described(path: Path) -> Robot:
    """Load the robot of a description and the models that it names.

    Raises:
        InputError: A file cannot be read, a field is wrong, or the model has no such joint or body.
    """
    description = _read_description(path)
    _disturbances(path, description)
    arms = {"larm": description.larm, "rarm": description.rarm}
    spec = _pair(path, arms) if description.model is None else _read(path, description.model)
    prefix = {name: f"{name}_" if description.model is None else "" for name in arms}
    larm, rarm = (_arm(name, arm, prefix[name]) for name, arm in arms.items())
    robot = Robot(
        name=description.name,
        spec=spec,
        base=description.base,
        larm=larm,
        rarm=rarm,
        joints=(*larm.joints, *rarm.joints),
        trunk=None,
        trunk_speed=(1.0, 1.0),
        trunk_acceleration=1.0,
        poses=(StartPose("initial", larm.initial, rarm.initial),),
        table_heights=description.table_heights,
        front=description.front,
    )
    _check(path, robot)
    for arm in robot.arms:
        _check_chain(path, robot, arm, prefix[arm.name])
    return robot


def files_of(path: Path) -> list[Path]:
    """The files that a robot is made from: its description, the models and disturbances that this names, and meshes.

    Raises:
        InputError: The description or another file cannot be read.
    """
    description = _read_description(path)
    _disturbances(path, description)
    parts = (description, description.larm, description.rarm)
    models = dict.fromkeys(part.model for part in parts if part.model is not None)
    found = [path]
    for model in models:
        spec = _read(path, model)
        file = path.parent / model
        meshes = (file.parent / spec.meshdir / mesh.file for mesh in spec.meshes)
        found += [file, *(mesh for mesh in dict.fromkeys(meshes) if mesh.is_file())]
    if isinstance(description.disturbances, str):
        found.append(path.parent / description.disturbances)
    return found


def disturbances_of(path: Path) -> Disturbances | None:
    """The disturbances that a robot's description names or holds; None where it has none of its own.

    Raises:
        InputError: The description or the file that it names cannot be read, or a field is wrong.
    """
    return _disturbances(path, _read_description(path))


def _read_description(path: Path) -> Description:
    return validated(Description, read_toml(path), path)


def _disturbances(path: Path, description: Description) -> Disturbances | None:
    own = description.disturbances
    if own is None:
        return None
    if isinstance(own, str):
        return read_disturbances(path.parent / own)
    return disturbances_in(own, f"{path}: disturbances")


def _arm(name: str, arm: ArmDescription, prefix: str) -> Arm:
    speed = np.array(arm.speed)
    return Arm(
        name=name,
        joints=tuple(prefix + joint for joint in arm.joints),
        link=prefix + arm.link,
        tool_in_wrist=arm.tool.matrix,
        initial=np.array(arm.initial),
        speed=speed,
        planned_speed=speed,
        planned_acceleration=np.array(arm.acceleration),
    )


def _read(path: Path, model: str) -> Any:
    """Read a model file beside the description."""
    mujoco = needed("mujoco")
    file = path.parent / model
    if not file.is_file():
        raise InputError(f"{path}: model: there is no file {file}")
    try:
        spec = mujoco.MjSpec.from_file(str(file))
    except ValueError as error:
        raise InputError(f"{file}: is no URDF or MJCF that MuJoCo reads ({one_line(error)})") from None
    spec.compiler.fusestatic = False
    return spec


def _pair(path: Path, arms: dict[str, ArmDescription]) -> Any:
    """Join two single arms in one model; their names get `larm_` and `rarm_` in front."""
    mujoco = needed("mujoco")
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    for name, arm in arms.items():
        assert arm.model is not None
        X_BM = arm.mount.matrix
        frame = spec.worldbody.add_frame(pos=X_BM[:3, 3], quat=to_quaternion(X_BM[:3, :3]))
        spec.attach(_read(path, arm.model), prefix=f"{name}_", frame=frame)
    return spec


def _check(path: Path, robot: Robot) -> None:
    """Refuse names of the description that the model does not have."""
    for arm in robot.arms:
        if robot.spec.body(arm.link) is None:
            raise InputError(f"{path}: {arm.name}.link: the model has no body {arm.link!r}")
        for joint in arm.joints:
            if robot.spec.joint(joint) is None:
                raise InputError(f"{path}: {arm.name}.joints: the model has no joint {joint!r}")
    for joint in robot.rarm.joints:
        if joint in robot.larm.joints:
            raise InputError(f"{path}: rarm.joints: {joint} is larm's already")
    if robot.base != "world" and robot.spec.body(robot.base) is None:
        raise InputError(f"{path}: base: the model has no body {robot.base!r}")
    try:
        model = robot.model
    except ValueError as error:
        raise InputError(f"{path}: the model does not compile ({one_line(error)})") from None
    if model.nq != model.njnt:
        raise InputError(f"{path}: model: every joint must be a hinge or a slide")
    for arm in robot.arms:
        for joint, angle in zip(arm.joints, arm.initial, strict=True):
            low, high = model.joint(joint).range
            if not model.joint(joint).limited[0]:
                raise InputError(f"{path}: {arm.name}.joints: {joint} has no limits in the model")
            if not low <= angle <= high:
                raise InputError(
                    f"{path}: {arm.name}.initial: {joint} must be from {low:.4g} to {high:.4g} rad, given {angle:.4g}"
                )


def _check_chain(path: Path, robot: Robot, arm: Arm, prefix: str) -> None:
    """Refuse joints that do not lead to the wrist in this order, or move no collision shapes."""
    where = f"{path}: {arm.name}.joints:"
    names = [name.removeprefix(prefix) for name in arm.joints]
    on_the_way = [joint.removeprefix(prefix) for joint in _joints_to(robot.model, arm.link)]
    for name in names:
        if name not in on_the_way:
            raise InputError(f"{where} {name} does not move {arm.link.removeprefix(prefix)}")
    ordered = [name for name in on_the_way if name in names]
    if names != ordered:
        raise InputError(f"{where} must go from the base outwards: {', '.join(ordered)}")
    if not Clearance(robot, ("to the table",), arm.name).kinds:
        raise InputError(f"{path}: {arm.name}: the model has no collision shapes, which distances are taken between")


def _joints_to(model: Any, link: str) -> list[str]:
    """The joints that move a body, from the base outwards."""
    found: list[str] = []
    body = model.body(link).id
    while body:
        first = int(model.body_jntadr[body])
        found = [str(model.joint(first + number).name) for number in range(model.body_jntnum[body])] + found
        body = int(model.body_parentid[body])
    return found
