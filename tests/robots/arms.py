"""A plain six-axis arm as URDF and as MJCF, and the description that makes a pair of two."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

JOINTS = (
    # name, axis, height above the joint before [m], limits [rad]
    ("pan", (0, 0, 1), 0.15, 2.9),
    ("lift", (0, 1, 0), 0.15, 2.2),
    ("elbow", (0, 1, 0), 0.35, 2.7),
    ("roll", (0, 0, 1), 0.20, 2.9),
    ("bend", (0, 1, 0), 0.15, 2.2),
    ("turn", (0, 0, 1), 0.08, 2.9),
)


BOX = '<box size="0.06 0.06 0.05"/>'


def urdf(shape: str = BOX, more: str = "") -> str:
    """The arm as URDF, its links of one shape, with more elements at the end."""
    parts = ['<robot name="arm"><link name="foot"/>']
    parent = "foot"
    for name, axis, height, limit in JOINTS:
        x, y, z = axis
        parts.append(
            f'<link name="{name}_link"><inertial><mass value="1"/>'
            '<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>'
            f'<collision><origin xyz="0 0 0.03"/><geometry>{shape}</geometry></collision></link>'
            f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{name}_link"/>'
            f'<origin xyz="0 0 {height}"/><axis xyz="{x} {y} {z}"/>'
            f'<limit lower="-{limit}" upper="{limit}" velocity="2" effort="50"/></joint>'
        )
        parent = f"{name}_link"
    return "".join(parts) + more + "</robot>"


def mjcf(world: str = "", more: str = "", hand: str = "", refs: Mapping[str, float] = MappingProxyType({})) -> str:
    """The same arm as MJCF.

    Args:
        world: More elements of the world.
        more: More elements of the model.
        hand: More elements of the last link.
        refs: What joints are said to stand at where the model draws them [rad].
    """
    opened = f'<mujoco model="arm"><compiler angle="radian"/>{more}<worldbody>{world}<body name="foot">'
    for name, axis, height, limit in JOINTS:
        ref = refs.get(name, 0.0)
        opened += (
            f'<body name="{name}_link" pos="0 0 {height}">'
            f'<joint name="{name}" axis="{axis[0]} {axis[1]} {axis[2]}" '
            f'range="{ref - limit} {ref + limit}" ref="{ref}"/>'
            '<inertial pos="0 0 0" mass="1" diaginertia="0.01 0.01 0.01"/>'
            '<geom type="box" size="0.03 0.03 0.025" pos="0 0 0.03"/>'
        )
    return opened + hand + "</body>" * 7 + "</worldbody></mujoco>"


FINGER = (
    '<body name="{name}" pos="0 0 0.06"><joint name="{name}" type="slide" axis="{axis}" range="{range}"/>'
    '<inertial pos="0 0 0" mass="0.1" diaginertia="0.001 0.001 0.001"/>'
    '<geom type="box" size="0.005 0.005 0.02" pos="0 0 0.02"/></body>'
)


def finger(name: str, bounds: str, axis: str = "0 1 0") -> str:
    """A finger that slides, an element of the last link."""
    return FINGER.format(name=name, range=bounds, axis=axis)


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


def pair_of(folder: Path, left: str, right: str | None = None, top: str = "", arm: str = "") -> Path:
    """A description of two arms of models in a folder, with more fields before the first table and in each arm's."""
    text = f'name = "pair"\nfront = 0.15\n{top}\n'
    for side, model, y in (("larm", left, 0.25), ("rarm", right or left, -0.25)):
        text += ARM.format(side=side, model=model, y=y) + arm + "\n"
    (folder / "pair.toml").write_text(text)
    return folder / "pair.toml"


def pair_of_urdf(folder: Path, text: str, **fields: str) -> Path:
    """A description of two arms of one URDF."""
    (folder / "arm.urdf").write_text(text)
    return pair_of(folder, "arm.urdf", **fields)


def pair_of_mjcf(folder: Path, text: str, **fields: str) -> Path:
    """A description of two arms of one MJCF."""
    (folder / "arm.xml").write_text(text)
    return pair_of(folder, "arm.xml", **fields)


def pair(folder: Path) -> Path:
    """A description of two arms, the left one read from URDF, the right one from MJCF."""
    (folder / "arm.urdf").write_text(urdf())
    (folder / "arm.xml").write_text(mjcf())
    return pair_of(folder, "arm.urdf", "arm.xml")
