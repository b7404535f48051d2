"""The material of a cloth: a thin elastic sheet with Coulomb friction, in SI units."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, SerializerFunctionWrapHandler, model_serializer

from tatamu.errors import InputError
from tatamu.files import read_toml, validated

PRESETS = Path(__file__).parent / "presets"
"""Folder of the materials that come with tatamu; see `tatamu.presets`."""

GRAVITY = 9.81
"""Standard acceleration of free fall used where nothing else is said [m/s^2]."""

Number = Annotated[float, Field(strict=True)]
"""A number proper: no text, no truth value."""
Friction = Annotated[Number, Field(ge=0.0, le=10.0, allow_inf_nan=False)]


THICKNESS = (1e-5, 0.05)
"""Least and greatest thickness of cloth [m]."""


DIRECTIONAL_AIR = (
    "air_drag_normal",
    "air_drag_tangential",
    "air_drag_quadratic",
    "air_drag_quadratic_tangential",
    "air_added_mass",
)
"""Fields of what air does beyond `air_drag`."""
UNSAID = ("blender", "compression", *DIRECTIONAL_AIR)
"""Fields that are written only where they differ from their defaults."""


class Material(BaseModel):
    """The properties of a fabric that simulators use; isotropic, without memory of past deformation."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    areal_density: Number = Field(ge=1e-3, le=20.0)
    """Mass per area, rho [kg/m^2]."""
    stretch_stiffness: Number = Field(ge=1e-1, le=1e6)
    """Membrane stiffness Y: tension per width per strain [N/m]."""
    poisson_ratio: Number = Field(0.25, ge=-0.95, le=0.95)
    """In-plane Poisson ratio nu [-]."""
    compression: Number = Field(1.0, ge=1e-3, le=1.0)
    """Fraction c of the stretch stiffness that resists compression [-]; less than 1 stands for wrinkles finer than the
    mesh."""
    bending_rigidity: Number = Field(ge=0.0, le=1.0)
    """Bending rigidity B: moment per width per curvature [N m]."""
    thickness: Number = Field(1e-3, ge=THICKNESS[0], le=THICKNESS[1])
    """Distance at which layers rest [m]."""
    friction_table: Friction = 0.5
    """Coulomb coefficient of cloth on table, static = kinetic [-]."""
    friction_cloth: Friction = 0.5
    """Coulomb coefficient of cloth on cloth, static = kinetic [-]."""
    air_drag: Number = Field(0.0, ge=0.0, le=1e3)
    """Drag force per area per velocity, the same in every direction [N s/m^3]."""
    air_drag_normal: Number = Field(0.0, ge=0.0, le=1e3)
    """Further drag along the surface's normal, per area per velocity along it [N s/m^3]."""
    air_drag_tangential: Number = Field(0.0, ge=0.0, le=1e3)
    """Further drag along the surface, per area per velocity along it [N s/m^3]."""
    air_drag_quadratic: Number = Field(0.0, ge=0.0, le=1e3)
    """Drag along the normal, per area per square of the velocity along it [kg/m^3]; half the density of air times the
    drag coefficient of a plate across the flow."""
    air_drag_quadratic_tangential: Number = Field(0.0, ge=0.0, le=1e3)
    """Drag along the surface, per area per square of the velocity along it [kg/m^3]."""
    air_added_mass: Number = Field(0.0, ge=0.0, le=20.0)
    """Mass of air per area that moves with the surface along its normal [kg/m^2]; it weighs nothing."""

    blender: dict[str, bool | int | float | str] | None = None
    """Blender's own numbers by their property names, used as they are by that simulator alone; it checks them."""

    @model_serializer(mode="wrap")
    def _plain(self, standard: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Plain data, without the fields of `UNSAID` that have their defaults."""
        plain: dict[str, Any] = standard(self)
        for name in UNSAID:
            if getattr(self, name) == type(self).model_fields[name].default:
                plain.pop(name, None)  # it may have been excluded already
        return plain

    @property
    def directional_air(self) -> bool:
        """Whether air acts otherwise along the normal than along the surface, or by the square of a velocity."""
        return any(getattr(self, name) > 0.0 for name in DIRECTIONAL_AIR)

    @property
    def bending_length(self) -> float:
        """Bending length l_b = (B / (rho g))^(1/3) [m], over which cloth bends under its own weight."""
        return (self.bending_rigidity / (self.areal_density * GRAVITY)) ** (1.0 / 3.0)


def preset_names() -> list[str]:
    """Names of all presets, sorted."""
    return sorted(path.stem for path in PRESETS.glob("*.toml"))


def is_preset(path: Path) -> bool:
    """Whether this names a preset, and no file."""
    return not path.exists() and path.name == str(path) and (PRESETS / f"{path}.toml").is_file()


def load_material(path: Path) -> Material:
    """Read a material from the `[material]` table of a TOML file, or from the preset of that name.

    Raises:
        InputError: The file cannot be read, or a field is wrong; the message names both.
    """
    if is_preset(path):
        path = PRESETS / f"{path}.toml"
    elif not path.suffix and not path.exists():
        raise InputError(f"material: must be a file .toml or one of {', '.join(preset_names())}, given {str(path)!r}")
    value = read_toml(path)
    if not isinstance(value.get("material"), dict):
        raise InputError(f"{path}: material: Field required, a table [material] with areal_density, ..")
    return validated(Material, value["material"], path)
