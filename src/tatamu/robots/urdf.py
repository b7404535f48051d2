"""The parts of URDF that MuJoCo does not read: the locations of mesh files, and the speed limits of joints.

MuJoCo reads everything else: links, joints, limits, shapes, and mimic joints as equalities.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from xml.etree import ElementTree

from tatamu.base.errors import InputError

XACRO = ("{http://www.ros.org/wiki/xacro}", "{http://ros.org/wiki/xacro}", "{http://wiki.ros.org/xacro}")


@dataclass(frozen=True)
class Urdf:
    """A URDF that is prepared for MuJoCo, with new names for its mesh files."""

    text: str
    speeds: dict[str, float]
    """Speed limits of the joints that state a limit [rad/s, m/s]."""


def read_urdf(path: Path, root: ElementTree.Element, keep: Callable[[str], str]) -> Urdf:
    """Prepare a URDF for MuJoCo. Visual shapes are removed, because distances are computed between collision shapes.

    Args:
        path: The file, for messages.
        root: Root element of the file. The function changes this element.
        keep: Function from the name of a mesh file in the URDF to its name for MuJoCo.

    Raises:
        InputError: If the file is xacro, or a field is wrong.
    """
    if any(element.tag.startswith(XACRO) for element in root.iter()):
        raise InputError(f"{path}: is xacro, from which URDF is made: run `xacro {path.name} > robot.urdf`")
    folder, strip = _meshes_of(root)
    for link in root.iter("link"):
        for visual in link.findall("visual"):
            link.remove(visual)
    for mesh in root.iter("mesh"):
        name = mesh.get("filename", "")
        if "://" not in name:
            name = str(PurePosixPath(folder) / (PurePosixPath(name).name if strip else name))
        mesh.set("filename", keep(name))
    return Urdf(ElementTree.tostring(root, encoding="unicode"), _speeds(path, root))


def _meshes_of(root: ElementTree.Element) -> tuple[str, bool]:
    """Return the folder to which mesh names are relative, and whether the paths in mesh names are ignored.

    Both follow from the element `mujoco`, MuJoCo's extension of URDF.
    """
    folder, strip = "", False
    for compiler in root.iterfind("mujoco/compiler"):
        folder = compiler.attrib.pop("meshdir", compiler.attrib.pop("assetdir", folder))
        strip = compiler.attrib.pop("strippath", "false") == "true"
    return folder, strip


def _speeds(path: Path, root: ElementTree.Element) -> dict[str, float]:
    """Return the speed limit of each joint by name. A limit of 0 counts as missing, because many exporters write 0."""
    found = {}
    for joint in root.iterfind("joint"):
        limit = joint.find("limit")
        text = None if limit is None else limit.get("velocity")
        if text is None:
            continue
        name = joint.get("name", "")
        try:
            speed = float(text)
        except ValueError:
            raise InputError(f"{path}: joint {name}: velocity must be a number, given {text[:40]!r}") from None
        if speed > 0:
            found[name] = speed
    return found
