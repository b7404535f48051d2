"""Options of a calibration that an experiment can vary. The defaults are the options of `tatamu calibrate`."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class CalibrationOptions:
    """Tolerances of simulated readings, and limits of the time in which the simulated cloth comes to rest."""

    settled: float = 5e-5
    """Largest change of a reading over the last quarter of its simulation if the cloth is at rest [m].

    If the change is larger, the simulation is lengthened.
    """
    lengthening: float = 2.0
    """Factor by which a simulation is lengthened if its cloth has not come to rest."""
    longest: float = 8.0
    """Largest duration of a simulation, as a multiple of the duration that its test sets."""
    within: float = 1e-3
    """Largest accepted difference between the simulated and the measured reading, as a fraction of the reading."""
    finest: float = 1e-5
    """Smallest tolerance of a simulated reading [m].

    The tolerance is `within` times the measured reading. If this product is smaller than `finest`, the tolerance is
    `finest`."""
    agreement: float = 5e-3
    """Largest change of a parameter's logarithm in the last pass over the tests.

    The search ends after a pass in which no parameter changes by more.
    """
    passes: int = 5
    """Largest number of passes over the tests whose readings are lengths of cloth at rest.

    A pass finds the parameter of each test once.
    """
    passes_with_friction: int = 10
    """Largest number of passes if the friction of bending is measured.

    More passes are needed, because the friction changes the rigidity that follows from a sag.
    """


DEFAULTS = CalibrationOptions()
"""Options of the command `tatamu calibrate`."""
