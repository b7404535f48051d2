"""The contents of a garment file: the table `[garment]`."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

from tatamu.errors import one_line
from tatamu.garments.frame import Axis
from tatamu.garments.resolution import LARGEST_SIDE, SMALLEST_SIDE
from tatamu.material import preset_names

LARGEST_SCALE = 1e3
"""Metres per unit of a file, at most."""
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
    """The table `[garment]` of a garment file. See docs/reference/garment-file.md."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    name: Annotated[str, AfterValidator(one_line)] = Field("", max_length=60)
    """Name of the garment; by default the name of the file."""
    kind: Literal["towel", "tshirt", "trousers"] | None = None
    """The built-in garment whose fold plans suit it; their grasps need edges of the same names."""
    outline: str | None = None
    """An SVG or DXF file in the same folder."""
    mesh: str | None = None
    """An OBJ, PLY, STL or GLB file in the same folder."""
    scale: Annotated[float, AfterValidator(_scale)] | None = None
    """Metres per unit of that file; by default the file's unit, otherwise 0.001 for outlines and 1 for meshes."""
    up: Axis | None = None
    """Direction of that file that points away from the hem; by default y for flat files, otherwise it is found."""
    piece: str | None = None
    """Which of several pieces in that file."""
    grain: bool = True
    """Whether to turn the piece of a pattern so that its grain line runs along the garment's length."""
    layers: Literal[1, 2] | None = None
    """Number of layers of an outline: cut once, or twice and sewn; by default 2 if it has openings."""
    openings: list[str] | dict[str, Annotated[list[Position], Field(min_length=2)]] | None = None
    """Openings of an outline: names of open curves in the file, or curves in its units by name; by default all."""
    holes: bool | None = None
    """Whether closed curves inside an outline are holes; by default those that follow the outline are sewn lines."""
    size: tuple[Side, Side] | None = None
    """Width and length that it is scaled to [m]."""
    spacing: Annotated[float, AfterValidator(_spacing)] | None = None
    """Edge length of the mesh [m]."""
    fabric: str | None = None
    """Name of a preset; a table [material] may replace it."""
    weld: bool = False
    """Join vertices at one place."""
    remesh: bool = False
    """Mesh it again within its outline."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if (self.outline is None) == (self.mesh is None):
            raise ValueError("must have either outline or mesh, a file name")
        if self.fabric is not None and self.fabric not in preset_names():
            raise ValueError(f"fabric must be one of {', '.join(preset_names())}, given {self.fabric!r}")
        if self.mesh is not None and (self.layers, self.openings, self.holes) != (None, None, None):
            raise ValueError("layers, openings and holes belong to an outline; those of a mesh are in the mesh")
        if self.outline is not None and (self.weld or self.remesh):
            raise ValueError("weld and remesh belong to a mesh")
        if self.outline is not None and self.up in ("z", "-z"):
            raise ValueError(f"up must be x, -x, y or -y for an outline, which is a drawing, given {self.up!r}")
        return self
