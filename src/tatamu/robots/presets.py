"""Pairs of single arms by name.

In some pairs, the arms face each other across the cloth. In others, they stand side by side.

A mount gives the positions of the arms' feet. For each pair, several mounts were compared, and the mount with which the
pair can do the most folds was chosen.

The origin of the base B is on the table, in the middle between both feet. The x axis is the direction of the fold, and
the y axis points to the left arm.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tatamu.robots.arm_facts import FR3, PANDA, UR5E, XARM7, Box, SerialArm
from tatamu.robots.extras import needed
from tatamu.robots.fingers import add_fingers, jaw_of
from tatamu.robots.light_arms import OPENARM, SO101, VIPERX
from tatamu.robots.model import Arm, Robot, StartPose
from tatamu.robots.placement import Hold
from tatamu.robots.pose import from_rpy, pose, to_quaternion, turn

CAREFUL = 0.5
"""Fraction of a joint's largest speed that plans use."""
FASTEST = 3.0
"""Speed limit in plans for joints whose motors are faster than an arm should move [rad/s]."""


@dataclass(frozen=True)
class Mount:
    """Positions of the feet of a pair of arms. The right arm mirrors the left arm."""

    x: float
    """x of both feet [m]."""
    y: float
    """y of the left foot [m]. x of the foot's own frame points forward."""
    yaw: float
    """Yaw of the left foot [rad].

    It is 0 if the arms are side by side, and -pi / 2 if the left arm faces the right arm.
    """
    front: float
    """Position of the table's near edge along x of the base B [m]."""
    z: float = 0.0
    """Height of the feet [m]."""
    table_heights: tuple[float, float] = (0.0, 0.0)
    """Lowest and highest table top [m]."""


def side_by_side(y: float) -> Mount:
    """Return a mount with arms side by side, which both face the table.

    The distance between their feet is 2 y.
    """
    return Mount(0.0, y, 0.0, 0.15)


def facing(y: float, front: float, z: float = 0.0) -> Mount:
    """Return a mount with arms that face each other.

    The distance between their feet is 2 y, and the table begins at `front`.
    """
    return Mount(0.0, y, -np.pi / 2, front, z)


PEDESTAL = Mount(0.0, 0.031, 0.0, 0.12, table_heights=(-0.50, -0.28))
"""Mount of the robot OpenArm: a pedestal from whose top both arms hang."""


PAIRS: dict[str, tuple[SerialArm, Mount]] = {
    "fr3-pair": (FR3, facing(0.65, -0.60)),
    "panda-pair": (PANDA, facing(0.65, -0.60)),
    "ur5e-pair": (UR5E, facing(0.65, -0.60)),
    "xarm7-pair": (XARM7, facing(0.60, -0.60)),
    "so101-pair": (SO101, Mount(0.0, 0.10, 0.0, 0.12)),
    "aloha2": (VIPERX, facing(0.469, -0.45, 0.02)),
    "openarm": (OPENARM, PEDESTAL),
}
"""The arm and the mount of each pair, by the pair's name. `python -m benchmarks.presets` compares mounts."""


def pair_of_arms(name: str, arm: SerialArm, mount: Mount) -> Robot:
    """Return the robot that consists of two arms on a mount."""
    larm, rarm = _arm("larm", arm, mount), _arm("rarm", arm.right or arm, mount)
    return Robot(
        name=name,
        spec=_spec(arm, mount),
        base="world",
        larm=larm,
        rarm=rarm,
        joints=(*larm.joints, *rarm.joints),
        trunk=None,
        trunk_speed=(1.0, 1.0),
        trunk_acceleration=1.0,
        poses=(StartPose("ready", larm.initial, rarm.initial),),
        table_heights=mount.table_heights,
        front=mount.front,
        lerobot_type=arm.lerobot_type,
    )


def _feet(mount: Mount) -> dict[str, np.ndarray]:
    """Return the poses X_BM of the feet of both arms in the base B."""
    return {
        "larm": pose(turn(2, mount.yaw), np.array([mount.x, mount.y, mount.z])),
        "rarm": pose(turn(2, -mount.yaw), np.array([mount.x, -mount.y, mount.z])),
    }


def _arm(side: str, arm: SerialArm, mount: Mount) -> Arm:
    """Return the arm in a pose in which its jaw opens along x of the base B.

    This direction is at right angles to the edge of the cloth.

    If the axis of the last joint is not the direction of approach, the arm stays in its ready pose.
    """
    yaw = _feet(mount)[side][:3, :3]
    initial = np.array(arm.ready)
    X_WG = pose(from_rpy(*arm.gripper.rpy), np.array(arm.gripper.xyz))
    R_BG = yaw @ _wrist(arm, initial) @ X_WG[:3, :3]
    wanted = R_BG.T @ Hold(0.0).rotation(0.0)  # a rotation about the gripper's z
    last = arm.hinges[-1]
    about = float(np.array(last.axis) @ X_WG[:3, 2])
    angle = about * float(np.arctan2(wanted[1, 0], wanted[0, 0]))
    turns = (angle, angle - np.copysign(np.pi, angle))  # a gripper that is turned by pi looks the same
    turned = min(turns, key=lambda by: abs(initial[-1] + by - (last.lower + last.upper) / 2))
    initial[-1] += turned
    flip = turn(2, np.pi) if turned != angle else np.eye(3)
    tool = X_WG @ pose(flip, np.array([0.0, 0.0, arm.gripper.fingertip]))
    speed = np.array([hinge.speed for hinge in arm.hinges])
    return Arm(
        name=side,
        joints=tuple(f"{side}_{joint}" for joint in arm.joints),
        link=f"{side}_link{len(arm.joints)}",
        tool_in_wrist=tool,
        initial=initial,
        speed=speed,
        planned_speed=np.minimum(CAREFUL * speed, FASTEST),
        planned_acceleration=np.full(len(speed), arm.acceleration),
        jaw=jaw_of(side, arm.gripper.finger, arm.gripper.widest),
        lerobot=arm.lerobot,
    )


def _wrist(arm: SerialArm, angles: np.ndarray) -> np.ndarray:
    """Return the rotation of the last link relative to the foot, shape (3, 3)."""
    R = np.eye(3)
    for hinge, angle in zip(arm.hinges, angles, strict=True):
        number = int(np.argmax(np.abs(hinge.axis)))
        R = R @ from_rpy(*hinge.rpy) @ turn(number, hinge.axis[number] * float(angle))
    return R


def _spec(arm: SerialArm, mount: Mount) -> Any:
    mujoco = needed("mujoco")
    spec = mujoco.MjSpec()
    spec.modelname = f"tatamu-{arm.name}-pair"
    spec.compiler.degree = False
    for (side, X_BM), one in zip(_feet(mount).items(), (arm, arm.right or arm), strict=True):
        quat = to_quaternion(X_BM[:3, :3])
        body = spec.worldbody.add_body(name=f"{side}_foot", pos=X_BM[:3, 3], quat=quat)
        _add_boxes(body, one.base, 1.0, mujoco)
        for number, (name, hinge) in enumerate(zip(one.joints, one.hinges, strict=True), start=1):
            body = body.add_body(name=f"{side}_link{number}", pos=hinge.xyz, quat=to_quaternion(from_rpy(*hinge.rpy)))
            limits = [hinge.lower, hinge.upper]
            body.add_joint(name=f"{side}_{name}", type=mujoco.mjtJoint.mjJNT_HINGE, axis=hinge.axis, range=limits)
            _add_boxes(body, hinge.boxes or _SMALL, hinge.mass, mujoco)
        _add_gripper(body, side, one, mujoco)
    return spec


_SMALL: tuple[Box, ...] = (((-0.03, -0.03, -0.02), (0.03, 0.03, 0.0)),)
"""Box that stands for a flange if the source of the arm has no shape for the flange."""


def _add_gripper(wrist: Any, side: str, arm: SerialArm, mujoco: Any) -> None:
    gripper = arm.gripper
    hand = wrist.add_body(name=f"{wrist.name}_gripper", pos=gripper.xyz, quat=to_quaternion(from_rpy(*gripper.rpy)))
    _add_boxes(hand, (gripper.palm,), gripper.mass, mujoco)
    tip = pose(np.eye(3), np.array([0.0, 0.0, gripper.fingertip]))
    add_fingers(hand, side, tip, gripper.finger, gripper.widest)


def _add_boxes(body: Any, boxes: tuple[Box, ...], mass: float, mujoco: Any) -> None:
    """Add boxes of equal density to a body. Together they weigh `mass`."""
    halves = [(np.array(high) - np.array(low)) / 2 for low, high in boxes]
    volume = sum(float(np.prod(half)) for half in halves)
    for half, (low, high) in zip(halves, boxes, strict=True):
        centre = (np.array(low) + np.array(high)) / 2
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=half, pos=centre, mass=mass * float(np.prod(half)) / volume)
