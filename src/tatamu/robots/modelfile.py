"""A robot's URDF or MJCF file, read into memory as one independent model with every file that it names."""

from __future__ import annotations

import hashlib
import io
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from xml.etree import ElementTree

import numpy as np

from tatamu.base.errors import InputError
from tatamu.base.files import MIB, beside, foreign, read_bytes
from tatamu.robots.extras import needed, one_line
from tatamu.robots.urdf import TURN, JointLimits, located, read_urdf

MAX_FILE = 64 * MIB
"""Maximum size of a model file, and of each file that the model names [bytes]."""
MAX_DEPTH, MAX_ELEMENTS = 256, 20_000
"""Maximum depth and number of the elements in the XML of a model, with its included files and replicated elements."""
MAX_HEIGHTS = 4_000_000
"""Maximum number of heights in a height field."""


@dataclass(frozen=True)
class ModelFile:
    """A model that has been read."""

    spec: Any
    """The model, a mujoco.MjSpec. Its assets, such as meshes, are named by their content; `give` adds them to it."""
    limits: JointLimits
    mended: tuple[str, ...]
    """Names of links whose mass or inertia is impossible and was replaced."""
    contents: Mapping[str, bytes]
    """Content of each asset, such as a mesh, by the name of the asset."""
    files: tuple[Path, ...]
    """Every file that was read, the model first."""


def read_model(path: Path, packages: Mapping[str, Path]) -> ModelFile:
    """Read a URDF or an MJCF file.

    Args:
        path: The file.
        packages: Folders of ROS packages by name; see `located`.

    Raises:
        InputError: If the file or a file that it names cannot be read.
    """
    mujoco = needed("mujoco")
    root = _parsed(path)
    if root.tag not in ("robot", "mujoco"):
        raise InputError(f"{path}: must be a URDF (<robot>) or an MJCF (<mujoco>), given <{root.tag[:40]}>")
    store = _Store(path)
    removed: list[str] = []
    try:
        if root.tag == "robot":
            text, limits, removed = read_urdf(path, root, lambda name: store.mesh(located(name, path, packages)))
            spec = mujoco.MjSpec.from_string(text)
        else:
            store.files += _included(path, root)
            spec = _read_mjcf(path)
            _keep_assets(spec, path, store)
            limits = JointLimits({}, _commanded_limits(path, spec), None)
    except ValueError as error:
        raise InputError(f"{path}: must be a URDF or MJCF that MuJoCo can read ({one_line(error)})") from None
    spec.compiler.fusestatic = False
    spec.option.disableflags = spec.option.enableflags = 0  # a model may switch off contacts
    for part in (*spec.sensors, *spec.actuators, *spec.keys, *spec.skins):  # a plan needs none of these parts
        spec.delete(part)
    return ModelFile(
        spec=spec,
        limits=limits,
        mended=(*removed, *_mend_dynamics(spec)),
        contents=store.contents,
        files=tuple(dict.fromkeys(store.files)),
    )


def give(spec: Any, contents: Mapping[str, bytes], prefixes: tuple[str, ...] = ()) -> None:
    """Add the contents of assets, such as meshes, to a model.

    If the model was attached to another model, `prefixes` are removed from the asset names.
    """
    for asset in (*spec.meshes, *spec.hfields):
        for prefix in prefixes:
            asset.file = asset.file.removeprefix(prefix)
    spec.assets = dict(contents)


def read_stage(path: Path) -> Any:
    """Read the model of a plan's folder as a mujoco.MjSpec, without pictures and with limits of its size.

    Raises:
        InputError: If a height field is too large.
        ValueError: If MuJoCo cannot read the file.
    """
    store = _Store(path)
    store.files += _included(path, _parsed(path))
    spec = _read_mjcf(path)
    _keep_assets(spec, path, store)
    give(spec, store.contents)
    return spec


def _read_mjcf(path: Path) -> Any:
    """Read an MJCF file with MuJoCo, which takes a backslash in a path for a slash on every system.

    Raises:
        InputError: If the file's own name contains a backslash.
        ValueError: If MuJoCo cannot read the file.
    """
    if os.sep == "/" and "\\" in path.name:
        raise InputError(f"{path}: must have a name without a backslash; rename the file")
    read = needed("mujoco").MjSpec.from_file
    absolute = os.path.abspath(path)  # else, assets of an included file in another folder are not found
    if os.sep == "\\" or "\\" not in absolute:
        return read(absolute)
    with TemporaryDirectory() as place:
        plain = Path(place, "model")
        plain.symlink_to(os.path.dirname(absolute))
        return read(str(plain / path.name))


def drop_pictures(spec: Any) -> None:
    """Remove textures: distances need none, and a small picture may need gigabytes of memory."""
    for material in spec.materials:
        material.textures = [""] * len(material.textures)
    for texture in list(spec.textures):
        spec.delete(texture)


def limit_continuous(model: ModelFile, joints: Iterable[str]) -> list[str]:
    """Give each of these joints that has no limits a range of one turn to either side, and return their names."""
    mujoco, spec = needed("mujoco"), model.spec
    found = []
    for joint in filter(None, map(spec.joint, joints)):
        free = model.limits.continuous is None or joint.name in model.limits.continuous
        if free and joint.type == mujoco.mjtJoint.mjJNT_HINGE and not _is_limited(spec, joint):
            joint.limited = mujoco.mjtLimited.mjLIMITED_TRUE
            joint.range = [sign * TURN / _unit(spec, joint) for sign in (-1, 1)]
            found.append(joint.name)
    return found


def _commanded_limits(path: Path, spec: Any) -> dict[str, str]:
    """Narrow the ranges of joints to those of their position drives, and return the narrower ranges as text.

    Raises:
        InputError: If no position of a joint is within all ranges.
    """
    mujoco, found = needed("mujoco"), {}
    at_joint = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)  # the same for hinges and slides
    whole: dict[str, np.ndarray] = {}
    for drive in spec.actuators:
        joint = spec.joint(drive.target) if drive.trntype in at_joint else None
        is_position = drive.biastype == mujoco.mjtBias.mjBIAS_AFFINE and drive.biasprm[1] == -drive.gainprm[0] != 0
        if joint is None or not is_position or drive.gear[0] == 0:
            continue
        unit = _unit(spec, joint)
        hard = np.array(joint.range) * unit if _is_limited(spec, joint) else np.array([-np.inf, np.inf])
        if drive.dyntype == mujoco.mjtDyn.mjDYN_INTEGRATOR:  # commands are velocities
            given, limited = np.array(drive.actrange), drive.actlimited
        else:
            given, limited = np.array(drive.ctrlrange), drive.ctrllimited
        inherited = whole.setdefault(joint.name, hard)  # that of the joint, whatever other drives of it narrow
        if drive.inheritrange > 0 and np.isfinite(inherited).all():
            given = inherited.mean() + 0.5 * drive.inheritrange * np.array([-1.0, 1.0]) * np.ptp(inherited)
        if limited == mujoco.mjtLimited.mjLIMITED_FALSE or given[0] >= given[1]:
            continue
        low, high = np.sort(given / drive.gear[0])
        soft = np.array([max(low, hard[0]), min(high, hard[1])])
        if soft[0] >= soft[1]:
            ranges = f"given {hard[0]:g} to {hard[1]:g} for the joint and a drive from {low:g} to {high:g}"
            raise InputError(
                f"{path}: joint {joint.name}: the ranges of the joint and its drives must overlap, {ranges}"
            )
        if np.abs(soft - hard).max() > 1e-4:  # drives often repeat the range with fewer digits
            joint.limited, joint.range = mujoco.mjtLimited.mjLIMITED_TRUE, soft / unit
            found[joint.name] = f"{soft[0]:g} to {soft[1]:g}"
    return found


def _is_limited(spec: Any, joint: Any) -> bool:
    limited = needed("mujoco").mjtLimited
    if joint.limited == limited.mjLIMITED_AUTO:
        return bool(spec.compiler.autolimits and joint.range[0] != joint.range[1])
    return bool(joint.limited == limited.mjLIMITED_TRUE)


def _unit(spec: Any, joint: Any) -> float:
    """Return the factor that converts the range of a joint in the file to radians or metres."""
    degrees = spec.compiler.degree and joint.type == needed("mujoco").mjtJoint.mjJNT_HINGE
    return float(np.pi / 180) if degrees else 1.0


class _Store:
    """The assets of a model, such as meshes, named by their content."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self.files = [path]
        self.contents: dict[str, bytes] = {}

    def mesh(self, file: Path) -> str:
        """Read a mesh file, store it, and return the name that is made from its content."""
        suffix, converted = file.suffix.lower(), (".ply", ".off")
        formats = (".stl", ".obj", ".msh", *converted)
        if suffix not in formats:
            raise InputError(
                f"{self._path}: mesh {file}: must be a file of type {', '.join(formats)}; convert the mesh without "
                "changing its scale"
            )
        content = self._read(file)
        # MuJoCo reads neither PLY nor OFF, and of the two .stl formats only the binary one.
        if suffix in converted or (suffix == ".stl" and _is_ascii(content)):
            import trimesh  # this import takes a third of a second

            with foreign(file, "a mesh that tatamu can read"):
                mesh = trimesh.load_mesh(io.BytesIO(content), file_type=suffix[1:], process=False)
                content, suffix = trimesh.exchange.stl.export_stl(mesh), ".stl"
        return self._store(content, suffix)

    def heights(self, file: Path) -> str:
        """Read the file of a height field, store it, and return the name that is made from its content."""
        content = self._read(file)
        if content[:4] == b"\x89PNG":
            _check_heights(file, int.from_bytes(content[16:20], "big"), int.from_bytes(content[20:24], "big"))
        return self._store(content, file.suffix.lower())

    def _store(self, content: bytes, suffix: str) -> str:
        name = hashlib.sha256(content).hexdigest()[:16] + suffix
        self.contents[name] = content
        return name

    def _read(self, file: Path) -> bytes:
        file = Path(os.path.normpath(file))
        if not file.is_file():
            raise InputError(f"{self._path}: must name existing files, given {file}")
        content = read_bytes(file, MAX_FILE)
        self.files.append(file)
        return content


def _check_heights(file: Path, rows: float, columns: float) -> None:
    if not rows * columns <= MAX_HEIGHTS:
        raise InputError(
            f"{file}: height field: must have at most {MAX_HEIGHTS} heights, given {rows:.0f} x {columns:.0f}"
        )


def _is_ascii(content: bytes) -> bool:
    """Return whether an STL file is text. The length of a binary file follows from its number of triangles."""
    count = int.from_bytes(content[80:84], "little")
    return content.lstrip()[:5] == b"solid" and len(content) != 84 + 50 * count


def _keep_assets(spec: Any, path: Path, store: _Store) -> None:
    """Store the asset files that an MJCF file names, and replace their names by the names in the store."""
    drop_pictures(spec)
    for assets, keep in ((spec.meshes, store.mesh), (spec.hfields, store.heights)):
        for asset in assets:
            if asset.file:
                file = Path(asset.file)
                stripped = spec.strippath and not file.is_absolute()
                asset.file = keep(beside(path, str(Path(spec.meshdir, file.name if stripped else file))))
    spec.meshdir = spec.texturedir = ""


def _mend_dynamics(spec: Any) -> list[str]:
    """Replace impossible masses and inertias, and return the names of their links. Plans of motions need neither."""
    found = []
    for body in spec.bodies[1:]:
        if body.explicitinertial:
            full = np.array(body.fullinertia)
            (xx, yy, zz, xy, xz, yz) = full if np.isfinite(full[0]) else (*body.inertia, 0.0, 0.0, 0.0)
            tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
            moments = np.linalg.eigvalsh(tensor if np.isfinite(tensor).all() else np.zeros((3, 3)))
            possible = body.mass > 0 and moments[0] > 0 and moments[0] + moments[1] >= moments[2] * (1 - 1e-9)
        else:
            moments, possible = np.zeros(3), bool(body.geoms or not body.joints)
        if not possible:
            body.mass = body.mass if body.mass > 0 else 1e-3  # small values [kg, kg m^2], without a better guess
            body.fullinertia = [np.nan, 0, 0, 0, 0, 0]
            body.inertia = [max(float(np.abs(moments).mean()), 1e-6)] * 3
            body.explicitinertial = True
            found.append(body.name)
    return found


def _parsed(path: Path) -> ElementTree.Element:
    """Return the root element of an XML file, unless its elements are nested too deep or too many."""
    depth = count = 0
    try:
        events = ElementTree.iterparse(io.BytesIO(read_bytes(path, MAX_FILE)), ("start", "end"))
        for event, element in events:
            if event == "end":
                depth, root = depth - 1, element  # the root is the last to end
                continue
            depth, count = depth + 1, count + 1
            if depth > MAX_DEPTH:
                raise ValueError(f"elements are nested more than {MAX_DEPTH} deep")
            if count > MAX_ELEMENTS:
                raise ValueError(f"there are more than {MAX_ELEMENTS} elements")
        if _replicated(root) > MAX_ELEMENTS:
            raise ValueError(f"there are more than {MAX_ELEMENTS} elements")
        for field in root.iter("hfield"):  # MuJoCo takes 15 s for 100,000 x 100,000 heights
            _check_heights(path, *(float(field.get(side, "0")) for side in ("nrow", "ncol")))
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise InputError(f"{path}: cannot be read as URDF or MJCF ({error})") from None
    return root


def _replicated(element: ElementTree.Element) -> int:
    """Return the number of elements after MuJoCo has copied those that `count` repeats."""
    counts = [int(number) for number in element.get("count", "1").split() if number.isdigit()]
    return int(np.prod(counts or [1], dtype=float)) * (1 + sum(map(_replicated, element)))


def _included(path: Path, root: ElementTree.Element) -> list[Path]:
    """Return the files that an MJCF file includes or attaches, directly or through other files."""
    found: list[Path] = []
    todo = [(path, root)]
    while todo:
        here, element = todo.pop()
        for include in (*element.iter("include"), *element.iter("model")):
            for folder in dict.fromkeys((path.parent, here.parent)):
                file = folder / include.get("file", "").replace("\\", "/")  # as MuJoCo reads it
                if file.is_file() and file not in found:  # MuJoCo reports a missing file
                    found.append(file)
                    todo.append((file, _parsed(file)))
    return found
