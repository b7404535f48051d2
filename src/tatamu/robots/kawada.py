"""HIRONX and NEXTAGE Open as MuJoCo models, made only from boxes and the numbers in `hironx`."""

from __future__ import annotations

from typing import Any

import numpy as np

from tatamu.base.errors import InputError
from tatamu.robots import hironx as facts
from tatamu.robots.extras import needed
from tatamu.robots.fingers import FingerShape, add_fingers, jaw_of
from tatamu.robots.model import Arm, Robot, StartPose
from tatamu.robots.pose import pose, turn

HAND_HALF = (0.042, 0.016)
"""Half the width of the open hand along y, and half its depth along z [m].

The values are the extents of the finger links in [H-DAE] at 30 degrees; `hironx` lists this source.
"""
FINGER_LENGTH = 0.030
FINGERS = FingerShape("hironx", root=(0.0, 0.0), length=FINGER_LENGTH)
"""Shape of a finger: a single box, which contains the pad and the plate behind it."""
WIDEST = 0.1
"""Largest opening of the hand [m], from setHandWidth in [CLIENT]; `hironx` lists this source."""


def kawada(
    name: str, wrist_offset: float | None = None, fingertip: float | None = None, nextage: bool = False
) -> Robot:
    """Return the robot HIRONX, or NEXTAGE Open if `nextage` is true.

    Args:
        name: Name of the robot in plans.
        wrist_offset: Offset from joint J4 to joint J5 along x [m]; None for -0.047.
        fingertip: Distance from the origin of the last link to the fingertip, along the link's -x [m]. With None, the
            distance of the stock hand is used.
        nextage: Whether to use the speeds, the range of LARM_JOINT3 and the tool of NEXTAGE Open.

    Raises:
        InputError: If a length is outside the range that is possible for this wrist or hand.
    """
    wrist_offset = facts.WRIST_OFFSET if wrist_offset is None else wrist_offset
    usual = facts.NEXTAGE_FINGERTIP if nextage else facts.FINGERTIP
    fingertip = usual if fingertip is None else fingertip
    if not -0.2 <= wrist_offset <= 0.0:
        raise InputError(f"wrist offset: must be from -0.2 to 0 m, given {wrist_offset:g}")
    if not 0.05 <= fingertip <= 0.4:
        raise InputError(f"fingertip: must be from 0.05 to 0.4 m beyond the wrist, given {fingertip:g}")
    right, left = (facts.arm(side, wrist_offset, nextage) for side in "RL")
    rows = (*facts.TRUNK, *right, *left)
    acceleration = facts.NEXTAGE_PLANNED_ACCELERATION if nextage else facts.PLANNED_ACCELERATION
    trunk = facts.TRUNK[0]
    starts = tuple(
        StartPose(start, np.radians(degrees["LARM"]), np.radians(degrees["RARM"]))
        for start, degrees in facts.START_DEGREES.items()
    )
    return Robot(
        name=name,
        spec=_spec(rows, fingertip),
        base="WAIST",
        larm=_arm("larm", left, starts[0].larm, fingertip, nextage, acceleration),
        rarm=_arm("rarm", right, starts[0].rarm, fingertip, nextage, acceleration),
        joints=tuple(row.name for row in rows),
        trunk="CHEST_JOINT0",
        trunk_speed=(trunk.nextage_speed if nextage else trunk.speed, facts.PLANNED_SPEED),
        trunk_acceleration=acceleration,
        poses=starts,
        table_heights=facts.TABLE_HEIGHTS,
        front=facts.FRONT,
    )


def _arm(
    name: str,
    rows: tuple[facts.Joint, ...],
    initial: np.ndarray,
    fingertip: float,
    nextage: bool,
    acceleration: float,
) -> Arm:
    speed = np.array([row.nextage_speed if nextage else row.speed for row in rows])
    return Arm(
        name=name,
        joints=tuple(row.name for row in rows),
        link=f"{rows[-1].name}_Link",
        tool_in_wrist=_tool(fingertip),
        initial=initial,
        speed=speed,
        planned_speed=np.minimum(speed, facts.PLANNED_SPEED),
        planned_acceleration=np.full(len(rows), acceleration),
        jaw=jaw_of(name, FINGERS, WIDEST),
    )


def _tool(fingertip: float) -> np.ndarray:
    """Return the pose X_WT of the tool T in the wrist W.

    The hand points along -x of the last link. The z axis of T points the same way, like the tip frame of [H-DAE], which
    `hironx` lists.
    """
    return pose(turn(1, -np.pi / 2), np.array([-fingertip, 0.0, 0.0]))


def _spec(rows: tuple[facts.Joint, ...], fingertip: float) -> Any:
    mujoco = needed("mujoco")
    spec = mujoco.MjSpec()
    spec.modelname = "tatamu-kawada"
    spec.compiler.degree = False
    bodies = {"WAIST": spec.worldbody.add_body(name="WAIST")}
    for row in rows:
        half = row.roll / 2
        body = bodies[row.parent].add_body(
            name=f"{row.name}_Link", pos=row.position, quat=[np.cos(half), np.sin(half), 0, 0]
        )
        body.add_joint(name=row.name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=row.axis, range=[row.lower, row.upper])
        bodies[f"{row.name}_Link"] = body
    for name, body in bodies.items():
        _mass(body, name)
        _box(body, name, mujoco)
        if name.endswith("ARM_JOINT5_Link"):
            _hand(body, fingertip, mujoco)
    return spec


def _left(name: str) -> tuple[str, float]:
    """Return the name under which a link's numbers are listed, and a factor for its y coordinates.

    The numbers of only the left arm's links are listed. The factor is -1 for links of the right arm, because they
    mirror the left arm.
    """
    return (f"L{name[1:]}", -1.0) if name.startswith("RARM") else (name, 1.0)


def _mass(body: Any, name: str) -> None:
    left, sign = _left(name)
    mass, (x, y, z), inertia = facts.BODIES[left]
    body.mass, body.ipos, body.inertia = mass, [x, sign * y, z], inertia
    body.explicitinertial = True


def _box(body: Any, name: str, mujoco: Any) -> None:
    left, sign = _left(name)
    for number, corners in enumerate(facts.BOXES.get(left, ())):
        low, high = (np.array(corner) for corner in corners)
        centre = (low + high) / 2 * [1, sign, 1]
        kind = mujoco.mjtGeom.mjGEOM_BOX
        body.add_geom(name=f"{name}_box{number}", type=kind, size=(high - low) / 2, pos=centre)


def _hand(body: Any, fingertip: float, mujoco: Any) -> None:
    """Add the hand to a link: a box between the link and the fingers, and the fingers."""
    wrist = -facts.BOXES["LARM_JOINT5_Link"][0][0][0]
    start, end = wrist, max(wrist + 1e-3, fingertip - FINGER_LENGTH)
    width, depth = HAND_HALF
    body.add_geom(
        name=f"{body.name}_hand",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[(end - start) / 2, width, depth],
        pos=[-(start + end) / 2, 0, 0],
        rgba=[0.3, 0.3, 0.35, 1],
    )
    arm = "larm" if body.name.startswith("L") else "rarm"
    add_fingers(body, arm, _tool(fingertip), FINGERS, WIDEST)
