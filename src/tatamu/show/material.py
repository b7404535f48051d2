"""The fields of a material with their names and units."""

from __future__ import annotations

from tatamu.show.quantity import Quantity, filed
from tatamu.simulation.material import Material

FIELDS = {
    "areal_density": ("areal density", "g/m²"),
    "stretch_stiffness": ("stretch stiffness", "N/m"),
    "stretch_stiffness_weft": ("stretch stiffness, weft", "N/m"),
    "shear_stiffness": ("shear stiffness", "N/m"),
    "compression": ("of it in compression", ""),
    "poisson_ratio": ("Poisson ratio", ""),
    "bending_rigidity": ("bending rigidity", "µN m"),
    "bending_rigidity_weft": ("bending rigidity, weft", "µN m"),
    "bending_rigidity_bias": ("bending rigidity, bias", "µN m"),
    "bending_length": ("bending length", "mm"),
    "bending_hysteresis": ("bending hysteresis", "mN"),
    "bending_rigidity_initial": ("bending rigidity at first", "µN m"),
    "thickness": ("thickness", "mm"),
    "friction_table": ("friction on table", ""),
    "friction_cloth": ("friction on cloth", ""),
    "air_drag": ("air drag", "N s/m³"),
    "air_drag_normal": ("air drag, normal", "N s/m³"),
    "air_drag_tangential": ("air drag, tangential", "N s/m³"),
    "air_drag_quadratic": ("quadratic air drag", "kg/m³"),
    "air_drag_quadratic_tangential": ("quadratic air drag, tangential", "kg/m³"),
    "air_drag_turning": ("air drag after turning", "kg/m^(8/3)"),
    "air_added_mass": ("air carried along", "kg/m²"),
}
"""Name and unit for readers of each quantity of a material, by its field."""
EVERY = ("areal_density", "poisson_ratio", "friction_table", "friction_cloth")
"""Fields that are shown even if they are zero."""


def properties(material: Material) -> list[Quantity]:
    """Return the quantities of a material that are given and have an effect."""
    return [
        Quantity(name, value, unit)
        for field, (name, unit) in FIELDS.items()
        if (value := getattr(material, field)) is not None
        and (field in EVERY or (value and (field, value) != ("compression", 1.0)))
    ]


def filed_units() -> dict[str, str]:
    """Return the unit of each field in files, "-" for none."""
    return {field: filed(unit) or "-" for field, (_, unit) in FIELDS.items() if field in Material.model_fields}
