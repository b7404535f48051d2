"""Names and ranges of the properties in a material's `blender` table, as Blender 5.0.1 reports them."""

from __future__ import annotations

from collections.abc import Mapping

from tatamu.base.errors import InputError

Value = bool | int | float | str

STIFFNESS = (0.0, 1e4)
DAMPING = (0.0, 50.0)
RANGES: dict[str, tuple[float, float]] = {
    "mass": (1e-6, 1e6),
    "quality": (1, 1000),
    "time_scale": (1e-3, 10.0),
    "air_damping": (0.0, 10.0),
    "tension_stiffness": STIFFNESS,
    "tension_stiffness_max": STIFFNESS,
    "compression_stiffness": STIFFNESS,
    "compression_stiffness_max": STIFFNESS,
    "shear_stiffness": STIFFNESS,
    "shear_stiffness_max": STIFFNESS,
    "bending_stiffness": STIFFNESS,
    "bending_stiffness_max": STIFFNESS,
    "tension_damping": DAMPING,
    "compression_damping": DAMPING,
    "shear_damping": DAMPING,
    "bending_damping": (0.0, 1000.0),
    "distance_min": (1e-3, 1.0),
    "collision_quality": (1, 100),
    "impulse_clamp": (0.0, 100.0),
    "self_impulse_clamp": (0.0, 100.0),
    "self_distance_min": (1e-3, 0.1),
    "self_friction": (0.0, 80.0),
    "thickness_outer": (1e-3, 1.0),
    "cloth_friction": (0.0, 80.0),
}
"""Minimum and maximum of each property in a material's `blender` table."""
CHOICES = {"bending_model": ("ANGULAR", "LINEAR")}
SWITCHES = ("use_self_collision",)

COLLISION = (
    "distance_min",
    "collision_quality",
    "impulse_clamp",
    "self_impulse_clamp",
    "self_distance_min",
    "self_friction",
    "use_self_collision",
)
"""Properties of the cloth's contacts. Those in neither this nor `COLLIDER`, the table's, describe the cloth itself."""
COLLIDER = ("thickness_outer", "cloth_friction")
LENGTHS = ("distance_min", "self_distance_min", "thickness_outer", "impulse_clamp", "self_impulse_clamp")
"""Properties that are lengths [m] or speeds."""
DEFAULTS: dict[str, Value] = {
    "tension_stiffness": 15.0,
    "compression_stiffness": 15.0,
    "shear_stiffness": 5.0,
    "bending_stiffness": 0.5,
}
"""Blender's defaults for properties that are scaled with the scene."""


def checked(table: Mapping[str, Value]) -> dict[str, Value]:
    """Validate a `blender` table and return it, or raise InputError with the allowed values."""
    return {name: _checked(name, value) for name, value in table.items()}


def _checked(name: str, value: Value) -> Value:
    where = f"material.blender.{name}"
    if name in CHOICES:
        if value not in CHOICES[name]:
            raise InputError(f"{where}: must be {' or '.join(CHOICES[name])}, given {value!r}")
        return value
    if name in SWITCHES:
        if value not in (True, False):
            raise InputError(f"{where}: must be true or false, given {value!r}")
        return bool(value)
    if name not in RANGES:
        known = ", ".join(sorted([*RANGES, *CHOICES, *SWITCHES]))
        raise InputError(f"{where}: must be a property of Blender's cloth, one of {known}")
    low, high = RANGES[name]
    if isinstance(value, str | bool) or not low <= value <= high:
        raise InputError(f"{where}: must be a number from {low:g} to {high:g}, given {value!r}")
    if name not in ("quality", "collision_quality"):
        return float(value)
    if value != int(value):
        raise InputError(f"{where}: must be a whole number, given {value!r}")
    return int(value)
