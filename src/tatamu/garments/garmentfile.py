"""A garment of your own: a TOML file that names an outline or a mesh, or that outline or mesh alone."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from tatamu.errors import InputError
from tatamu.files import read_toml, validated
from tatamu.garments.cut import cut
from tatamu.garments.drawing import read_drawing
from tatamu.garments.flat import flat_garment, meshed_anew
from tatamu.garments.frame import FLAT, turned
from tatamu.garments.garment import Garment
from tatamu.garments.laying import laid_flat
from tatamu.garments.meshfile import FORMATS, faults, read_mesh, welded
from tatamu.garments.resolution import LARGEST_SIDE, PASSABLE, SMALLEST_SIDE
from tatamu.garments.sewing import front_and_back, one_layer
from tatamu.material import Material, preset_names
from tatamu.presets import load_preset

OUTLINES = (".svg", ".dxf")
SUFFIXES = (".toml", *OUTLINES, *FORMATS)
"""Kinds of garment files."""
FABRIC = "jersey"
"""The preset that it is of unless it says otherwise."""
Position = tuple[float, float]
Side = Annotated[float, Field(ge=SMALLEST_SIDE, le=LARGEST_SIDE)]


class GarmentFile(BaseModel):
    """The table `[garment]` of a garment file. See docs/reference/garment-file.md."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    name: str = Field("", max_length=60)
    """Its name; default: that of the file."""
    outline: str | None = None
    """An SVG or DXF file beside this one."""
    mesh: str | None = None
    """An OBJ, PLY, STL or GLB file beside this one."""
    scale: float | None = Field(None, gt=0.0, le=1e3)
    """Metres per unit of that file; default: 0.001 for outlines, which are in millimetres, 1 for meshes."""
    up: Literal["y", "-y", "x", "-x"] = "y"
    """Which direction of that file points away from the hem."""
    layers: Literal[1, 2] | None = None
    """Of an outline: cut once, or twice and sewn; default: 2 if it has openings."""
    openings: list[str] | dict[str, Annotated[list[Position], Field(min_length=2)]] | None = None
    """Of an outline: names of open curves in the file, or curves in its units by name; default: its open curves."""
    size: tuple[Side, Side] | None = None
    """Width and length that it is scaled to [m]."""
    spacing: float | None = Field(None, gt=0.0)
    """Edge length of the mesh [m]."""
    fabric: str | None = None
    """Name of a preset; instead there may be a table [material]."""
    weld: bool = False
    """Join vertices at one place."""
    remesh: bool = False
    """Mesh a flat mesh again within its outline."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if (self.outline is None) == (self.mesh is None):
            raise ValueError("must have either outline or mesh, a file name")
        if self.fabric is not None and self.fabric not in preset_names():
            raise ValueError(f"fabric must be one of {', '.join(preset_names())}, given {self.fabric!r}")
        if self.mesh is not None and (self.layers, self.openings) != (None, None):
            raise ValueError("layers and openings belong to an outline; those of a mesh are in the mesh")
        if self.outline is not None and (self.weld or self.remesh):
            raise ValueError("weld and remesh belong to a mesh")
        return self


def load_garment(
    path: Path,
    size: tuple[float, float] | None = None,
    material: Material | None = None,
    spacing: float | None = None,
) -> Garment:
    """The garment of a file; what is given here goes before what the file says.

    Raises:
        InputError: The file or one that it names cannot be read, or no garment can be made of it; the message says why.
    """
    given, fabric = _read(path)
    material = material or fabric
    asked = {"size": size, "spacing": spacing}
    given = given.model_copy(update={key: value for key, value in asked.items() if value is not None})
    source = path.parent / str(given.outline or given.mesh)
    try:
        return replace((_from_outline if given.outline else _from_mesh)(given, source, material), own=True)
    except InputError as error:
        text = str(error)
        raise InputError(text if text.startswith(str(source)) else f"{source}: {text}") from None


def _read(path: Path) -> tuple[GarmentFile, Material]:
    """The description in a TOML file, or that of a bare outline or mesh; and the fabric."""
    kind = path.suffix.lower()
    if kind != ".toml":
        given = GarmentFile(name=path.stem, **{"outline" if kind in OUTLINES else "mesh": path.name})
        return given, load_preset(FABRIC).material
    value: dict[str, Any] = read_toml(path)
    unknown = sorted(set(value) - {"garment", "material"})
    if unknown or not isinstance(value.get("garment"), dict):
        wrong = f"must have only [garment] and [material], given {unknown[0]}" if unknown else "Field required, a table"
        raise InputError(f"{path}: garment: {wrong}")
    given = validated(GarmentFile, {"name": path.stem, **value["garment"]}, path)
    if "material" in value:
        return given, validated(Material, value["material"], path)
    return given, load_preset(given.fabric or FABRIC).material


def _from_outline(given: GarmentFile, source: Path, material: Material) -> Garment:
    curves = read_drawing(source)
    openings = given.openings
    if isinstance(openings, dict) and source.suffix.lower() == ".svg":  # whose y points down; curves have it up
        openings = {name: [(x, -y) for x, y in curve] for name, curve in openings.items()}
    outline, names = cut(curves, given.scale or 1e-3, given.up, openings, source)
    _check_unit(np.ptp(outline.points, axis=0), "outline", given.size)
    outline = outline.fitted(given.size)
    if given.layers == 2 or (given.layers is None and names):
        return front_and_back(given.name, outline, names, material, given.spacing)
    return one_layer(given.name, outline, material, given.spacing)


def _from_mesh(given: GarmentFile, source: Path, material: Material) -> Garment:
    if given.spacing is not None and not given.remesh:
        raise InputError("spacing: a mesh has its own; give remesh = true for a new one")
    vertices, faces = read_mesh(source)
    vertices = vertices * (given.scale or 1.0)
    notes = []
    if given.weld or source.suffix.lower() == ".stl":
        before = len(vertices)
        vertices, faces = welded(vertices, faces)
        notes = [f"{before} vertices welded into {len(vertices)}"] if before > len(vertices) else []
    points, turn = _onto_table(vertices, given.up)
    notes += turn
    _check_unit(np.ptp(points, axis=0)[:2], "mesh", given.size)
    found = faults(points, faces)
    if found:
        raise InputError(f"mesh: has {'; '.join(found)}")
    if given.size is not None:
        stretch = np.array(given.size[::-1]) / np.ptp(points[:, :2], axis=0)
        points = points * [*stretch, np.sqrt(stretch.prod())]
    if np.ptp(points[:, 2]) > FLAT * np.ptp(points[:, :2], axis=0).min():
        if given.remesh:
            raise InputError("remesh: only flat meshes can be meshed anew, this one is not flat")
        garment = laid_flat(given.name, points, faces, material)
    else:
        garment = flat_garment(given.name, points[:, :2], faces, material)
        garment = meshed_anew(garment, given.spacing) if given.remesh else garment
    return replace(garment, notes=(*notes, *garment.notes, *_coarseness(garment)))


def _onto_table(vertices: np.ndarray, up: str) -> tuple[np.ndarray, list[str]]:
    """The mesh in a garment's frame; one that is flat in another plane is turned into x-y first."""
    extent = np.ptp(vertices, axis=0)
    thin = int(np.argmin(extent))
    if thin != 2 and extent[thin] <= FLAT * np.sort(extent)[1]:
        # The thin direction faces the viewer and z stays up; both are turns, so triangles keep their sense.
        vertices = vertices[:, [1, 2, 0]] if thin == 0 else vertices[:, [0, 2, 1]] * [1.0, 1.0, -1.0]
        return turned(vertices, up), [f"was flat in the plane across {'xy'[thin]}: turned onto the table"]
    return turned(vertices, up), []


def _check_unit(extent: np.ndarray, what: str, size: tuple[float, float] | None) -> None:
    """Refuse a size that is probably a wrong unit."""
    length, width = (float(side) for side in extent)
    if size is None and not (SMALLEST_SIDE <= min(length, width) and max(length, width) <= LARGEST_SIDE):
        raise InputError(
            f"{what}: is {width:g} m wide and {length:g} m long, must be from {SMALLEST_SIDE:g} to {LARGEST_SIDE:g} m; "
            "give scale, metres per unit of the file (0.001 for millimetres), or size"
        )


def _coarseness(garment: Garment) -> list[str]:
    """Say that a mesh is too coarse for its fabric."""
    cells = garment.spacing / garment.material.bending_length
    if cells <= PASSABLE:
        return []
    return [
        f"coarse: edges of {1e3 * garment.spacing:.1f} mm are {cells:.2f} bending lengths, more than {PASSABLE:g}: "
        "folds will look too stiff"
    ]
