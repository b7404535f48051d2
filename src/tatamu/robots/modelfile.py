"""A robot's URDF or MJCF file, read into memory as one independent model with every file that it names."""

from __future__ import annotations

import hashlib
import io
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import trimesh

from tatamu.base.errors import InputError
from tatamu.base.files import MIB, foreign, read_bytes
from tatamu.robots.extras import needed, one_line
from tatamu.robots.packages import located
from tatamu.robots.urdf import read_urdf

MESHES = (".stl", ".obj", ".msh")
"""Formats of meshes that MuJoCo reads. Of the two .stl formats, MuJoCo reads only the binary format."""
CONVERTED = (".ply", ".off")
"""Formats of meshes that are converted to binary STL. ASCII STL is converted too.

The lengths in these files have no unit.
"""
LARGEST_FILE = 64 * MIB
"""Largest size of a model file, and of each file that the model names [bytes]."""


@dataclass(frozen=True)
class ModelFile:
    """A model that has been read."""

    spec: Any
    """The model, a mujoco.MjSpec.

    Its assets, such as meshes, are named by their content. `give` adds the assets to this model, or to a model that
    contains this model.
    """
    speeds: Mapping[str, float]
    """Speed limits of the joints that state a limit [rad/s, m/s]."""
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
    root = _root(path)
    store = _Store(path)
    try:
        if root.tag == "robot":
            urdf = read_urdf(path, root, lambda name: store.mesh(located(name, path, packages)))
            spec, speeds = mujoco.MjSpec.from_string(urdf.text), urdf.speeds
        else:
            store.files += _included(path, root)
            spec, speeds = mujoco.MjSpec.from_file(str(path)), {}
            _keep_assets(spec, path, store)
    except ValueError as error:
        raise InputError(f"{path}: is no URDF or MJCF that MuJoCo reads ({one_line(error)})") from None
    spec.compiler.fusestatic = False
    spec.option.disableflags = spec.option.enableflags = 0  # a model may switch off contacts
    for part in (*spec.sensors, *spec.actuators, *spec.keys, *spec.skins):  # a plan needs none of these parts
        spec.delete(part)
    return ModelFile(spec, speeds, store.contents, tuple(dict.fromkeys(store.files)))


def give(spec: Any, contents: Mapping[str, bytes], prefixes: tuple[str, ...] = ()) -> None:
    """Add the contents of assets, such as meshes, to a model.

    If the model was attached to another model, `prefixes` are removed from the asset names.
    """
    for asset in (*spec.meshes, *spec.hfields, *spec.textures):
        for prefix in prefixes:
            asset.file = asset.file.removeprefix(prefix)
    spec.assets = dict(contents)


class _Store:
    """The assets of a model, such as meshes, named by their content.

    Files of the same name do not collide, and equal files are stored only once.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self.files = [path]
        self.contents: dict[str, bytes] = {}

    def mesh(self, file: Path) -> str:
        """Read a mesh file, store it, and return the name that is made from its content."""
        suffix = file.suffix.lower()
        if suffix not in (*MESHES, *CONVERTED):
            formats = ", ".join((*MESHES, *CONVERTED))
            raise InputError(
                f"{self._path}: mesh {file}: must be one of {formats}; convert it, its lengths as they are"
            )
        content = self._read(file)
        if suffix in CONVERTED or (suffix == ".stl" and _is_ascii(content)):
            content, suffix = _as_stl(file, content, suffix), ".stl"
        return self._store(content, suffix)

    def keep(self, file: Path) -> str:
        """Read any file, store it, and return the name that is made from its content."""
        return self._store(self._read(file), file.suffix.lower())

    def _store(self, content: bytes, suffix: str) -> str:
        name = hashlib.sha256(content).hexdigest()[:16] + suffix
        self.contents[name] = content
        return name

    def _read(self, file: Path) -> bytes:
        file = Path(os.path.normpath(file))
        if not file.is_file():
            raise InputError(f"{self._path}: there is no file {file}")
        content = read_bytes(file, LARGEST_FILE)
        self.files.append(file)
        return content


def _is_ascii(content: bytes) -> bool:
    """Return whether an STL file is text.

    The length of a binary STL file follows from its number of triangles.
    """
    count = int.from_bytes(content[80:84], "little")
    return content.lstrip()[:5] == b"solid" and len(content) != 84 + 50 * count


def _as_stl(file: Path, content: bytes, suffix: str) -> bytes:
    with foreign(file, "a mesh that can be read"):
        mesh = trimesh.load_mesh(io.BytesIO(content), file_type=suffix[1:], process=False)
        return trimesh.exchange.stl.export_stl(mesh)


def _keep_assets(spec: Any, path: Path, store: _Store) -> None:
    """Store the asset files that an MJCF file names, and replace their names by the names in the store."""
    meshes = spec.meshes
    for assets, place in (
        (meshes, spec.meshdir),
        (spec.hfields, spec.meshdir),
        (spec.textures, spec.texturedir),
    ):
        for asset in assets:
            if asset.file:
                file = Path(asset.file)
                place_of = path.parent / place / (file.name if spec.strippath else file)
                asset.file = store.mesh(place_of) if assets is meshes else store.keep(place_of)
    for texture in spec.textures:
        if any(texture.cubefiles):
            texture.cubefiles = [
                store.keep(path.parent / spec.texturedir / name) if name else "" for name in texture.cubefiles
            ]
    spec.meshdir = spec.texturedir = ""


def _root(path: Path) -> ElementTree.Element:
    """Return the root element of a URDF or MJCF file."""
    if not path.is_file():
        raise InputError(f"{path}: there is no such file")
    root = _parsed(path)
    if root.tag not in ("robot", "mujoco"):
        raise InputError(f"{path}: must be a URDF (<robot>) or an MJCF (<mujoco>), given <{root.tag[:40]}>")
    return root


def _parsed(path: Path) -> ElementTree.Element:
    try:
        return ElementTree.fromstring(read_bytes(path, LARGEST_FILE))
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise InputError(f"{path}: is no URDF or MJCF, as it is not XML ({error})") from None


def _included(path: Path, root: ElementTree.Element) -> list[Path]:
    """Return the files that an MJCF file includes, directly or through other files."""
    found: list[Path] = []
    todo = [root]
    while todo:
        for include in todo.pop().iter("include"):
            file = path.parent / include.get("file", "")
            if file.is_file() and file not in found:  # MuJoCo reports a missing file
                found.append(file)
                todo.append(_parsed(file))
    return found
