"""A garment of your own: a TOML file that names an outline or a mesh, or that outline or mesh alone."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

from tatamu.errors import InputError
from tatamu.files import read_toml, validated
from tatamu.garments.cut import cut
from tatamu.garments.dxf import read_dxf
from tatamu.garments.flat import flat_garment, meshed_anew
from tatamu.garments.frame import FLAT, Axis, direction, plane_turn, turned
from tatamu.garments.garment import Garment
from tatamu.garments.laying import laid_flat
from tatamu.garments.meshfile import FORMATS, faults, read_mesh, welded
from tatamu.garments.pieces import chosen
from tatamu.garments.resolution import LARGEST_SIDE, PASSABLE, SMALLEST_SIDE
from tatamu.garments.sewing import front_and_back, one_layer
from tatamu.garments.svg import read_svg
from tatamu.garments.units import DOUBTFUL, NAMES, USUAL, Unit, how_to_scale, probable_scale, size_is_possible
from tatamu.material import Material, preset_names
from tatamu.presets import load_preset

READERS = {".svg": read_svg, ".dxf": read_dxf}
OUTLINES = tuple(READERS)
LARGEST_SCALE = 1e3
"""Metres per unit of a file, at most."""
SUFFIXES = (".toml", *OUTLINES, *FORMATS)
"""What a file of a garment may be."""
FABRIC = "jersey"
"""The preset that it is of unless it says otherwise."""
ONE_LAYER = "one layer, as no opening is named: give openings under [garment] for a front and a back, or layers = 1"
"""A note on a closed outline about which nobody said anything."""
Position = tuple[float, float]


def _side(value: float) -> float:
    if not SMALLEST_SIDE <= value <= LARGEST_SIDE:
        raise ValueError(f"must be from {SMALLEST_SIDE:g} to {LARGEST_SIDE:g} m, given {value:g} m")
    return value


def _scale(value: float) -> float:
    if not 0.0 < value <= LARGEST_SCALE:
        raise ValueError(f"must be above 0 and at most {LARGEST_SCALE:g} metres per unit of the file, given {value:g}")
    return value


def _spacing(value: float) -> float:
    if not value > 0.0:
        raise ValueError(f"must be above 0 m, given {value:g} m")
    return value


Side = Annotated[float, AfterValidator(_side)]


class GarmentFile(BaseModel):
    """The table `[garment]` of a garment file. See docs/garments.md."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    name: str = Field("", max_length=60)
    """Its name; default: that of the file."""
    outline: str | None = None
    """An SVG or DXF file beside this one."""
    mesh: str | None = None
    """An OBJ, PLY, STL or GLB file beside this one."""
    scale: Annotated[float, AfterValidator(_scale)] | None = None
    """Metres per unit of that file; default: as the file says, else 0.001 for outlines and 1 for meshes."""
    up: Axis | None = None
    """Which direction of that file points away from the hem; default: y of what is flat, else found."""
    piece: str | None = None
    """Which of several pieces in that file."""
    grain: bool = True
    """Of a pattern with a grain line: turn the piece so that the grain runs along the garment's length."""
    layers: Literal[1, 2] | None = None
    """Of an outline: cut once, or twice and sewn; default: 2 if it has openings."""
    openings: list[str] | dict[str, Annotated[list[Position], Field(min_length=2)]] | None = None
    """Of an outline: names of open curves in the file, or curves in its units by name; default: its open curves."""
    size: tuple[Side, Side] | None = None
    """Width and length that it is scaled to [m]."""
    spacing: Annotated[float, AfterValidator(_spacing)] | None = None
    """Edge length of the mesh [m]."""
    fabric: str | None = None
    """Name of a preset; instead there may be a table [material]."""
    weld: bool = False
    """Join vertices at one place."""
    remesh: bool = False
    """Mesh a flat mesh anew within its outline."""

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
        if self.outline is not None and self.up in ("z", "-z"):
            raise ValueError(f"up must be x, -x, y or -y for an outline, which is a drawing, given {self.up!r}")
        return self


def load_garment(
    path: Path,
    size: tuple[float, float] | None = None,
    material: Material | None = None,
    spacing: float | None = None,
    scale: float | None = None,
) -> Garment:
    """The garment of a file; what is given here goes before what the file says.

    Raises:
        InputError: The file or one that it names cannot be read, or no garment can be made of it; the message says why.
    """
    given, fabric = _read(path)
    material = material or fabric
    if scale is not None and not 0.0 < scale <= LARGEST_SCALE:
        raise InputError(f"scale: must be above 0 and at most {LARGEST_SCALE:g} metres per unit, given {scale:g}")
    asked = {"size": size, "spacing": spacing, "scale": scale}
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
    reader = READERS.get(source.suffix.lower())
    if reader is None:
        raise InputError(f"outline: must be one of {', '.join(OUTLINES)}")
    drawing = reader(source)
    unit = drawing.unit.scaled(given.scale)
    piece = chosen(drawing, given.piece, unit.metres, source)
    openings = given.openings
    if isinstance(openings, dict) and source.suffix.lower() == ".svg":  # whose y points down; curves have it up
        openings = {name: [(x, -y) for x, y in curve] for name, curve in openings.items()}
    turn = plane_turn(given.up or "y", piece.grain if given.grain else None)
    made = cut(piece, unit.metres * turn, openings, source)
    _check_unit(made.outline.size, f"outline: {piece.name}", given.size, unit)
    outline = made.outline.fitted(given.size)
    notes = [*made.notes, *_turn_note(turn, given.up or "y"), *_unit_notes(made.outline.size, given.size, unit)]
    if given.layers == 2 or (given.layers is None and made.openings):
        garment = front_and_back(given.name, outline, made.openings, material, given.spacing)
    else:
        garment = one_layer(given.name, outline, material, given.spacing)
        notes += [ONE_LAYER] if given.layers is None else []
    return replace(garment, reading=_reading(unit, given), notes=(*notes, *garment.notes))


def _turn_note(turn: np.ndarray, up: str) -> list[str]:
    """What to say of a piece that its grain line turned."""
    ahead = turn @ direction(up)[:2]
    degrees = round(float(np.degrees(np.arctan2(ahead[1], ahead[0]))), 1)
    if abs(degrees) < 0.1:
        return []
    return [f"turned by {degrees:g} degrees so that its grain line points away from the hem (grain = false leaves it)"]


def _from_mesh(given: GarmentFile, source: Path, material: Material) -> Garment:
    if given.spacing is not None and not given.remesh:
        raise InputError("spacing: a mesh has its own; give remesh = true for a new one")
    vertices, faces = read_mesh(source)
    vertices, notes = vertices * (given.scale or 1.0), []
    if given.weld or source.suffix.lower() == ".stl":
        before = len(vertices)
        vertices, faces = welded(vertices, faces)
        notes = [f"{before} vertices welded into {len(vertices)}"] if before > len(vertices) else []
    points, turn = _onto_table(vertices, given.up or "y")
    notes += turn
    unit = Unit(1.0, "metres", "assumed", assumed=True).scaled(given.scale)
    length, width = np.ptp(points, axis=0)[:2]
    _check_unit((float(width), float(length)), "mesh", given.size, unit)
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


def _check_unit(sides: tuple[float, float], what: str, size: tuple[float, float] | None, unit: Unit) -> None:
    """Refuse a size [m] that is probably a wrong unit."""
    if size is None and not size_is_possible(sides):
        width, length = sides
        raise InputError(
            f"{what}: is {width:.4g} m wide and {length:.4g} m long, {unit.words}, but must be from "
            f"{SMALLEST_SIDE:g} to {LARGEST_SIDE:g} m; {how_to_scale(max(sides) / unit.metres, 1e-3)}"
        )


def _unit_notes(sides: tuple[float, float], size: tuple[float, float] | None, unit: Unit) -> list[str]:
    """A doubt about a unit that was assumed."""
    longest = max(sides)
    probable = probable_scale(longest / unit.metres)
    if size is not None or not unit.assumed or probable in (None, unit.metres) or USUAL[0] <= longest <= DOUBTFUL:
        return []
    advice = how_to_scale(longest / unit.metres, 1e-3)
    return [f"{longest:.2f} m for its longer side is unusual: is the file in {NAMES[probable]}? {advice}"]


def _reading(unit: Unit, given: GarmentFile) -> str:
    """How the size of a file's garment was understood."""
    return f"{unit.words}{'; scaled to that size' if given.size else ''}"


def _coarseness(garment: Garment) -> list[str]:
    """What to say of a mesh that is too coarse for its fabric."""
    cells = garment.spacing / garment.material.bending_length
    if cells <= PASSABLE:
        return []
    return [
        f"coarse: edges of {1e3 * garment.spacing:.1f} mm are {cells:.2f} bending lengths, more than {PASSABLE:g}: "
        "folds will look too stiff"
    ]
