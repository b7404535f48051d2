"""Readings as values with standard uncertainties."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tatamu.calibration.measurements import Measurements, uncertainty


@dataclass(frozen=True)
class Reading:
    """The mean of one reading's repeats."""

    value: float
    """[m] or [kg]"""
    uncertainty: float
    """Standard uncertainty of the mean [m] or [kg]."""
    repeats: int = 1


def readings_of(measurements: Measurements) -> dict[str, Reading]:
    """Every reading by the name it has in the file."""
    errors, found = measurements.errors, {"mass": _reading(measurements.garment.mass, measurements.errors.mass)}
    if measurements.garment.size is not None:
        for name, side in zip(("width", "length"), measurements.garment.size, strict=True):
            found[name] = _reading((side,), errors.length)
    if measurements.elongation is not None:
        found["L1"] = _reading(measurements.elongation.L1, errors.length)
        found["L2"] = _reading(measurements.elongation.L2, errors.length)
    if measurements.friction is not None:
        found["L_t"] = _reading(measurements.friction.L_t, errors.length)
        found["H_s"] = _reading(measurements.friction.H_s, errors.H_s)
    if measurements.sag is not None:
        found["free_length"] = _reading(measurements.sag.free_length, errors.length)
        found["sag"] = _reading(measurements.sag.sag, errors.length)
    if measurements.loop is not None:
        found["height"] = _reading(measurements.loop.height, errors.length)
    if measurements.push is not None:
        found["push_length"] = _reading(measurements.push.length, errors.length)
        found["pushed"] = _reading(measurements.push.pushed, errors.length)
        found["moved"] = _reading(measurements.push.moved, errors.length)
    return found


def _reading(values: tuple[float, ...], error: float) -> Reading:
    return Reading(float(np.mean(values)), uncertainty(values, error), len(values))
