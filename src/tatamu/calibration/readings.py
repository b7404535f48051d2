"""Readings, with their uncertainties and units, and the tables of a measurements file that contain them.

A reading in a file is a number or a list of repeats. Readings in wrong units are refused.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import BeforeValidator, Field

from tatamu.base.arrays import is_finite_number
from tatamu.base.records import Record


def _readings(value: Any, largest: float, unit: str, smaller: str = "", nothing: bool = False) -> tuple[float, ...]:
    """Check one reading or several. One above `largest` is refused, because its unit must be wrong."""
    given = value if isinstance(value, list | tuple) else [value]
    if not given:
        raise ValueError("must contain at least one reading, given none")
    for each in given:
        if not is_finite_number(each):
            raise ValueError(f"must be a finite number of {unit}, or a list of such numbers, given {each!r}")
        if each < 0 or (each == 0 and not nothing):
            raise ValueError(f"must be {'at least 0' if nothing else 'above 0'}, given {each:g} {unit}")
        if each > largest:
            raise ValueError(
                f"must be at most {largest:g} {unit}, given {each:g}"
                + (f"; if the reading is in {smaller}, write {each / 1000:g}" if smaller else "")
                + (f"; if the reading is in centimetres, write {each / 100:g}" if unit == "metres" else "")
            )
    return tuple(float(each) for each in given)


_lengths = partial(_readings, largest=10.0, unit="metres", smaller="millimetres")
Lengths = Annotated[tuple[float, ...], BeforeValidator(_lengths)]
Distances = Annotated[tuple[float, ...], BeforeValidator(partial(_lengths, nothing=True))]
"""Type of a measured distance: one or more repeats [m], each of which may be 0."""
_masses = partial(_readings, largest=20.0, unit="kilograms", smaller="grams")
Masses = Annotated[tuple[float, ...], BeforeValidator(_masses)]
_times = partial(_readings, largest=600.0, unit="seconds", smaller="milliseconds")
Times = Annotated[tuple[float, ...], BeforeValidator(_times)]
_angles = partial(_readings, largest=180.0, unit="degrees", nothing=True)
Angles = Annotated[tuple[float, ...], BeforeValidator(_angles)]
"""Type of a measured angle: one or more repeats [degrees], each from 0 to 180."""
_counts = partial(_readings, largest=100.0, unit="swings")
Counts = Annotated[tuple[float, ...], BeforeValidator(_counts)]
"""Type of a number of swings: one or more repeats, each above 0 and at most 100."""
Length = Annotated[float, BeforeValidator(lambda value: _lengths([value])[0])]
Error = Annotated[float, Field(ge=1e-6, le=0.1)]


@dataclass(frozen=True)
class Reading:
    """The mean of the repeats of one reading."""

    value: float
    """Mean of the repeats, in `unit`."""
    uncertainty: float
    """Standard uncertainty of the mean, in `unit`."""
    repeats: int = 1
    unit: str = "m"
    """Unit of the reading: m, kg, s or "-"."""

    @classmethod
    def of(cls, values: tuple[float, ...], error: float, unit: str = "m") -> Reading:
        """Return a reading from its repeats, each with the standard deviation `error`."""
        return cls(float(np.mean(values)), uncertainty(values, error), len(values), unit)


def uncertainty(readings: tuple[float, ...], error: float) -> float:
    """Return the standard uncertainty of the mean of readings, each with `error`, or their scatter if larger."""
    scatter = float(np.std(readings, ddof=1)) if len(readings) > 2 else 0.0
    return max(error, scatter) / float(np.sqrt(len(readings)))


class Errors(Record):
    """Standard deviations of single readings, from all causes: the marks of the ruler, the eye, the cloth's motion."""

    length: Error = 0.001
    """Standard deviation of every length except H_s [m]."""
    mass: Error = 0.001
    """Standard deviation of the mass [kg]."""
    H_s: Error = 0.005
    """Standard deviation of H_s [m]."""
    time: Annotated[float, Field(ge=1e-3, le=10.0)] = 0.3
    """Standard deviation of the time of ten swings, by a stopwatch [s]."""
    swings: Annotated[float, Field(ge=1e-2, le=10.0)] = 0.3
    """Standard deviation of the number of swings [-]."""
    drape: Error = 0.03
    """Standard deviation of a drape coefficient [-]."""
    angle: Annotated[float, Field(ge=0.1, le=45.0)] = 4.0
    """Standard deviation of the angle that remains in a crease [degrees]."""


ERROR_UNITS = {"time": "s", "swings": "-"}
"""Units of the fields of `Errors` for readings; m for others."""


class TestEntry(Record):
    """The table of one test in a measurements file: its readings, and how the cloth was held."""

    taken: ClassVar[Mapping[str, tuple[str, str]]] = {}
    """By the name of each reading: its field, and the field of `Errors` that states its standard deviation."""

    def readings(self, errors: Errors) -> dict[str, Reading]:
        """Return the readings by their names. No other test uses the same names."""
        return {
            name: Reading.of(getattr(self, field), getattr(errors, error), ERROR_UNITS.get(error, "m"))
            for name, (field, error) in self.taken.items()
        }
