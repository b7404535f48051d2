"""Readings of a towel, as a measurement file has them."""

from __future__ import annotations

from typing import Any

from tatamu.base.files import validated
from tatamu.calibration import Measurements


def of_towel(size: tuple[float, float], density: float, thickness: float | None = None, **tables: Any) -> Measurements:
    """Return tables of readings beside the towel's own, whose mass is that of cloth of a density [kg/m²]."""
    garment = {"name": "towel", "size": size, "mass": density * size[0] * size[1]}
    garment |= {} if thickness is None else {"thickness": thickness}
    return validated(Measurements, {"garment": garment, **tables}, "readings.toml")
