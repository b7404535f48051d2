"""Finds the files that a URDF names by `package://NAME/PATH`, in the folders of ROS and in folders above the URDF."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from urllib.parse import unquote

from tatamu.base.errors import InputError

DEPTH = 3
"""Number of folder levels below the folders of ROS_PACKAGE_PATH in which a package is searched."""


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
        return Path(unquote(rest))
    if scheme not in ("package", "model") or not rest:
        return urdf.parent / uri
    name, _, path = unquote(rest).partition("/")
    tried = [folder for folder in _folders(name, urdf, packages) if folder.is_dir()]
    for folder in tried:
        if (folder / path).is_file():
            return folder / path
    if tried:
        raise InputError(f"{urdf}: {uri}: there is no file {tried[0] / path}")
    raise InputError(
        f"{urdf}: {uri}: no folder {name} stands above this file or in ROS_PACKAGE_PATH; "
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
        for depth in range(DEPTH):
            yield from sorted(root.glob("*/" * depth + name)) if "*" not in name else ()
    for root in _paths("AMENT_PREFIX_PATH"):
        yield root / "share" / name


def _paths(variable: str) -> list[Path]:
    return [Path(part) for part in os.environ.get(variable, "").split(os.pathsep) if part]
