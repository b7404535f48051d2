"""The material of a cloth: a thin elastic sheet with Coulomb friction, in SI units."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, ClassVar, Self

from pydantic import Field, model_validator

from tatamu.base.errors import InputError
from tatamu.base.files import read_toml, validated
from tatamu.base.records import OpenRecord

PRESETS = Path(__file__).parent / "presets"

GRAVITY = 9.81
"""Standard acceleration of free fall [m/s^2]."""

Number = Annotated[float, Field(strict=True)]
"""A number that is checked strictly: texts and truth values are refused."""
Friction = Annotated[Number, Field(ge=0.0, le=10.0, allow_inf_nan=False)]


THICKNESS = (1e-5, 0.05)
"""Minimum and maximum thickness of cloth [m]."""


DIRECTIONAL_AIR = (
    "air_drag_normal",
    "air_drag_tangential",
    "air_drag_quadratic",
    "air_drag_quadratic_tangential",
    "air_drag_turning",
    "air_added_mass",
)
"""Fields for effects of air other than `air_drag`."""
ORTHOTROPIC_MEMBRANE = ("stretch_stiffness_weft", "shear_stiffness")
ORTHOTROPIC_BENDING = ("bending_rigidity_weft", "bending_rigidity_bias")
FRICTION_ELEMENTS = ((0.5, 0.4), (0.3, 1.0), (0.2, 2.5))
"""Elements of the friction of bending: fraction of the frictional stiffness, and yield curvature in units of k_y.

The products sum to 1, and a first bend to the curvature k has the moment HB (1 - exp(-k / k_y)), with an error of at
most 0.09 HB (docs/theory/hysteresis.md)."""


class Material(OpenRecord, extra="forbid"):
    """The properties of a fabric, which is isotropic unless values for weft, shear or bias are given."""

    UNSAID: ClassVar[frozenset[str]] = frozenset(
        {"blender", "compression", "bending_hysteresis", "bending_rigidity_initial"}
    ).union(ORTHOTROPIC_MEMBRANE, ORTHOTROPIC_BENDING, DIRECTIONAL_AIR)

    areal_density: Number = Field(ge=1e-3, le=20.0)
    """Mass per area rho [kg/m^2]."""
    stretch_stiffness: Number = Field(ge=1e-1, le=1e6)
    """Membrane stiffness Y along the warp: tension per width and strain [N/m]."""
    stretch_stiffness_weft: Number | None = Field(None, ge=1e-1, le=1e6)
    """Membrane stiffness along the weft [N/m]; None for the value along the warp."""
    shear_stiffness: Number | None = Field(None, ge=1e-2, le=1e6)
    """Shear stiffness G: shear force per width and shear angle [N/m]; None for sqrt(Y Y_weft) / (2 (1 + nu))."""
    poisson_ratio: Number = Field(0.25, ge=-0.95, le=0.95)
    """Poisson ratio nu in the plane [-]; the geometric mean of both ratios if warp and weft differ."""
    compression: Number = Field(1.0, ge=1e-3, le=1.0)
    """Fraction c of the stretch stiffness that resists compression [-]; below 1 for wrinkles finer than the mesh."""
    bending_rigidity: Number = Field(ge=0.0, le=1.0)
    """Bending rigidity B along the warp: moment per width and curvature [N m]."""
    bending_rigidity_weft: Number | None = Field(None, ge=0.0, le=1.0)
    """Bending rigidity along the weft [N m]; None for the value along the warp."""
    bending_rigidity_bias: Number | None = Field(None, ge=0.0, le=1.0)
    """Bending rigidity of a wide sheet that is bent to a cylinder at 45 degrees to warp and weft [N m].

    It is at least (B + B_weft) / 4; None for (B + B_weft + 2 sqrt(B B_weft)) / 4."""
    bending_hysteresis: Number = Field(0.0, ge=0.0, le=1.0)
    """Frictional moment of bending per width, HB [N]: half of the loop's width 2HB in Kawabata's test."""
    bending_rigidity_initial: Number | None = Field(None, ge=0.0, le=10.0)
    """Slope of the bending moment over the curvature directly after a reversal of bending [N m], larger than all
    rigidities; None for 4 B. Without hysteresis, it has no effect."""
    thickness: Number = Field(1e-3, ge=THICKNESS[0], le=THICKNESS[1])
    """Distance between two layers that lie on each other [m]."""
    friction_table: Friction = 0.5
    """Coulomb coefficient between cloth and table [-], static and kinetic."""
    friction_cloth: Friction = 0.5
    """Coulomb coefficient between layers of cloth [-], static and kinetic."""
    air_drag: Number = Field(0.0, ge=0.0, le=1e3)
    """Drag force per area and velocity, equal in all directions [N s/m^3]."""
    air_drag_normal: Number = Field(0.0, ge=0.0, le=1e3)
    """Additional drag along the normal, per area and velocity along the normal [N s/m^3]."""
    air_drag_tangential: Number = Field(0.0, ge=0.0, le=1e3)
    """Additional drag along the surface, per area and velocity along the surface [N s/m^3]."""
    air_drag_quadratic: Number = Field(0.0, ge=0.0, le=1e3)
    """Drag along the normal, per area and square of the velocity along the normal [kg/m^3]: half the density of air
    times the drag coefficient of a plate across the flow."""
    air_drag_quadratic_tangential: Number = Field(0.0, ge=0.0, le=1e3)
    """Drag along the surface, per area and square of the velocity along the surface [kg/m^3]."""
    air_drag_turning: Number = Field(0.0, ge=0.0, le=1e3)
    """Constant of the drag along the normal after a reversal of motion [kg/m^(8/3)]: per area and square of the
    velocity, divided by the cube root of the path since then. It acts while it exceeds `air_drag_quadratic`."""
    air_added_mass: Number = Field(0.0, ge=0.0, le=20.0)
    """Mass of air per area that moves with the surface along its normal [kg/m^2]: inertia without weight."""

    blender: dict[str, bool | int | float | str] | None = None
    """Properties of Blender's cloth by their names in Blender, for the simulator `blender` only."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.orthotropic_membrane and self.compression < 1.0:
            raise ValueError(
                "compression must be 1 for a material with shear_stiffness or stretch_stiffness_weft, given "
                f"{self.compression}"
            )
        if self.bending_rigidity_initial is not None and not self.bending_rigidity_initial > self.bending_rigidity:
            raise ValueError(
                f"bending_rigidity_initial must be more than bending_rigidity ({self.bending_rigidity:g} N m), "
                f"given {self.bending_rigidity_initial:g}"
            )
        if self.bending_rigidity_bias is not None:
            least = 0.25 * (self.bending_rigidity + self.weft_rigidity)
            if self.bending_rigidity_bias < least * (1.0 - 1e-9):
                raise ValueError(
                    "bending_rigidity_bias must be at least a quarter of the sum of the warp and weft rigidities "
                    f"({least:g} N m), given {self.bending_rigidity_bias:g}"
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
        """Shear stiffness G: shear force per width and per shear angle [N/m]."""
        if self.shear_stiffness is not None:
            return self.shear_stiffness
        return (self.stretch_stiffness * self.weft_stiffness) ** 0.5 / (2.0 * (1.0 + self.poisson_ratio))

    @property
    def weft_rigidity(self) -> float:
        """Bending rigidity along the weft [N m]."""
        return self.bending_rigidity if self.bending_rigidity_weft is None else self.bending_rigidity_weft

    @property
    def twist_rigidity(self) -> float:
        """Twisting moment divided by the twist k_uv of the surface [N m]; 2 B for an isotropic sheet."""
        if self.bending_rigidity_bias is not None:
            return max(0.0, 4.0 * self.bending_rigidity_bias - self.bending_rigidity - self.weft_rigidity)
        return 2.0 * (self.bending_rigidity * self.weft_rigidity) ** 0.5

    @property
    def friction_stiffness(self) -> float:
        """Slope of the frictional moment at a reversal of bending [N m]; 0 without hysteresis."""
        if self.bending_hysteresis == 0.0:
            return 0.0
        initial = self.bending_rigidity_initial
        return 3.0 * self.bending_rigidity if initial is None else initial - self.bending_rigidity

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
        """Length l_b = (B / (rho g))^(1/3) over which cloth bends under its own weight [m]."""
        return (self.bending_rigidity / (self.areal_density * GRAVITY)) ** (1.0 / 3.0)


def settling(material: Material, rate: float) -> Material:
    """Return the material with air drag that critically damps motions of the angular frequency `rate` [rad/s].

    Cloth then soon comes to rest, in the same final shape.
    """
    most = 1e3  # the maximum air drag of a material [N s/m^3]
    return material.model_copy(update={"air_drag": min(2.0 * rate * material.areal_density, most)})


def preset_names() -> list[str]:
    """Return the names of all presets in alphabetical order."""
    return sorted(path.stem for path in PRESETS.glob("*.toml"))


def is_preset(path: Path) -> bool:
    """Return whether a path is the name of a preset and not of a file."""
    return not path.exists() and path.name == str(path) and (PRESETS / f"{path}.toml").is_file()


def measured_size(path: Path, garment: str) -> tuple[float, float] | None:
    """Return width and length [m] of the garment with which a material file was calibrated; None without one."""
    if is_preset(path):
        return None
    value = read_toml(path).get("calibration")
    size = value.get("size") if isinstance(value, dict) and value.get("garment") == garment else None
    if not isinstance(size, list) or len(size) != 2 or not all(isinstance(side, float) and side > 0 for side in size):
        return None
    return size[0], size[1]


def load_material(path: Path) -> Material:
    """Read the table `[material]` of a TOML file, or the preset with this name, or raise InputError."""
    if is_preset(path):
        path = PRESETS / f"{path}.toml"
    elif not path.suffix and not path.exists():
        raise InputError(f"material: must be a .toml file or one of {', '.join(preset_names())}, given {str(path)!r}")
    value = read_toml(path)
    if not isinstance(value.get("material"), dict):
        raise InputError(
            f"{path}: material: must be a table [material] with areal_density and other fields, given none"
        )
    return validated(Material, value["material"], path)
