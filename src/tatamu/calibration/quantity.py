"""Readings in a file: a number or a list of repeats. Readings in wrong units are refused."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, Field

LONGEST, HEAVIEST = 10.0, 20.0
"""Largest length [m] and mass [kg] of a garment. Larger values are refused, because their unit must be wrong."""
LATEST = 600.0
"""Largest measured time [s]. Larger values are refused, because their unit must be wrong."""
FARTHEST = 180.0
"""Largest angle of a fold [degrees]: the angle of a closed fold."""
SHOWN = {"m": (1e3, "mm"), "kg": (1e3, "g"), "s": (1.0, "s"), "-": (1.0, "")}
"""Factor and unit with which pages show a reading, by the unit of the reading."""


def _readings(value: Any, largest: float, unit: str, smaller: str, nothing: bool = False) -> tuple[float, ...]:
    given = value if isinstance(value, list | tuple) else [value]
    if not given:
        raise ValueError("must hold at least one reading, given none")
    for each in given:
        if isinstance(each, bool) or not isinstance(each, int | float) or not abs(each) < np.inf:
            raise ValueError(f"must be a finite number of {unit}, or a list of them, given {each!r}")
        if each < 0 or (each == 0 and not nothing):
            raise ValueError(f"must be {'at least 0' if nothing else 'more than nothing'}, given {each:g} {unit}")
        if each > largest:
            raise ValueError(
                f"must be in {unit}, at most {largest:g}, given {each:g}: if that was read in {smaller}, "
                f"write {each / 1000:g}" + (f"; in centimetres, {each / 100:g}" if unit == "metres" else "")
            )
    return tuple(float(each) for each in given)


def _lengths(value: Any) -> tuple[float, ...]:
    return _readings(value, LONGEST, "metres", "millimetres")


def _distances(value: Any) -> tuple[float, ...]:
    return _readings(value, LONGEST, "metres", "millimetres", nothing=True)


def _masses(value: Any) -> tuple[float, ...]:
    return _readings(value, HEAVIEST, "kilograms", "grams")


def _times(value: Any) -> tuple[float, ...]:
    return _readings(value, LATEST, "seconds", "milliseconds")


def _angles(value: Any) -> tuple[float, ...]:
    given = _readings(value, np.inf, "degrees", "", nothing=True)
    if max(given) > FARTHEST:
        raise ValueError(f"must be in degrees, at most {FARTHEST:g}, given {max(given):g}")
    return given


def _length(value: Any) -> float:
    return _lengths([value])[0]


Lengths = Annotated[tuple[float, ...], BeforeValidator(_lengths)]
Distances = Annotated[tuple[float, ...], BeforeValidator(_distances)]
"""Type of a measured distance: one or more repeats [m], each of which may be 0."""
Masses = Annotated[tuple[float, ...], BeforeValidator(_masses)]
Times = Annotated[tuple[float, ...], BeforeValidator(_times)]
Angles = Annotated[tuple[float, ...], BeforeValidator(_angles)]
"""Type of a measured angle: one or more repeats [degrees], each from 0 to 180."""
Length = Annotated[float, BeforeValidator(_length)]
Error = Annotated[float, Field(ge=1e-6, le=0.1)]
