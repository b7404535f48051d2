"""The material of a cloth: a thin elastic sheet with Coulomb friction, in SI units."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    SerializerFunctionWrapHandler,
    model_serializer,
    model_validator,
)

from tatamu.errors import InputError
from tatamu.files import read_toml, validated

PRESETS = Path(__file__).parent / "presets"
"""Folder of the materials that come with tatamu; see `tatamu.presets`."""

GRAVITY = 9.81
"""Standard acceleration of free fall, used if no other value is given [m/s^2]."""

Number = Annotated[float, Field(strict=True)]
"""A strict number: no text, no truth value."""
Friction = Annotated[Number, Field(ge=0.0, le=10.0, allow_inf_nan=False)]


THICKNESS = (1e-5, 0.05)
"""Lowest and highest thickness of cloth [m]."""


DIRECTIONAL_AIR = (
    "air_drag_normal",
    "air_drag_tangential",
    "air_drag_quadratic",
    "air_drag_quadratic_tangential",
    "air_drag_turning",
    "air_added_mass",
)
"""Fields of the effects of air other than `air_drag`."""
ORTHOTROPIC_MEMBRANE = ("stretch_stiffness_weft", "shear_stiffness")
"""Fields of an orthotropic membrane."""
ORTHOTROPIC_BENDING = ("bending_rigidity_weft", "bending_rigidity_bias")
"""Fields of orthotropic bending."""
FRICTION_OF_BENDING = ("bending_hysteresis", "bending_rigidity_initial")
"""Fields of the friction of bending."""
FRICTION_ELEMENTS = ((0.5, 0.4), (0.3, 1.0), (0.2, 2.5))
"""Elements of the friction of bending: fractions of its stiffness, and yield curvatures as multiples of k_y.

Their products sum to 1. The moment of a sheet bent for the first time is HB (1 - exp(-k / k_y)) within 0.09 HB.
"""
STEEPER = 4.0
"""Default ratio of the slope of a bending moment after a reversal to its slope later."""
UNSAID = (
    "blender",
    "compression",
    *ORTHOTROPIC_MEMBRANE,
    *ORTHOTROPIC_BENDING,
    *FRICTION_OF_BENDING,
    *DIRECTIONAL_AIR,
)
"""Fields that are written only if they differ from their defaults."""


class Material(BaseModel):
    """The properties of a fabric that simulators use; isotropic unless weft, shear or bias are given."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    areal_density: Number = Field(ge=1e-3, le=20.0)
    """Mass per area, rho [kg/m^2]."""
    stretch_stiffness: Number = Field(ge=1e-1, le=1e6)
    """Membrane stiffness Y: tension per width per strain [N/m]; along the warp if the weft has its own."""
    stretch_stiffness_weft: Number | None = Field(None, ge=1e-1, le=1e6)
    """Membrane stiffness along the weft [N/m]; None for that along the warp."""
    shear_stiffness: Number | None = Field(None, ge=1e-2, le=1e6)
    """Shear force per width per shear angle between warp and weft, G [N/m]; None for sqrt(Y Y_weft) / (2 (1 + nu)), the
    value of an isotropic material."""
    poisson_ratio: Number = Field(0.25, ge=-0.95, le=0.95)
    """In-plane Poisson ratio nu [-]; if warp and weft differ, the geometric mean of both."""
    compression: Number = Field(1.0, ge=1e-3, le=1.0)
    """Fraction c of the stretch stiffness that resists compression [-]; less than 1 represents wrinkles finer than the
    mesh."""
    bending_rigidity: Number = Field(ge=0.0, le=1.0)
    """Bending rigidity B: moment per width per curvature [N m]; along the warp if the weft has its own."""
    bending_rigidity_weft: Number | None = Field(None, ge=0.0, le=1.0)
    """Bending rigidity along the weft [N m]; None for that along the warp."""
    bending_rigidity_bias: Number | None = Field(None, ge=0.0, le=1.0)
    """Bending rigidity of a wide sheet that is bent to a cylinder at 45 degrees to warp and weft [N m]. It is at least
    a quarter of the sum of both. None for the value of an isotropic sheet, (B + B_weft + 2 sqrt(B B_weft)) / 4."""
    bending_hysteresis: Number = Field(0.0, ge=0.0, le=1.0)
    """Frictional moment of bending per width, HB [N]: half of the width 2HB of the loop of moment against curvature, as
    Kawabata's test reports it."""
    bending_rigidity_initial: Number | None = Field(None, ge=0.0, le=10.0)
    """Slope of that loop at a reversal of bending [N m], more than all rigidities; None for four times the rigidity. It
    has no effect without hysteresis."""
    thickness: Number = Field(1e-3, ge=THICKNESS[0], le=THICKNESS[1])
    """Distance between layers at rest [m]."""
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
    air_drag_turning: Number = Field(0.0, ge=0.0, le=1e3)
    """Drag along the normal after a reversal of motion: per area, per square of the velocity, times the cube root of
    the path since the reversal [kg/m^(8/3)]; `air_drag_quadratic` acts if it is larger."""
    air_added_mass: Number = Field(0.0, ge=0.0, le=20.0)
    """Mass of air per area that moves with the surface along its normal [kg/m^2]; it adds no weight."""

    blender: dict[str, bool | int | float | str] | None = None
    """Blender's own numbers by their property names, used unchanged by that simulator only, which checks them."""

    @model_serializer(mode="wrap")
    def _plain(self, standard: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Return plain data, without the fields of `UNSAID` that have their defaults."""
        plain: dict[str, Any] = standard(self)
        for name in UNSAID:
            if getattr(self, name) == type(self).model_fields[name].default:
                plain.pop(name, None)  # it may have been excluded already
        return plain

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.orthotropic_membrane and self.compression < 1.0:
            raise ValueError("compression must be 1 where shear_stiffness or stretch_stiffness_weft is given")
        if self.bending_rigidity_initial is not None and not self.bending_rigidity_initial > self.bending_rigidity:
            raise ValueError(
                f"bending_rigidity_initial must be more than bending_rigidity ({self.bending_rigidity:g} N m), "
                f"given {self.bending_rigidity_initial:g}"
            )
        if self.bending_rigidity_bias is not None:
            least = 0.25 * (self.bending_rigidity + self.weft_rigidity)
            if self.bending_rigidity_bias < least * (1.0 - 1e-9):
                raise ValueError(
                    f"bending_rigidity_bias must be at least a quarter of the sum of warp and weft ({least:g} N m), "
                    f"given {self.bending_rigidity_bias:g}"
                )
        return self

    @property
    def orthotropic_membrane(self) -> bool:
        """Whether the membrane is orthotropic."""
        return any(getattr(self, name) is not None for name in ORTHOTROPIC_MEMBRANE)

    @property
    def orthotropic_bending(self) -> bool:
        """Whether bending is orthotropic."""
        return any(getattr(self, name) is not None for name in ORTHOTROPIC_BENDING)

    @property
    def weft_stiffness(self) -> float:
        """Membrane stiffness along the weft [N/m]."""
        return self.stretch_stiffness if self.stretch_stiffness_weft is None else self.stretch_stiffness_weft

    @property
    def shear_modulus(self) -> float:
        """Shear force per width per shear angle, G [N/m]."""
        if self.shear_stiffness is not None:
            return self.shear_stiffness
        return (self.stretch_stiffness * self.weft_stiffness) ** 0.5 / (2.0 * (1.0 + self.poisson_ratio))

    @property
    def weft_rigidity(self) -> float:
        """Bending rigidity along the weft [N m]."""
        return self.bending_rigidity if self.bending_rigidity_weft is None else self.bending_rigidity_weft

    @property
    def twist_rigidity(self) -> float:
        """Twisting moment, as it works on the twist k_uv, per twist [N m]; 2 B of an isotropic sheet."""
        if self.bending_rigidity_bias is not None:
            return max(0.0, 4.0 * self.bending_rigidity_bias - self.bending_rigidity - self.weft_rigidity)
        return 2.0 * (self.bending_rigidity * self.weft_rigidity) ** 0.5

    @property
    def friction_stiffness(self) -> float:
        """Slope of the frictional moment at a reversal of bending [N m]; 0 without hysteresis."""
        if self.bending_hysteresis == 0.0:
            return 0.0
        initial = self.bending_rigidity_initial
        return (STEEPER - 1.0) * self.bending_rigidity if initial is None else initial - self.bending_rigidity

    @property
    def friction_elements(self) -> tuple[tuple[float, float], ...]:
        """Stiffness [N m] and yield curvature [1/m] of each element of the friction of bending."""
        total = self.friction_stiffness
        if total == 0.0:
            return ()
        unit = self.bending_hysteresis / total
        return tuple((part * total, curvature * unit) for part, curvature in FRICTION_ELEMENTS)

    @property
    def directional_air(self) -> bool:
        """Whether air acts differently along the normal and along the surface, or by the square of a velocity."""
        return any(getattr(self, name) > 0.0 for name in DIRECTIONAL_AIR)

    @property
    def bending_length(self) -> float:
        """Bending length l_b = (B / (rho g))^(1/3) [m], over which cloth bends under its own weight."""
        return (self.bending_rigidity / (self.areal_density * GRAVITY)) ** (1.0 / 3.0)


def preset_names() -> list[str]:
    """Return the names of all presets, sorted."""
    return sorted(path.stem for path in PRESETS.glob("*.toml"))


def is_preset(path: Path) -> bool:
    """Return whether a path is the name of a preset and not a file."""
    return not path.exists() and path.name == str(path) and (PRESETS / f"{path}.toml").is_file()


def measured_size(path: Path, garment: str) -> tuple[float, float] | None:
    """Return the size of the garment with which a material was calibrated.

    Args:
        path: File of the material, or a preset.
        garment: Name or file of a garment.

    Returns:
        Width and length [m]; None if the material was not calibrated with that garment.
    """
    if is_preset(path):
        return None
    value = read_toml(path).get("calibration")
    size = value.get("size") if isinstance(value, dict) and value.get("garment") == garment else None
    if not isinstance(size, list) or len(size) != 2 or not all(isinstance(side, float) and side > 0 for side in size):
        return None
    return size[0], size[1]


def load_material(path: Path) -> Material:
    """Read a material from the `[material]` table of a TOML file, or from the preset of that name.

    Raises:
        InputError: If the file cannot be read, or a field is wrong; the message names both.
    """
    if is_preset(path):
        path = PRESETS / f"{path}.toml"
    elif not path.suffix and not path.exists():
        raise InputError(f"material: must be a file .toml or one of {', '.join(preset_names())}, given {str(path)!r}")
    value = read_toml(path)
    if not isinstance(value.get("material"), dict):
        raise InputError(f"{path}: material: Field required, a table [material] with areal_density, ..")
    return validated(Material, value["material"], path)
