"""The parts of URDF that MuJoCo does not read: places of mesh files, speed limits, soft limits, continuous joints.

MuJoCo reads everything else: links, joints, limits, shapes, and mimic joints as equalities.
"""

from __future__ import annotations

import glob
import math
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from urllib.parse import unquote
from xml.etree import ElementTree

from tatamu.base.errors import InputError
from tatamu.base.files import beside

TURN = 2 * math.pi
"""Angle by which plans turn a continuous joint to either side [rad]."""
XACRO = ("{http://www.ros.org/wiki/xacro}", "{http://ros.org/wiki/xacro}", "{http://wiki.ros.org/xacro}")


@dataclass(frozen=True)
class JointLimits:
    """What a model states about the limits of its joints besides their ranges."""

    speeds: Mapping[str, float]
    """Speed limits of the joints that state a limit [rad/s, m/s]."""
    soft: Mapping[str, str]
    """Soft limits that are narrower than the hard limits, as text, by the name of the joint."""
    continuous: frozenset[str] | None
    """Names of the joints without limits that may turn freely; None if any joint without limits may."""


def read_urdf(path: Path, root: ElementTree.Element, keep: Callable[[str], str]) -> tuple[str, JointLimits, list[str]]:
    """Prepare a URDF for MuJoCo. Visual shapes are removed, because distances are computed between collision shapes.

    Args:
        path: The file, for messages.
        root: Root element of the file. The function changes this element.
        keep: Function from the name of a mesh file in the URDF to its name for MuJoCo.

    Returns:
        The URDF with new names for its mesh files and the stricter limits of its joints; the limits; and the names of
        links whose mass or inertia was removed because it lacks numbers.

    Raises:
        InputError: If the file is xacro, or a field is wrong.
    """
    if any(element.tag.startswith(XACRO) for element in root.iter()):
        raise InputError(f"{path}: must be a URDF, given xacro; run `xacro {path.name} > robot.urdf`")
    if root.find("link") is None:
        raise InputError(
            f"{path}: must have a link, given none; if the URDF was made from a xacro file that only defines macros, "
            "run xacro on the robot's main file instead"
        )
    folder, strip = "", False  # to which mesh names are relative, and whether the paths in them are ignored
    for compiler in root.iterfind("mujoco/compiler"):
        folder = compiler.attrib.pop("meshdir", compiler.attrib.pop("assetdir", folder))
        strip = compiler.attrib.pop("strippath", "false") == "true"
    for link in root.iter("link"):
        for visual in link.findall("visual"):
            link.remove(visual)
    for material in root.findall("material"):
        root.remove(material)
    for mesh in root.iter("mesh"):
        name = mesh.get("filename", "")
        if "://" not in name:
            name = str(PurePosixPath(folder) / (PurePosixPath(name.replace("\\", "/")).name if strip else name))
        mesh.set("filename", keep(name))
    removed = [link.get("name", "") for link in root.findall("link") if _remove_unreadable_inertia(link)]
    soft = {joint.get("name", ""): text for joint in root.findall("joint") if (text := _limit(path, joint))}
    free = frozenset(joint.get("name", "") for joint in root.findall("joint") if joint.get("type") == "continuous")
    speeds = {
        joint.get("name", ""): speed
        for joint in root.iterfind("joint")
        if (speed := _number(path, joint, joint.find("limit"), "velocity") or 0.0) > 0  # many exporters write 0
    }
    return ElementTree.tostring(root, encoding="unicode"), JointLimits(speeds, soft, free), removed


def located(uri: str, urdf: Path, packages: Mapping[str, Path]) -> Path:
    """Find the file of a URI in a URDF: `package://`, `file://`, or a path relative to the URDF.

    Packages are searched in this order: the table in the robot's description, the folders above the URDF, the paths of
    ROS.

    Args:
        uri: The URI as the URDF contains it.
        urdf: The URDF file.
        packages: Folders of packages by name.

    Raises:
        InputError: If no folder of the package contains the file.
    """
    scheme, _, rest = uri.partition("://")
    if scheme == "file" and rest:
        return Path(rest if os.path.exists(rest) else unquote(rest))
    if scheme not in ("package", "model") or not rest:
        return beside(urdf, uri)
    tried = []
    for spelling in dict.fromkeys((rest, unquote(rest), rest.replace("\\", "/"))):  # any may be meant
        name, _, path = spelling.partition("/")
        for folder in _folders(name, urdf, packages):
            if (folder / path).is_file():
                return folder / path
            if folder.is_dir():
                tried.append(folder / path)
    if tried:
        raise InputError(f"{urdf}: {uri}: must be an existing file, given {tried[0]}")
    raise InputError(
        f"{urdf}: {uri}: there is no folder {name} above this file or in ROS_PACKAGE_PATH; "
        f'write packages = {{ {name} = "FOLDER" }} in the description, before its first table'
    )


def _folders(name: str, urdf: Path, packages: Mapping[str, Path]) -> Iterator[Path]:
    """Yield the folders that may be the package, the most likely folder first."""
    if name in packages:
        yield packages[name]
    for above in Path(os.path.abspath(urdf)).parents:
        if above.name == name:
            yield above
        yield above / name
    for root in _paths("ROS_PACKAGE_PATH"):
        if root.name == name:
            yield root
        for depth in range(3):
            yield from sorted(root.glob("*/" * depth + glob.escape(name)))
    for root in _paths("AMENT_PREFIX_PATH"):
        yield root / "share" / name


def _paths(variable: str) -> list[Path]:
    return [Path(part) for part in os.environ.get(variable, "").split(os.pathsep) if part]


def _remove_unreadable_inertia(link: ElementTree.Element) -> bool:
    """Remove the inertia of a link if a number is missing or is no number, and return whether this was so."""
    inertial = link.find("inertial")
    if inertial is None:
        return False
    mass, inertia = inertial.find("mass"), inertial.find("inertia")
    texts = [None if mass is None else mass.get("value")]
    texts += [None if inertia is None else inertia.get(name) for name in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")]
    try:
        readable = all(text is not None and math.isfinite(float(text)) for text in texts)
    except ValueError:
        readable = False
    if not readable:
        link.remove(inertial)
    return not readable


def _limit(path: Path, joint: ElementTree.Element) -> str:
    """Give a joint the stricter of its hard and soft limits, and return them as text if a soft limit is stricter."""
    kind = joint.get("type")
    if kind not in ("revolute", "continuous", "prismatic"):
        return ""
    limit = joint.find("limit")
    hard = [_number(path, joint, limit, name) for name in ("lower", "upper")]
    if kind != "continuous":  # by the standard of URDF, a missing hard limit of these joints is 0
        hard = [0.0 if value is None else value for value in hard]
    elif hard[0] == hard[1]:
        hard = [None, None]  # many exporters write 0 and 0 for a joint without limits
    elif None in hard:  # the other limit is one turn away from 0, as for a joint without limits
        hard = [one_turn if value is None else value for value, one_turn in zip(hard, (-TURN, TURN), strict=True)]
    soft = [
        [_number(path, joint, each, f"soft_{name}_limit") for each in joint.findall("safety_controller")]
        for name in ("lower", "upper")
    ]
    low = max((value for value in (hard[0], *soft[0]) if value is not None), default=None)
    high = min((value for value in (hard[1], *soft[1]) if value is not None), default=None)
    narrower = [low, high] != hard
    if low is None and high is None:
        return ""
    low, high = -TURN if low is None else low, TURN if high is None else high
    if kind == "continuous" and not narrower and low >= high:
        raise InputError(
            f"{path}: joint {joint.get('name')}: the lower limit must be below the upper limit, and both must be "
            f"within ±{TURN:.2f} rad, given {low:g} and {high:g}"
        )
    if narrower and low >= high:
        raise InputError(
            f"{path}: joint {joint.get('name')}: the soft limits must overlap the hard limits, but one lower limit is "
            f"{low:g} and one upper limit is {high:g}; correct or remove safety_controller"
        )
    if limit is None:
        limit = ElementTree.SubElement(joint, "limit", effort="0", velocity="0")
    limit.set("lower", repr(low))
    limit.set("upper", repr(high))
    joint.set("type", "revolute" if kind == "continuous" else kind)
    return f"{low:g} to {high:g}" if narrower else ""


def _number(path: Path, joint: ElementTree.Element, element: ElementTree.Element | None, name: str) -> float | None:
    """Return an attribute of a joint's limits; None if it is missing or infinite."""
    text = None if element is None else element.get(name)
    if text is None:
        return None
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if math.isnan(value):
        raise InputError(f"{path}: joint {joint.get('name', '')}: {name} must be a number, given {text[:40]!r}")
    return None if math.isinf(value) else value
