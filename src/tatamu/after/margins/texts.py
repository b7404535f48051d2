"""Texts that describe disturbances and margins, for the terminal and the page."""

from __future__ import annotations

from tatamu.evaluation.success import AloneMargin, MarginsRecord

TITLES = {
    "hands.offset.along": "both hands too far along the fold",
    "hands.offset.across": "both hands too far to the left",
    "hands.offset.up": "both hands too high",
    "hands.difference.along": "left hand farther along than the right",
    "hands.difference.across": "hands too far apart",
    "hands.difference.up": "left hand higher than the right",
    "hands.yaw": "pair of hands turned",
    "hands.opening_delay": "left hand opens after the right",
    "hands.speed": "hands too fast",
    "grasp.along.left": "left grasp too far along the edge",
    "grasp.along.right": "right grasp too far along the edge",
    "grasp.into.left": "left grasp too far in",
    "grasp.into.right": "right grasp too far in",
    "cloth.place.along": "cloth too far along the fold",
    "cloth.place.across": "cloth too far to the left",
    "cloth.yaw": "cloth turned",
    "table.height": "table too high",
    "material.areal_density": "cloth heavier",
    "material.stretch_stiffness": "stiffer to stretch",
    "material.poisson_ratio": "greater Poisson ratio",
    "material.compression": "stiffer to compress",
    "material.bending_rigidity": "stiffer to bend",
    "material.thickness": "thicker",
    "material.friction_table": "more friction on the table",
    "material.friction_cloth": "more friction on cloth",
    "material.air_drag": "more air drag",
    "material.air_drag_normal": "more air drag along the normal",
    "material.air_drag_tangential": "more air drag along the surface",
    "material.air_drag_quadratic": "more quadratic air drag along the normal",
    "material.air_drag_quadratic_tangential": "more quadratic air drag along the surface",
    "material.stretch_stiffness_weft": "stiffer to stretch along the weft",
    "material.shear_stiffness": "stiffer to shear",
    "material.bending_rigidity_weft": "stiffer to bend along the weft",
    "material.bending_rigidity_bias": "stiffer to bend along the bias",
    "material.bending_hysteresis": "more hysteresis of bending",
    "material.bending_rigidity_initial": "stiffer to bend at first",
    "material.air_drag_turning": "more air drag after turning around",
    "material.air_added_mass": "more air carried along",
}
"""Texts that say what a positive value of each disturbance means."""
SHOWN = {"m": (1e3, "mm"), "rad": (180.0 / 3.141592653589793, "°"), "s": (1e3, "ms"), "1": (100.0, "%")}
"""Units in which readers see values, by the units in files.

Each entry has the factor that converts a value, and the name of the unit for readers.
"""


def amount(value: float, unit: str) -> str:
    """Return the value of a disturbance with its sign and unit, as text."""
    scale, name = SHOWN[unit]
    space = "" if name == "°" else " "
    return f"{scale * value:+.3g}".replace("-", "−") + space + name


def reach(margin: AloneMargin) -> tuple[str, str]:
    """Return the lowest and the highest tolerated value of a disturbance, as two texts."""
    return _side(margin.low, margin.tried[0], margin.unit), _side(margin.high, margin.tried[1], margin.unit)


def _side(end: float | None, tried: float, unit: str) -> str:
    return f"beyond {amount(tried, unit)}" if end is None else amount(end, unit)


def simulated(margins: MarginsRecord) -> str:
    """Return how many simulations were made, and on which mesh."""
    mesh = "" if margins.spacing is None else f" on a mesh of {1e3 * margins.spacing:.3g} mm"
    return f"{margins.simulations} simulations in {margins.simulator}{mesh}"
