"""Reads a garment from a user's file: an outline, a mesh, or a TOML file that names one."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from tatamu.base.errors import InputError, one_line
from tatamu.base.files import beside, read_toml, validated
from tatamu.garments.description import MAX_SCALE, GarmentFile
from tatamu.garments.garment import Garment
from tatamu.garments.meshfile import READERS as MESHES
from tatamu.garments.pattern import READERS, from_outline
from tatamu.garments.worn import from_mesh
from tatamu.simulation.material import Material
from tatamu.simulation.presets import load_preset

SUFFIXES = (".toml", *READERS, *MESHES)
"""File name endings of files that describe a garment."""
FABRIC = "jersey"
"""Name of the material preset of a garment whose file names no fabric."""


def load_garment(
    path: Path,
    size: tuple[float, float] | None = None,
    material: Material | None = None,
    spacing: float | None = None,
    scale: float | None = None,
) -> Garment:
    """Read the garment of a file; arguments override the fields of the file."""
    given, fabric = _read(path)
    material = material or fabric
    if scale is not None and not 0.0 < scale <= MAX_SCALE:
        raise InputError(f"scale: must be above 0 and at most {MAX_SCALE:g} metres per unit, given {scale:g}")
    asked = {"size": size, "spacing": spacing, "scale": scale}
    given = given.model_copy(update={key: value for key, value in asked.items() if value is not None})
    source = _source(path, given)
    try:
        made = (from_outline if given.outline else from_mesh)(given, source, material)
        return replace(made, own=True, kind=given.kind or "")
    except InputError as error:
        text = str(error)
        raise InputError(text if text.startswith(one_line(f"{source}:")) else f"{source}: {text}") from None


def files_of(path: Path) -> list[Path]:
    """Return the given file and, if it is a TOML file, its outline or mesh."""
    source = _source(path, _read(path)[0])
    return [path] if path.suffix.lower() != ".toml" else [path, source]


def _source(path: Path, given: GarmentFile) -> Path:
    """Return the path of a garment's outline or mesh."""
    return beside(path, str(given.outline or given.mesh))


def _read(path: Path) -> tuple[GarmentFile, Material]:
    """Return the description and the fabric of a garment; an outline or a mesh alone gets the default description."""
    kind = path.suffix.lower()
    if kind != ".toml":
        given = GarmentFile(name=path.stem[:60], **{"outline" if kind in READERS else "mesh": path.name})
        return given, load_preset(FABRIC).material
    value: dict[str, Any] = read_toml(path)
    unknown = sorted(set(value) - {"garment", "material"})
    if unknown or not isinstance(value.get("garment"), dict):
        wrong = (
            f"must contain only the tables [garment] and [material], given {unknown[0]}"
            if unknown
            else "Field required, a table"
        )
        raise InputError(f"{path}: garment: {wrong}")
    given = validated(GarmentFile, {"name": path.stem[:60], **value["garment"]}, path)
    if "material" in value:
        return given, validated(Material, value["material"], path)
    return given, load_preset(given.fabric or FABRIC).material
