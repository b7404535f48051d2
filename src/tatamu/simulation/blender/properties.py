"""Names and values of the properties in a material's `blender` table, as Blender 5.0.1 reports them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, NamedTuple

from tatamu.base.errors import InputError

Value = bool | int | float | str

STIFFNESS = (0.0, 1e4)
DAMPING = (0.0, 50.0)


class Property(NamedTuple):
    """A property of Blender's cloth simulation."""

    low: float = 0.0
    """Minimum."""
    high: float = 0.0
    """Maximum; 0 if the value is no number."""
    part: Literal["settings", "collision", "collider"] = "settings"
    """Whether the property describes the cloth itself, its contacts, or the table."""
    whole: bool = False
    """Whether the number is a whole one."""
    length: bool = False
    """Whether the number is a length [m] or a speed."""
    words: tuple[str, ...] = ()
    """The allowed words; without words and a maximum, the value is true or false."""
    default: float | None = None
    """Blender's default, for properties that are scaled with the scene."""


PROPERTIES = {
    "mass": Property(1e-6, 1e6),
    "quality": Property(1, 1000, whole=True),
    "time_scale": Property(1e-3, 10.0),
    "air_damping": Property(0.0, 10.0),
    "bending_model": Property(words=("ANGULAR", "LINEAR")),
    "tension_stiffness": Property(*STIFFNESS, default=15.0),
    "tension_stiffness_max": Property(*STIFFNESS),
    "compression_stiffness": Property(*STIFFNESS, default=15.0),
    "compression_stiffness_max": Property(*STIFFNESS),
    "shear_stiffness": Property(*STIFFNESS, default=5.0),
    "shear_stiffness_max": Property(*STIFFNESS),
    "bending_stiffness": Property(*STIFFNESS, default=0.5),
    "bending_stiffness_max": Property(*STIFFNESS),
    "tension_damping": Property(*DAMPING),
    "compression_damping": Property(*DAMPING),
    "shear_damping": Property(*DAMPING),
    "bending_damping": Property(0.0, 1000.0),
    "use_self_collision": Property(part="collision"),
    "distance_min": Property(1e-3, 1.0, "collision", length=True),
    "collision_quality": Property(1, 100, "collision", whole=True),
    "impulse_clamp": Property(0.0, 100.0, "collision", length=True),
    "self_impulse_clamp": Property(0.0, 100.0, "collision", length=True),
    "self_distance_min": Property(1e-3, 0.1, "collision", length=True),
    "self_friction": Property(0.0, 80.0, "collision"),
    "thickness_outer": Property(1e-3, 1.0, "collider", length=True),
    "cloth_friction": Property(0.0, 80.0, "collider"),
}


def checked(table: Mapping[str, Value]) -> dict[str, Value]:
    """Validate a `blender` table and return it, or raise InputError with the allowed values."""
    return {name: _checked(name, value) for name, value in table.items()}


def _checked(name: str, value: Value) -> Value:
    where = f"material.blender.{name}"
    if name not in PROPERTIES:
        raise InputError(f"{where}: must be a property of Blender's cloth, one of {', '.join(sorted(PROPERTIES))}")
    known = PROPERTIES[name]
    if not known.high:
        allowed: tuple[Value, ...] = known.words or (True, False)
        if value not in allowed:
            raise InputError(f"{where}: must be {' or '.join(known.words) or 'true or false'}, given {value!r}")
        return value if known.words else bool(value)
    if isinstance(value, str | bool) or not known.low <= value <= known.high:
        raise InputError(f"{where}: must be a number from {known.low:g} to {known.high:g}, given {value!r}")
    if not known.whole:
        return float(value)
    if value != int(value):
        raise InputError(f"{where}: must be a whole number, given {value!r}")
    return int(value)
