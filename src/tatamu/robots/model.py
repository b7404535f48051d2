"""A dual-arm robot: its MuJoCo model, its two arms, its limits, and the pose in which every motion starts."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from os.path import commonprefix
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from tatamu.evaluation.disturbances import Disturbances
from tatamu.robots.arm import Arm
from tatamu.robots.extras import needed
from tatamu.robots.pose import to_quaternion

TABLE = "tatamu_table"
"""Name of the table's collision shape in the model. `Clearance.set_table` and `stage` set the height of the table."""


@dataclass(frozen=True)
class StartPose:
    """A pose in which motions can start: the angles of both arms [rad], shape (k,)."""

    name: str
    larm: np.ndarray
    rarm: np.ndarray


@dataclass(frozen=True)
class Robot:
    """A robot with two arms on one base."""

    name: str
    spec: Any
    """Model of the robot, a mujoco.MjSpec. It must not be changed after this object exists."""
    base: str
    """Name of the base frame B, in which plans are written. The base is a body that does not move, or `world`."""
    larm: Arm
    rarm: Arm
    joints: tuple[str, ...]
    """Names of all joints in the robot's own order."""
    trunk: str | None
    """Joint that carries both arms and turns them about z of the base B; None if the robot has no trunk joint."""
    trunk_limits: tuple[float, float]
    """Maximum speed [rad/s] and acceleration [rad/s^2] of the trunk in plans."""
    poses: tuple[StartPose, ...]
    """Poses in which motions can start, the usual pose first. The arms are in one of them."""
    table_heights: tuple[float, float]
    """Lowest and highest table top that may be chosen [m]."""
    front: float
    """Position of the table's near edge along x [m]."""
    standing: Mapping[str, float] = field(default_factory=dict)
    """Positions of joints outside the arms, if they differ from the model [rad, m]."""
    lerobot_type: str = ""
    """Type of the robot in LeRobot; empty if the type is the robot's name."""
    notes: tuple[str, ...] = ()
    """What the user must know of how the robot's files were read, one line each."""
    files: tuple[Path, ...] = ()
    """The files that the robot is made from, its description first."""
    disturbances: Disturbances | None = None
    """Disturbances of this robot; None if its description has none."""
    alone: str = ""
    """Name of the only arm that folds; empty if both arms fold."""

    def __deepcopy__(self, memo: object) -> Robot:
        return self  # nothing changes it, and MuJoCo's model cannot be copied

    def __reduce__(self) -> NoReturn:
        raise TypeError(f"{self.name}: a robot and its plans cannot be pickled; write a plan with `export`")

    @property
    def arms(self) -> tuple[Arm, Arm]:
        """The left arm, then the right arm."""
        return self.larm, self.rarm

    @property
    def folding(self) -> tuple[Arm, ...]:
        """The arms that fold, the left arm first."""
        return tuple(arm for arm in self.arms if self.alone in ("", arm.name))

    def ways(self, hands: int) -> list[Robot]:
        """Return the robot in each of its start poses. If one hand folds, each arm folds alone in one of them."""
        alone = [""] if hands == 2 else [arm.name for arm in self.arms]
        return [replace(self.starting(start), alone=name) for start in self.poses for name in alone]

    def starting(self, start: StartPose) -> Robot:
        """Return the same robot with another initial pose."""
        larm, rarm = replace(self.larm, initial=start.larm), replace(self.rarm, initial=start.rarm)
        return replace(self, larm=larm, rarm=rarm)

    @property
    def start(self) -> str:
        """The name of the pose that motions start from."""
        return next(pose.name for pose in self.poses if pose.larm is self.larm.initial)

    @cached_property
    def model(self) -> Any:
        """The compiled mujoco.MjModel, with a tool site for each arm and a table far below the robot."""
        return with_tools(self.spec, self.arms).compile()

    @cached_property
    def columns(self) -> dict[str, int]:
        """Index of each joint's angle in MuJoCo's vector qpos, by the name of the joint."""
        return {name: int(self.model.joint(name).qposadr[0]) for name in self.joints}

    def arm_columns(self, arm: Arm) -> list[int]:
        """Return the indices of an arm's joints in MuJoCo's vector qpos."""
        return [self.columns[name] for name in arm.joints]

    @cached_property
    def finger_columns(self) -> dict[str, int]:
        """Index of each finger joint in MuJoCo's vector qpos."""
        names = [name for arm in self.arms for name in arm.jaw.fingers]
        return {name: int(self.model.joint(name).qposadr[0]) for name in names}

    def limits(self, arm: Arm) -> np.ndarray:
        """Return the lower and upper limit of each of an arm's k joints [rad], shape (k, 2)."""
        return np.array([self.model.joint(name).range for name in arm.joints])

    @cached_property
    def rest(self) -> np.ndarray:
        """Positions of all nq joints at rest, within their limits and with open fingers [rad, m], shape (nq,)."""
        model = self.model
        qpos = np.array(model.qpos0)
        fingers = {name: at[0] for arm in self.arms for name, at in arm.jaw.fingers.items()}
        for name, value in {**self.standing, **fingers}.items():
            qpos[model.joint(name).qposadr[0]] = value
        limited = [number for number in range(model.njnt) if model.jnt_limited[number]]
        columns = model.jnt_qposadr[limited]
        qpos[columns] = np.clip(qpos[columns], *model.jnt_range[limited].T)
        return self.followed(qpos)

    def followed(self, qpos: np.ndarray) -> np.ndarray:
        """Move coupled joints to their leaders in configurations [rad, m], shape (.., nq), and return these."""
        model, kind = self.model, needed("mujoco").mjtEq.mjEQ_JOINT
        active = np.flatnonzero((model.eq_type == kind) & (model.eq_active0 == 1))
        for number in np.tile(active, model.neq):  # a leader may follow another joint
            # A follower q1 of q2 has q1 - q1_0 = c0 + c1 (q2 - q2_0) + .. + c4 (q2 - q2_0)^4; a leader -1 stands still.
            follower, leader = model.eq_obj1id[number], model.eq_obj2id[number]
            at, ahead = model.jnt_qposadr[[follower, leader]]
            moved = qpos[..., ahead] - model.qpos0[ahead] if leader >= 0 else np.zeros(qpos.shape[:-1])
            qpos[..., at] = model.qpos0[at] + np.polynomial.polynomial.polyval(moved, model.eq_data[number, :5])
        return qpos

    def at_rest(self) -> Any:
        """Return a new mujoco.MjData of the robot at rest, with computed kinematics."""
        mujoco = needed("mujoco")
        data = mujoco.MjData(self.model)
        data.qpos[:] = self.rest
        mujoco.mj_kinematics(self.model, data)
        return data

    def configuration(
        self, angles: Sequence[np.ndarray], trunk: np.ndarray | float | None = None, arms: tuple[Arm, ...] = ()
    ) -> np.ndarray:
        """Return configurations of all joints [rad], shape (.., nq).

        Args:
            angles: Joint angles of each of `arms` [rad], shape (.., k). Other arms are in their initial pose.
            trunk: Angle of the trunk [rad], shape (..); None if the trunk is at rest.
            arms: Some arms; empty for the arms that fold.
        """
        qpos = np.broadcast_to(self.rest, (*angles[0].shape[:-1], self.model.nq)).copy()
        stands = {arm.name: arm.initial for arm in self.arms}
        stands |= {arm.name: given for arm, given in zip(arms or self.folding, angles, strict=True)}
        for arm in self.arms:
            qpos[..., self.arm_columns(arm)] = stands[arm.name]
        if self.trunk is not None and trunk is not None:
            qpos[..., self.columns[self.trunk]] = trunk
        return qpos

    def planned(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the maximum speeds [rad/s] and accelerations [rad/s^2] in plans, shape (nq,) each."""
        speed, acceleration = np.ones(self.model.nq), np.ones(self.model.nq)
        for arm in self.arms:
            columns = self.arm_columns(arm)
            speed[columns], acceleration[columns] = arm.planned_speed, arm.planned_acceleration
        if self.trunk is not None:
            column = self.columns[self.trunk]
            speed[column], acceleration[column] = self.trunk_limits
        return speed, acceleration

    @cached_property
    def fingers(self) -> frozenset[str]:
        """Names of the links that are fingers of either hand."""
        return frozenset(link for arm in self.arms for link in arm.jaw.links)

    @property
    def initial(self) -> np.ndarray:
        """The angles of all nq joints in the initial pose [rad], shape (nq,)."""
        return self.configuration([arm.initial for arm in self.folding])


def with_tools(spec: Any, arms: tuple[Arm, ...]) -> Any:
    """Return a copy of the model with each arm's tool frame as a site, and with a table."""
    mujoco = needed("mujoco")
    copy = spec.copy()
    for number, geom in enumerate(copy.geoms):
        geom.name = geom.name or f"{geom.parent.name}_geom{number}"
    for number, joint in enumerate(copy.joints):
        joint.name = joint.name or f"{joint.parent.name}_joint{number}"
    for arm in arms:
        X_WT = arm.tool_in_wrist
        copy.body(arm.link).add_site(name=arm.site, pos=X_WT[:3, 3], quat=to_quaternion(X_WT[:3, :3]))
    copy.worldbody.add_geom(
        name=TABLE,
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[1.5, 1.5, 0.02],
        pos=[0, 0, -10],
        rgba=[0.8, 0.7, 0.6, 1],
    )
    return copy


def state_names(robot: Robot) -> tuple[str, ...]:
    """Return the names of the robot's numbers: left arm, right arm, then the trunk if the robot has a trunk.

    Each arm has the names of its joints, then the name of its gripper. Joints have the names in `lerobot` of the
    description. If `lerobot` has no names, joints have their names in the model, without a common prefix such as
    `larm_`.
    """
    names: list[str] = []
    for side, arm in zip(("left", "right"), robot.arms, strict=True):
        shared = re.match(r".*[_/.\-]", commonprefix(arm.joints))  # noqa: RUF071 (letter by letter is meant)
        start = len(shared[0]) if shared and len(arm.joints) > 1 else 0
        stems = [re.sub(r"[^a-z0-9]+", "_", joint[start:].lower()) for joint in arm.joints]
        names += arm.lerobot.joints or [f"{side}_{stem}.pos" for stem in stems]
        names.append(arm.lerobot.gripper or f"{side}_gripper.pos")
    return (*names, *(() if robot.trunk is None else (f"{robot.trunk.lower()}.pos",)))
