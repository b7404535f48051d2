"""Readings: values with standard uncertainties."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Reading:
    """The mean of the repeats of one reading."""

    value: float
    """Mean of the repeats, in `unit`."""
    uncertainty: float
    """Standard uncertainty of the mean, in `unit`."""
    repeats: int = 1
    unit: str = "m"
    """Unit of the reading, one of `quantity.SHOWN`."""

    @classmethod
    def of(cls, values: tuple[float, ...], error: float, unit: str = "m") -> Reading:
        """Return a reading from its repeats, each with the standard deviation `error`."""
        return cls(float(np.mean(values)), uncertainty(values, error), len(values), unit)


def uncertainty(readings: tuple[float, ...], error: float) -> float:
    """Return the standard uncertainty of the mean of n readings.

    The result is `error`, the standard deviation of one reading, divided by sqrt(n). If the scatter of the readings is
    larger than `error`, the scatter is used instead.
    """
    scatter = float(np.std(readings, ddof=1)) if len(readings) > 2 else 0.0
    return max(error, scatter) / float(np.sqrt(len(readings)))
