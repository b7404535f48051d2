"""The disturbances, by name: each is one normally distributed number."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

FIELDS = (
    "areal_density",
    "stretch_stiffness",
    "poisson_ratio",
    "compression",
    "bending_rigidity",
    "thickness",
    "friction_table",
    "friction_cloth",
    "air_drag",
    "air_drag_normal",
    "air_drag_tangential",
    "air_drag_quadratic",
    "air_drag_quadratic_tangential",
    "air_added_mass",
    "stretch_stiffness_weft",
    "shear_stiffness",
    "bending_rigidity_weft",
    "bending_rigidity_bias",
    "bending_hysteresis",
    "bending_rigidity_initial",
    "air_drag_turning",
)
"""Fields of a material that may be disturbed. New ones are appended, because otherwise all random draws change."""

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

    @property
    def relative(self) -> bool:
        """Whether the number is the logarithm of a factor."""
        return self.unit == "1"

    def shown(self, value: float) -> float:
        """Return a value as readers see it: the factor minus 1, a relative change, for the logarithm of a factor."""
        return float(np.expm1(value)) if self.relative else value


CHANNELS = (
    *(Channel(f"hands.offset.{direction}", "m") for direction in DIRECTIONS),
    *(Channel(f"hands.difference.{direction}", "m") for direction in DIRECTIONS),
    Channel("hands.yaw", "rad"),
    Channel("hands.opening_delay", "s"),
    Channel("hands.speed", "1"),
    Channel("grasp.along.left", "m"),
    Channel("grasp.along.right", "m"),
    Channel("grasp.into.left", "m"),
    Channel("grasp.into.right", "m"),
    Channel("cloth.place.along", "m"),
    Channel("cloth.place.across", "m"),
    Channel("cloth.yaw", "rad"),
    Channel("table.height", "m"),
    *(Channel(f"material.{name}", "1") for name in FIELDS),
)
"""All disturbances, in the order of their random numbers. New ones are appended for the same reason."""
PLACES = {channel.name: number for number, channel in enumerate(CHANNELS)}


def prefix_in(name: str, prefixes: Iterable[str]) -> str | None:
    """Return the longest prefix with which a name begins, by whole words between dots; None if there is none."""
    fitting = [prefix for prefix in prefixes if f"{name}.".startswith(f"{prefix}.")]
    return max(fitting, key=len, default=None)
