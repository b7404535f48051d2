"""Data of single arms that laboratories own: joints, limits, masses, boxes around the links, and the stock gripper.

The data are facts from public models; no meshes are included.

Lengths [m], angles [rad], speeds [rad/s], accelerations [rad/s^2], masses [kg].

Each of the following sources is given with the data that were read from it.

[PANDA]  example-robot-data 6.0.0, panda_description/urdf/panda.urdf: joints, limits, masses, boxes of its meshes
[FR3]    Franka Robotics, Robot and interface specifications, limits for Franka Research 3
         (frankarobotics.github.io/docs/control_parameters.html); links and joint positions are the same as in [PANDA]
[UR]     Universal Robots, Parameters for calculations of kinematics and dynamics: Denavit-Hartenberg parameters, masses
[UR-M]   robosuite 1.5.2, robots/ur5e/robot.xml: ranges, boxes of its collision meshes
[XARM]   example-robot-data 6.0.0, xarm_description/urdf/xarm7.urdf: joints, limits, masses
[XARM-M] robosuite 1.5.2, robots/xarm7/robot.xml: boxes of its collision meshes
[2F-85]  robosuite 1.5.2, grippers/robotiq_gripper_85.xml: boxes of the open gripper. google-deepmind/mujoco_menagerie,
         robotiq_2f85/2f85.xml: coupling (10.8 mm), and length of the closed gripper, whose linkage was driven to
         0.8 rad with parallel pads
[XARM-G] robosuite 1.5.2, grippers/xarm7_gripper.xml: boxes of the open gripper. xArm-Developer/xarm_ros2,
         xarm_gripper.urdf.xacro: length of the closed gripper, whose linkage was driven to 0.85 rad. This file's
         link_tcp, at 0.172 from the flange, is 2.5 mm behind the fingertips

The sizes of the fingertips and their sources are in `tatamu.folding.fingers`.

In plans, joints accelerate by at most 5 rad/s^2. This limit is below Franka's own limits: 7.5 for Panda, 10 for FR3.
MoveIt's configurations of UR arms have limits from 5 to 10. No published limit of UFACTORY's xArm was found.

The boxes come from `python -m benchmarks.link_boxes`. Their faces are moved outwards to whole millimetres.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tatamu.robots.fingers import FingerShape
from tatamu.robots.interfaces import LeRobotNames

Vector = tuple[float, float, float]
Box = tuple[Vector, Vector]
RIGHT = np.pi / 2


LEROBOT = LeRobotNames()
"""Default names and units in LeRobot: radians, metres, and keys made from the names of the joints."""


class Hinge(NamedTuple):
    """A revolute joint and the link that the joint moves."""

    xyz: Vector
    """Origin of the joint in the frame of the previous link [m]."""
    rpy: Vector
    """Rotation from the previous link's frame to the joint's frame, about fixed x, y, z, at joint angle zero [rad]."""
    lower: float
    upper: float
    speed: float
    mass: float
    """Mass of the link that the joint moves [kg]."""
    boxes: tuple[Box, ...]
    """Boxes around the link that the joint moves, in the frame of that link [m]."""
    axis: Vector = (0.0, 0.0, 1.0)
    """Axis of the joint, in the frame of the link that the joint moves."""


class ParallelGripper(NamedTuple):
    """A gripper with two fingers.

    Its frame is at the flange: z points outwards, and the fingers are side by side along y.
    """

    xyz: Vector
    """Position of the flange in the frame of the last link [m]."""
    rpy: Vector
    """Rotation of the gripper's frame in the last link, about fixed x, y, z [rad]."""
    palm: Box
    finger: FingerShape
    widest: float
    """Widest opening between the fingertips [m]."""
    fingertip: float
    """Distance from the flange to the ends of the closed fingers [m]."""
    mass: float


@dataclass(frozen=True)
class SerialArm:
    """One arm and its gripper."""

    name: str
    joints: tuple[str, ...]
    hinges: tuple[Hinge, ...]
    base: tuple[Box, ...]
    gripper: ParallelGripper
    ready: tuple[float, ...]
    """Joint angles at which the gripper is in front of the arm and points straight down [rad]."""
    acceleration: float
    """Largest acceleration of a joint in plans [rad/s^2]."""
    lerobot: LeRobotNames = LEROBOT
    lerobot_type: str = ""
    """Robot type of a pair of these arms in LeRobot."""
    right: SerialArm | None = None
    """The right arm of a pair; None if both arms of the pair are equal."""


_PANDA_BOXES: tuple[tuple[Box, ...], ...] = (
    (
        ((-0.155, -0.080, -0.001), (-0.078, 0.080, 0.113)),
        ((-0.079, -0.095, -0.001), (-0.003, 0.095, 0.141)),
        ((-0.004, -0.095, -0.001), (0.072, 0.095, 0.141)),
    ),
    (
        ((-0.055, -0.089, -0.193), (0.056, 0.056, -0.109)),
        ((-0.055, -0.123, -0.110), (0.056, 0.051, -0.027)),
        ((-0.055, -0.130, -0.028), (0.055, 0.025, 0.055)),
    ),
    (
        ((-0.056, -0.195, -0.056), (0.055, -0.110, 0.089)),
        ((-0.056, -0.111, -0.051), (0.055, -0.027, 0.123)),
        ((-0.055, -0.028, -0.025), (0.055, 0.056, 0.130)),
    ),
    (
        ((-0.055, -0.055, -0.122), (0.010, 0.075, 0.012)),
        ((0.009, -0.055, -0.122), (0.074, 0.111, 0.055)),
        ((0.073, -0.028, -0.099), (0.138, 0.112, 0.056)),
    ),
    (
        ((-0.138, -0.012, -0.056), (-0.073, 0.125, 0.075)),
        ((-0.074, -0.055, -0.055), (-0.009, 0.125, 0.111)),
        ((-0.010, -0.056, -0.028), (0.056, 0.101, 0.112)),
    ),
    (
        ((-0.056, -0.056, -0.265), (0.056, 0.096, -0.158)),
        ((-0.054, -0.038, -0.159), (0.054, 0.119, -0.053)),
        ((-0.052, -0.011, -0.054), (0.052, 0.130, 0.053)),
    ),
    (
        ((-0.049, -0.049, -0.029), (0.013, 0.059, 0.056)),
        ((0.012, -0.052, -0.042), (0.073, 0.082, 0.057)),
        ((0.072, -0.052, -0.044), (0.133, 0.081, 0.049)),
    ),
    (
        ((-0.045, -0.044, 0.051), (-0.002, 0.053, 0.107)),
        ((-0.003, -0.045, 0.051), (0.040, 0.082, 0.107)),
        ((0.039, -0.021, 0.051), (0.082, 0.082, 0.105)),
    ),
)
_FRANKA_PLACES: tuple[tuple[Vector, Vector], ...] = (
    ((0.0, 0.0, 0.333), (0.0, 0.0, 0.0)),
    ((0.0, 0.0, 0.0), (-RIGHT, 0.0, 0.0)),
    ((0.0, -0.316, 0.0), (RIGHT, 0.0, 0.0)),
    ((0.0825, 0.0, 0.0), (RIGHT, 0.0, 0.0)),
    ((-0.0825, 0.384, 0.0), (-RIGHT, 0.0, 0.0)),
    ((0.0, 0.0, 0.0), (RIGHT, 0.0, 0.0)),
    ((0.088, 0.0, 0.0), (RIGHT, 0.0, 0.0)),
)
_FRANKA_MASSES = (4.970684, 0.646926, 3.228604, 3.587895, 1.225946, 1.666555, 0.735522)
_FRANKA_HAND = ParallelGripper(
    xyz=(0.0, 0.0, 0.107),
    rpy=(0.0, 0.0, -np.pi / 4),
    palm=((-0.032, -0.104, -0.026), (0.032, 0.104, 0.066)),
    finger=FingerShape("franka-hand", root=(0.026, 0.022), length=0.0474),
    widest=0.08,
    fingertip=0.1134,
    mass=0.76,
)


def _franka(name: str, limits: tuple[tuple[float, float, float], ...]) -> SerialArm:
    rows = zip(_FRANKA_PLACES, limits, _FRANKA_MASSES, _PANDA_BOXES[1:], strict=True)
    return SerialArm(
        name=name,
        joints=tuple(f"joint{number}" for number in range(1, 8)),
        hinges=tuple(Hinge(*place, *limit, mass, boxes) for place, limit, mass, boxes in rows),
        base=_PANDA_BOXES[0],
        gripper=_FRANKA_HAND,
        ready=(0.0, -np.pi / 4, 0.0, -3 * np.pi / 4, 0.0, RIGHT, np.pi / 4),
        acceleration=5.0,
    )


PANDA = _franka(
    "panda",
    (
        (-2.8973, 2.8973, 2.175),
        (-1.7628, 1.7628, 2.175),
        (-2.8973, 2.8973, 2.175),
        (-3.0718, -0.0698, 2.175),
        (-2.8973, 2.8973, 2.61),
        (-0.0175, 3.7525, 2.61),
        (-2.8973, 2.8973, 2.61),
    ),
)
FR3 = _franka(
    "fr3",
    (
        (-2.7437, 2.7437, 2.62),
        (-1.7837, 1.7837, 2.62),
        (-2.9007, 2.9007, 2.62),
        (-3.0421, -0.1518, 2.62),
        (-2.8065, 2.8065, 5.26),
        (0.5445, 4.5169, 4.18),
        (-3.0159, 3.0159, 5.26),
    ),
)
"""The arm Franka Research 3.

The arm lowers its speed limits towards the ends of its joints' ranges. Plans therefore use only half of the speed
limits (`presets`).
"""

_XARM_LIMITS = (
    (-2 * np.pi, 2 * np.pi),
    (-2.059, 2.0944),
    (-2 * np.pi, 2 * np.pi),
    (-0.19198, 3.927),
    (-2 * np.pi, 2 * np.pi),
    (-1.69297, np.pi),
    (-2 * np.pi, 2 * np.pi),
)
_XARM_PLACES: tuple[tuple[Vector, Vector], ...] = (
    ((0.0, 0.0, 0.267), (0.0, 0.0, 0.0)),
    ((0.0, 0.0, 0.0), (-RIGHT, 0.0, 0.0)),
    ((0.0, -0.293, 0.0), (RIGHT, 0.0, 0.0)),
    ((0.0525, 0.0, 0.0), (RIGHT, 0.0, 0.0)),
    ((0.0775, -0.3425, 0.0), (RIGHT, 0.0, 0.0)),
    ((0.0, 0.0, 0.0), (RIGHT, 0.0, 0.0)),
    ((0.076, 0.097, 0.0), (-RIGHT, 0.0, 0.0)),
)
_XARM_MASSES = (2.382, 1.869, 1.6383, 1.7269, 1.3203, 1.325, 0.17)
_XARM_BOXES: tuple[tuple[Box, ...], ...] = (
    (
        ((-0.093, -0.049, -0.001), (-0.040, 0.049, 0.155)),
        ((-0.041, -0.064, -0.001), (0.012, 0.064, 0.155)),
        ((0.011, -0.062, -0.001), (0.063, 0.062, 0.155)),
    ),
    (
        ((-0.048, -0.049, -0.113), (0.048, 0.048, -0.058)),
        ((-0.049, -0.056, -0.059), (0.049, 0.076, -0.005)),
        ((-0.049, -0.057, -0.006), (0.049, 0.076, 0.049)),
    ),
    (
        ((-0.048, -0.192, -0.043), (0.048, -0.112, 0.118)),
        ((-0.048, -0.113, -0.043), (0.048, -0.032, 0.119)),
        ((-0.048, -0.033, 0.075), (0.048, 0.048, 0.120)),
    ),
    (
        ((-0.043, -0.043, -0.102), (0.048, 0.053, -0.053)),
        ((-0.040, -0.068, -0.054), (0.095, 0.068, -0.005)),
        ((-0.023, -0.068, -0.006), (0.095, 0.070, 0.043)),
    ),
    (
        ((0.034, -0.170, -0.043), (0.121, -0.098, 0.104)),
        ((-0.033, -0.099, -0.043), (0.121, -0.027, 0.107)),
        ((-0.043, -0.028, 0.067), (0.083, 0.043, 0.107)),
    ),
    (
        ((-0.043, -0.043, -0.174), (0.043, 0.072, -0.102)),
        ((-0.039, 0.004, -0.103), (0.038, 0.087, -0.032)),
        ((-0.038, 0.004, -0.033), (0.038, 0.087, 0.038)),
    ),
    (
        ((-0.038, -0.038, -0.005), (0.013, 0.038, 0.058)),
        ((0.012, -0.036, -0.036), (0.064, 0.069, 0.055)),
        ((0.063, -0.036, -0.038), (0.114, 0.069, 0.041)),
    ),
    (),
)
XARM7 = SerialArm(
    name="xarm7",
    joints=tuple(f"joint{number}" for number in range(1, 8)),
    hinges=tuple(
        Hinge(*place, *limit, 3.14, mass, boxes)
        for place, limit, mass, boxes in zip(_XARM_PLACES, _XARM_LIMITS, _XARM_MASSES, _XARM_BOXES[1:], strict=True)
    ),
    base=_XARM_BOXES[0],
    gripper=ParallelGripper(
        xyz=(0.0, 0.0, 0.0),
        rpy=(0.0, 0.0, 0.0),
        palm=((-0.038, -0.087, -0.009), (0.038, 0.087, 0.108)),
        finger=FingerShape("xarm-gripper", root=(0.045, 0.032), length=0.0665),
        widest=0.084,
        fingertip=0.1745,
        mass=0.8,
    ),
    ready=(0.0, -0.247, 0.0, 0.909, 0.0, 1.15644, 0.0),
    acceleration=5.0,
)

_TURN = 2 * np.pi
_UP, _ASIDE = (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)
UR5E = SerialArm(
    name="ur5e",
    joints=("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3"),
    # Lengths are from [UR], boxes from [UR-M]. [UR-M] also divides the offset of 0.1333 m among the links.
    hinges=(
        Hinge(
            (0.0, 0.0, 0.1625),
            (0.0, 0.0, 0.0),
            *(-_TURN, _TURN, np.pi, 3.761),
            (((-0.061, -0.061, -0.064), (0.061, 0.075, 0.072)),),
        ),
        Hinge(
            (0.0, 0.138, 0.0),
            (0.0, RIGHT, 0.0),
            *(-_TURN, _TURN, np.pi, 8.058),
            (
                ((-0.061, -0.070, -0.061), (0.061, 0.072, 0.122)),
                ((-0.061, -0.076, 0.121), (0.061, 0.072, 0.303)),
                ((-0.061, -0.078, 0.302), (0.061, 0.072, 0.485)),
            ),
            _ASIDE,
        ),
        Hinge(
            (0.0, -0.131, 0.425),
            (0.0, 0.0, 0.0),
            *(-np.pi, np.pi, np.pi, 2.846),
            (
                ((-0.058, -0.050, -0.059), (0.059, 0.054, 0.105)),
                ((-0.053, -0.054, 0.104), (0.053, 0.054, 0.268)),
                ((-0.046, -0.057, 0.267), (0.046, 0.054, 0.432)),
            ),
            _ASIDE,
        ),
        Hinge(
            (0.0, 0.0, 0.3922),
            (0.0, RIGHT, 0.0),
            *(-_TURN, _TURN, np.pi, 1.37),
            (((-0.040, 0.053, -0.057), (0.040, 0.166, 0.054)),),
            _ASIDE,
        ),
        Hinge(
            (0.0, 0.1263, 0.0),
            (0.0, 0.0, 0.0),
            *(-_TURN, _TURN, np.pi, 1.3),
            (((-0.040, -0.057, 0.053), (0.040, 0.054, 0.139)),),
            _UP,
        ),
        Hinge(
            (0.0, 0.0, 0.0997),
            (0.0, 0.0, 0.0),
            *(-_TURN, _TURN, np.pi, 0.365),
            (((-0.038, 0.053, -0.039), (0.038, 0.099, 0.044)),),
            _ASIDE,
        ),
    ),
    base=(((-0.076, -0.076, -0.001), (0.076, 0.076, 0.100)),),
    gripper=ParallelGripper(
        xyz=(0.0, 0.0996, 0.0),
        rpy=(-RIGHT, 0.0, 0.0),
        palm=((-0.038, -0.075, 0.0), (0.038, 0.075, 0.122)),
        finger=FingerShape("robotiq-2f-85", root=(0.0325, 0.022), length=0.0516),
        widest=0.085,
        fingertip=0.1736,
        mass=0.9,
    ),
    ready=(0.0, -RIGHT, RIGHT, -RIGHT, -RIGHT, 0.0),
    acceleration=5.0,
)
