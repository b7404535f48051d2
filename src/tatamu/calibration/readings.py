"""Readings as values with standard uncertainties."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Reading:
    """The mean of one reading's repeats."""

    value: float
    """Mean of the repeats, in `unit`."""
    uncertainty: float
    """Standard uncertainty of the mean."""
    repeats: int = 1
    unit: str = "m"
    """One of `quantity.SHOWN`."""

    @classmethod
    def of(cls, values: tuple[float, ...], error: float, unit: str = "m") -> Reading:
        """The mean of repeats, each with this standard deviation."""
        return cls(float(np.mean(values)), uncertainty(values, error), len(values), unit)


def uncertainty(readings: tuple[float, ...], error: float) -> float:
    """Standard uncertainty of the mean: the stated error, or the scatter of repeats if larger, over sqrt(n)."""
    scatter = float(np.std(readings, ddof=1)) if len(readings) > 2 else 0.0
    return max(error, scatter) / float(np.sqrt(len(readings)))
