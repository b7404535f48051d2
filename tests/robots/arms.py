"""A plain six-axis arm as URDF and as MJCF, and the description that makes a pair of two."""

from __future__ import annotations

from pathlib import Path

JOINTS = (
    # name, axis, height above the joint before [m], limits [rad]
    ("pan", (0, 0, 1), 0.15, 2.9),
    ("lift", (0, 1, 0), 0.15, 2.2),
    ("elbow", (0, 1, 0), 0.35, 2.7),
    ("roll", (0, 0, 1), 0.20, 2.9),
    ("bend", (0, 1, 0), 0.15, 2.2),
    ("turn", (0, 0, 1), 0.08, 2.9),
)


def urdf() -> str:
    """The arm as URDF."""
    parts = ['<robot name="arm"><link name="foot"/>']
    parent = "foot"
    for name, axis, height, limit in JOINTS:
        x, y, z = axis
        parts.append(
            f'<link name="{name}_link"><inertial><mass value="1"/>'
            '<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>'
            '<collision><origin xyz="0 0 0.03"/><geometry><box size="0.06 0.06 0.05"/></geometry></collision></link>'
            f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{name}_link"/>'
            f'<origin xyz="0 0 {height}"/><axis xyz="{x} {y} {z}"/>'
            f'<limit lower="-{limit}" upper="{limit}" velocity="2" effort="50"/></joint>'
        )
        parent = f"{name}_link"
    return "".join(parts) + "</robot>"


def mjcf() -> str:
    """The same arm as MJCF."""
    opened = '<mujoco model="arm"><compiler angle="radian"/><worldbody><body name="foot">'
    for name, axis, height, limit in JOINTS:
        opened += (
            f'<body name="{name}_link" pos="0 0 {height}">'
            f'<joint name="{name}" axis="{axis[0]} {axis[1]} {axis[2]}" range="-{limit} {limit}"/>'
            '<inertial pos="0 0 0" mass="1" diaginertia="0.01 0.01 0.01"/>'
            '<geom type="box" size="0.03 0.03 0.025" pos="0 0 0.03"/>'
        )
    return opened + "</body>" * 7 + "</worldbody></mujoco>"


ARM = """
[{side}]
model = "{model}"
mount = {{ xyz = [0.0, {y}, 0.0] }}
joints = ["pan", "lift", "elbow", "roll", "bend", "turn"]
link = "turn_link"
tool = {{ xyz = [0.0, 0.0, 0.14] }}
initial = [0.0, -0.2, 1.9, 0.0, 1.4415926, 0.0]
speed = [2.0, 2.0, 2.0, 2.0, 2.0, 2.0]
acceleration = [3.0, 3.0, 3.0, 3.0, 3.0, 3.0]
"""


def pair(folder: Path) -> Path:
    """A description of two arms, the left one read from URDF, the right one from MJCF."""
    (folder / "arm.urdf").write_text(urdf())
    (folder / "arm.xml").write_text(mjcf())
    text = 'name = "pair"\nfront = 0.15\n'
    text += ARM.format(side="larm", model="arm.urdf", y=0.25) + ARM.format(side="rarm", model="arm.xml", y=-0.25)
    (folder / "pair.toml").write_text(text)
    return folder / "pair.toml"
