"""The contents of a garment file: the table `[garment]`."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

from tatamu.base.errors import one_line
from tatamu.garments.garment import MAX_SIDE, MIN_SIDE
from tatamu.garments.units import Axis
from tatamu.simulation.material import preset_names

MAX_SCALE = 1e3
"""Largest allowed length of one unit of a garment's file [m]."""
Position = tuple[float, float]


def _side(value: float) -> float:
    if not MIN_SIDE <= value <= MAX_SIDE:
        raise ValueError(f"must be from {MIN_SIDE:g} to {MAX_SIDE:g} m, given {value:g} m")
    return value


def _scale(value: float) -> float:
    if not 0.0 < value <= MAX_SCALE:
        raise ValueError(f"must be above 0 and at most {MAX_SCALE:g} metres per unit of the file, given {value:g}")
    return value


def _spacing(value: float) -> float:
    if not value > 0.0:
        raise ValueError(f"must be above 0 m, given {value:g} m")
    return value


Side = Annotated[float, AfterValidator(_side)]


class GarmentFile(BaseModel):
    """The table `[garment]` of a garment file. See docs/reference/garment-file.md."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    name: Annotated[str, AfterValidator(one_line)] = Field("", max_length=60)
    """Name of the garment; by default the name of the file."""
    kind: Literal["towel", "tshirt", "trousers"] | None = None
    """Name of the built-in garment whose fold plans suit this garment. This garment must have edges with the same
    names, because the plans grasp edges by name."""
    outline: str | None = None
    """Name of an SVG or DXF file in the same folder that contains the garment's outline."""
    mesh: str | None = None
    """Name of an OBJ, PLY, STL or GLB file in the same folder that contains the garment's mesh."""
    scale: Annotated[float, AfterValidator(_scale)] | None = None
    """Length of one unit of the outline or mesh [m]. The default is the unit that the file states. If the file states
    no unit, the default is 0.001 for outlines and 1 for meshes."""
    up: Axis | None = None
    """Axis of the outline or mesh that points away from the hem. The default is y for flat files; for other files, the
    axis is found from the shape."""
    piece: str | None = None
    """Name of the piece to use if the outline or mesh has several pieces."""
    grain: bool = True
    """Whether to turn the piece of a pattern so that its grain line runs along the garment's length."""
    layers: Literal[1, 2] | None = None
    """Number of layers: 1 if the outline is cut once, 2 if it is cut twice and sewn. The default is 2 if the outline
    has openings, otherwise 1."""
    openings: list[str] | dict[str, Annotated[list[Position], Field(min_length=2)]] | None = None
    """Openings of an outline: names of open curves in the file, or curves by name in units of the file. By default,
    every named open curve along the outline is an opening."""
    holes: bool | None = None
    """Whether closed curves inside an outline are holes. By default, a closed curve that follows the outline is the
    line along which the piece is sewn. Every other closed curve is a hole."""
    size: tuple[Side, Side] | None = None
    """Width and length to which the garment is scaled [m]; None to keep the size in the file."""
    spacing: Annotated[float, AfterValidator(_spacing)] | None = None
    """Edge length of the mesh [m]; None for the default."""
    fabric: str | None = None
    """Name of a material preset. If the file has a table [material], this table replaces the preset."""
    weld: bool = False
    """Whether to join vertices that have the same position."""
    remesh: bool = False
    """Whether to replace the mesh of the file with a new one inside its outline."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if (self.outline is None) == (self.mesh is None):
            given = "both" if self.mesh is not None else "neither"
            raise ValueError(f"must have either outline or mesh, given {given}")
        if self.fabric is not None and self.fabric not in preset_names():
            raise ValueError(f"fabric must be one of {', '.join(preset_names())}, given {self.fabric!r}")
        if self.mesh is not None and (self.layers, self.openings, self.holes) != (None, None, None):
            raise ValueError(
                "layers, openings and holes must be left out for a mesh, because the mesh already defines them"
            )
        if self.outline is not None and (self.weld or self.remesh):
            raise ValueError("weld and remesh must be left out for an outline")
        if self.outline is not None and self.up in ("z", "-z"):
            raise ValueError(f"up must be x, -x, y or -y for an outline, given {self.up!r}")
        return self
