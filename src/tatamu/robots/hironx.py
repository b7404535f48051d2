"""HIRONX and NEXTAGE Open (Kawada): numbers of the chain, the collision boxes, masses, speeds and poses.

The numbers are facts read from public models. The package contains no mesh and no text of these models. Lengths [m],
angles [rad].

[H-URDF] start-jsk/rtmros_hironx f2de65e: hironx_moveit_config/models/HiroNX.urdf
[H-WRL]  kensuke-harada/hironx-interface cda5912: HiroNXInterface/HiroNXGUI/main.wrl
[H-DAE]  start-jsk/rtmros_hironx f2de65e: hironx_ros_bridge/models/kawada-hironx.dae
[N-WRL]  tork-a/rtmros_nextage e605274: nextage_description/models/main.wrl
[CLIENT] start-jsk/rtmros_hironx f2de65e: hironx_ros_bridge/src/hironx_ros_bridge/hironx_client.py

These sources disagree on three numbers:

- The wrist offset, from joint J4 to joint J5 along x, is -0.047 on NEXTAGE Open, and in the CAD data since 2016
  (pull request 461). It is -0.040 in [H-URDF] and [H-WRL]. The offset is therefore a parameter. A wrong offset
  misplaces the fingertip by 7 mm.
- The range of LARM_JOINT3 in [H-URDF] repeats the right arm's range; [H-WRL] and [N-WRL] mirror that range. In this
  module, NEXTAGE Open has the mirrored range. HIRONX has only the angles that are in both ranges.
- The fingertip is 0.093 from the wrist (JSK, hironxjsk-utils.l) or 0.097 (iv-plan). The distance is a parameter with
  the default 0.093.
"""

from __future__ import annotations

from typing import NamedTuple

Vector = tuple[float, float, float]


class Joint(NamedTuple):
    """One revolute joint and the link that the joint moves."""

    name: str
    parent: str
    position: Vector
    """Origin of the joint in the parent link's frame, at joint angle zero [m]."""
    roll: float
    """Rotation of the joint's frame about the parent's x axis, at joint angle zero [rad]."""
    axis: Vector
    lower: float
    upper: float
    speed: float
    """Speed limit of the joint of HIRONX [rad/s], from uvlimit in [H-WRL], a source that this module lists."""
    nextage_speed: float
    """Speed limit of the joint of NEXTAGE Open [rad/s], from [N-WRL], a source that this module lists."""


class Body(NamedTuple):
    """Mass [kg], centre of mass [m], and diagonal inertia about the centre [kg m^2] of one link.

    The source is [H-WRL], which this module lists.
    """

    mass: float
    centre: Vector
    inertia: Vector


X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
WRIST_OFFSET = -0.047
FINGERTIP = 0.093
"""Distance from the origin of the last link to the fingertip, along the link's -x [m]."""
NEXTAGE_FINGERTIP = 0.19
"""Distance from the origin of the last link to NEXTAGE Open's fingertip [m].

The source is rtmros_tutorials: nextage_tutorials/config/nextage.yaml.
"""

TRUNK = (
    Joint("CHEST_JOINT0", "WAIST", (0, 0, 0), 0, Z, -2.844887, 2.844887, 2.268928, 1.919862),
    Joint("HEAD_JOINT0", "CHEST_JOINT0_Link", (0, 0, 0.5695), 0, Z, -1.22173, 1.22173, 2.617994, 2.617994),
    Joint("HEAD_JOINT1", "HEAD_JOINT0_Link", (0, 0, 0), 0, Y, -0.349066, 1.22173, 4.363323, 4.363323),
)


def arm(side: str, wrist_offset: float, mirrored: bool) -> tuple[Joint, ...]:
    """Return the six joints of the right arm (`R`) or the left arm (`L`).

    If `mirrored` is true, LARM_JOINT3 has the full mirrored range of the right arm's joint.
    """
    sign = 1.0 if side == "L" else -1.0
    name = [f"{side}ARM_JOINT{i}" for i in range(6)]
    link = ["CHEST_JOINT0_Link", *(f"{joint}_Link" for joint in name)]
    swivel = (-2.87979, 1.8326)
    if side == "L":
        swivel = (-1.8326, 2.87979) if mirrored else (-1.8326, 1.8326)
    # [N-WRL] gives 215 deg/s for RARM_JOINT2 and 229 deg/s for LARM_JOINT2.
    elbow_speed = 3.996804 if side == "L" else 3.752458
    roll = -sign * 0.261799
    return (
        Joint(name[0], link[0], (0, sign * 0.145, 0.370296), roll, Z, -1.53589, 1.53589, 3.001966, 3.001966),
        Joint(name[1], link[1], (0, 0, 0), 0, Y, -2.443461, 1.047198, 2.321288, 2.321288),
        Joint(name[2], link[2], (0, sign * 0.095, -0.250), 0, Y, -2.75762, 0.0, 3.996804, elbow_speed),
        Joint(name[3], link[3], (-0.030, 0, 0), 0, Z, *swivel, 2.617994, 4.607669),
        Joint(name[4], link[4], (0, 0, -0.235), 0, Y, -1.745329, 1.745329, 4.363323, 3.909525),
        Joint(name[5], link[5], (wrist_offset, 0, -0.090), 0, X, -2.844887, 2.844887, 5.235988, 5.235988),
    )


BOXES: dict[str, tuple[tuple[Vector, Vector], ...]] = {
    "WAIST": (((-0.063, -0.0626, 0.0), (0.0629, 0.063, 0.2296)),),
    "CHEST_JOINT0_Link": (
        ((-0.1868, -0.105, 0.2296), (0.0849, 0.105, 0.5539)),
        ((-0.1868, -0.2226, 0.42), (0.0849, 0.2226, 0.5539)),
    ),
    "HEAD_JOINT1_Link": (((-0.14, -0.1091, -0.02), (0.0999, 0.1091, 0.1288)),),
    "LARM_JOINT0_Link": (((-0.0447, -0.0395, -0.0614), (0.042, 0.0543, 0.0946)),),
    "LARM_JOINT1_Link": (((-0.081, 0.04, -0.285), (0.0363, 0.1895, 0.036)),),
    "LARM_JOINT2_Link": (((-0.0689, -0.041, -0.153), (0.0349, 0.0838, 0.0347)),),
    "LARM_JOINT3_Link": (((-0.036, -0.0365, -0.2582), (0.0359, 0.063, -0.14)),),
    "LARM_JOINT4_Link": (((-0.041, -0.0265, -0.1162), (0.0335, 0.0713, 0.0244)),),
    "LARM_JOINT5_Link": (((-0.0387, -0.0428, -0.0526), (0.029, 0.0428, 0.022)),),
}
"""Smallest boxes around the visible links, in the links' frames [m].

The boxes are computed from [H-DAE], a source that this module lists. Only the left arm is listed, because the right arm
has the same boxes with mirrored y.

A box around the whole chest would have |y| up to 0.2226, because the chest includes the shoulders. The hanging arms
would intersect this box, because the first links of the arms begin at |y| = 0.105. Below the shoulders (z < 0.42), the
chest's box therefore ends at |y| = 0.105.
"""

BODIES: dict[str, Body] = {
    "WAIST": Body(3.11081, (-0.000388, 0.000002, 0.164660), (0.034732, 0.034748, 0.004382)),
    "CHEST_JOINT0_Link": Body(6.20761, (-0.004934, -0.000977, 0.344052), (0.063958, 0.031085, 0.050111)),
    "HEAD_JOINT0_Link": Body(0.317929, (-0.000023, 0.005478, -0.007840), (2.768e-4, 1.301e-4, 2.095e-4)),
    "HEAD_JOINT1_Link": Body(0.080859, (0.000005, -0.016678, 0.016315), (8.07e-5, 3.025e-5, 6.637e-5)),
    "LARM_JOINT0_Link": Body(1.32626, (-0.002264, -0.005214, 0.015608), (0.002075, 0.002403, 0.001419)),
    "LARM_JOINT1_Link": Body(1.14898, (-0.000052, 0.058313, -0.107061), (0.015417, 0.014712, 0.001266)),
    "LARM_JOINT2_Link": Body(0.577518, (-0.000023, 0.001671, -0.071512), (0.001440, 0.001418, 0.000197)),
    "LARM_JOINT3_Link": Body(0.457418, (-0.000018, -0.003958, -0.202731), (0.000692, 0.000689, 0.000135)),
    "LARM_JOINT4_Link": Body(0.418434, (0.002431, 0.003797, -0.057704), (0.000520, 0.000506, 0.000140)),
    "LARM_JOINT5_Link": Body(1.05156, (-0.048476, 0.0, -0.038899), (0.001941, 0.002094, 0.000358)),
}
"""Masses, centres of mass and inertias of the links.

For the right arm, y of the centre of mass is mirrored.
"""

START_DEGREES = {
    "initial": {"RARM": (-0.6, 0.0, -100.0, 15.2, 9.4, 3.2), "LARM": (0.6, 0.0, -100.0, -15.2, 9.4, -3.2)},
    "factory": {"RARM": (0.0, 0.0, -130.0, 0.0, 0.0, 0.0), "LARM": (0.0, 0.0, -130.0, 0.0, 0.0, 0.0)},
}
"""Joint angles of the two start poses [degrees], from [CLIENT], a source that this module lists.

- `initial` is _InitialPose, the pose to which goInitial() moves the robot. The tools are level above the table top,
  with the fingertips 0.025 m below WAIST.
- `factory` is _InitialPose_Factory, the pose to which goInitial(init_pose_type=1) moves the robot. The tools are high,
  for table tops that the arms would hit in the pose `initial`.
"""

PLANNED_SPEED = 1.0
"""Speed limit of MoveIt for every arm joint [rad/s].

The sources are hironx_moveit_config and nextage_moveit_config, joint_limits.yaml.
"""
PLANNED_ACCELERATION = 1.0
"""Acceleration limit of MoveIt for every arm joint [rad/s^2]. Kawada publishes no limit."""
NEXTAGE_PLANNED_ACCELERATION = 1.5
TABLE_HEIGHTS = (-0.20, 0.10)
"""Lowest and highest table top that both arms can use, in the frame of the body WAIST [m].

The range is computed from the joints of this module, with the tool within 3 degrees of vertical. At -0.10 m, both arms
reach x from 0.10 to 0.40 m and |y| up to 0.25 m. At -0.20 m, they reach half of these ranges.
"""
FRONT = 0.10
"""Smallest distance of a table from the robot's column, along x of the body WAIST [m]."""
