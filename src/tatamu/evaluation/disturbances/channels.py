"""The disturbances, by name: each is one normally distributed number."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

SHOWN = {"m": (1e3, " mm"), "rad": (180.0 / np.pi, "°"), "s": (1e3, " ms"), "1": (100.0, " %")}
"""Units of disturbances, each with the factor to the unit that readers see, and the latter."""
DIRECTIONS = ("along", "across", "up")
PARTS = {"along": 0, "across": 1, "up": 2, "left": 0, "right": 1}
"""Places in the lists of a file of disturbances, by the last words of names."""


@dataclass(frozen=True)
class Channel:
    """One disturbance."""

    name: str
    """Name in `margins.json`, such as "hands.offset.up"."""
    unit: str
    """Unit: m, rad, s, or 1 for the logarithm of a factor."""
    title: str
    """What a positive value means."""

    def shown(self, value: float) -> float:
        """Return a value as files have it: the factor minus 1, a relative change, for the logarithm of a factor."""
        return float(np.expm1(value)) if self.unit == "1" else value

    def text(self, value: float) -> str:
        """Return a shown value with its sign and unit for readers."""
        scale, unit = SHOWN[self.unit]
        return f"{scale * value:+.3g}".replace("-", "−") + unit

    def spread(self, deviation: float) -> str:
        """Return a standard deviation with its unit for readers."""
        return self.text(deviation).lstrip("+")


MATERIAL = {
    "areal_density": "cloth heavier",
    "stretch_stiffness": "stiffer to stretch",
    "poisson_ratio": "greater Poisson ratio",
    "compression": "stiffer to compress",
    "bending_rigidity": "stiffer to bend",
    "thickness": "thicker",
    "friction_table": "more friction on the table",
    "friction_cloth": "more friction on cloth",
    "air_drag": "more air drag",
    "air_drag_normal": "more air drag along the normal",
    "air_drag_tangential": "more air drag along the surface",
    "air_drag_quadratic": "more quadratic air drag along the normal",
    "air_drag_quadratic_tangential": "more quadratic air drag along the surface",
    "air_added_mass": "more air carried along",
    "stretch_stiffness_weft": "stiffer to stretch along the weft",
    "shear_stiffness": "stiffer to shear",
    "bending_rigidity_weft": "stiffer to bend along the weft",
    "bending_rigidity_bias": "stiffer to bend along the bias",
    "bending_hysteresis": "more hysteresis of bending",
    "bending_rigidity_initial": "stiffer to bend at first",
    "air_drag_turning": "more air drag after turning around",
}
"""Fields of a material that may be disturbed. New ones are appended, because otherwise all random draws change."""
FIELDS = tuple(MATERIAL)

CHANNELS = (
    Channel("hands.offset.along", "m", "both hands too far along the fold"),
    Channel("hands.offset.across", "m", "both hands too far to the left"),
    Channel("hands.offset.up", "m", "both hands too high"),
    Channel("hands.difference.along", "m", "left hand farther along than the right"),
    Channel("hands.difference.across", "m", "hands too far apart"),
    Channel("hands.difference.up", "m", "left hand higher than the right"),
    Channel("hands.yaw", "rad", "pair of hands turned"),
    Channel("hands.opening_delay", "s", "left hand opens after the right"),
    Channel("hands.speed", "1", "hands too fast"),
    Channel("grasp.along.left", "m", "left grasp too far along the edge"),
    Channel("grasp.along.right", "m", "right grasp too far along the edge"),
    Channel("grasp.into.left", "m", "left grasp too far in"),
    Channel("grasp.into.right", "m", "right grasp too far in"),
    Channel("cloth.place.along", "m", "cloth too far along the fold"),
    Channel("cloth.place.across", "m", "cloth too far to the left"),
    Channel("cloth.yaw", "rad", "cloth turned"),
    Channel("table.height", "m", "table too high"),
    *(Channel(f"material.{name}", "1", title) for name, title in MATERIAL.items()),
)
"""All disturbances, in the order of their random numbers. New ones are appended for the same reason."""
PLACES = {channel.name: place for place, channel in enumerate(CHANNELS)}


def channel_of(name: str) -> Channel:
    """Return the disturbance with a name."""
    return CHANNELS[PLACES[name]]


def prefix_in(name: str, prefixes: Iterable[str]) -> str | None:
    """Return the longest prefix with which a name begins, by whole words between dots; None if there is none."""
    fitting = [prefix for prefix in prefixes if f"{name}.".startswith(f"{prefix}.")]
    return max(fitting, key=len, default=None)
