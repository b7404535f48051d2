"""Options of a calibration that a study may vary; the defaults are those of `tatamu calibrate`."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class CalibrationOptions:
    """Tolerances of matched readings, and the time for which the simulated cloth settles."""

    settled: float = 5e-5
    """Largest change of a settled reading over the last quarter of its scene [m]."""
    lengthening: float = 2.0
    """Factor by which a scene that has not settled is lengthened."""
    longest: float = 8.0
    """Largest duration of a scene over the duration that its test sets."""
    within: float = 1e-3
    """Largest difference between the simulated and the measured reading, as a fraction of the reading."""
    finest: float = 1e-5
    """Largest difference between the simulated and the measured reading, if larger than `within` gives [m]."""
    agreement: float = 5e-3
    """Largest change of the parameters' logarithms between passes that agree."""
    passes: int = 5
    """Largest number of passes over the tests at rest."""
    passes_with_friction: int = 10
    """Largest number of passes if friction of bending is measured. Friction changes the rigidity that follows from a
    sag by about as much again, so matching both takes more passes."""


DEFAULTS = CalibrationOptions()
"""Options of `tatamu calibrate`."""
