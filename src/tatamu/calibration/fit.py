"""The result of one calibration test."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Fit:
    """The result of one test: the parameter with which the simulation reproduces the reading."""

    test: str
    parameter: str
    measured: float
    """The measured reading, in `unit`."""
    uncertainty: float
    """Standard uncertainty of the measured reading, in `unit`."""
    aim: float
    """Value of the reading that the simulation had to reproduce.

    The value is the measured reading. If the reading only bounds the parameter, the value is the measured reading
    shifted by its uncertainty.
    """
    simulated: float
    """The simulated reading, with the parameter that was found."""
    unit: str
    bound: str | None
    """Bound of the parameter, "at least" or "at most"; None if the test determines the value of the parameter."""
    samples: tuple[tuple[float, float], ...]
    """Values of the parameter that were simulated, each with its reading.

    In the friction test, each value has the simulated speed of a sheet [m/s] instead of a reading.
    """
    alone: float | None = None
    """Value of the parameter that follows from this test without other tests.

    A value is given if several tests determine the parameter. It is also given if the test only bounds the parameter,
    and the value that was assumed before satisfies this bound. Otherwise it is None, because the material's value is
    from this test only.
    """
    resolution: float | None = None
    """Standard uncertainty of the parameter's logarithm due to the width of the last interval of a bisection.

    None if the parameter was found without bisection.
    """

    @property
    def slope(self) -> float | None:
        """Derivative of the simulated reading by the parameter's logarithm; None if there are fewer than two samples.

        The derivative is fitted to the three samples whose readings are nearest to `aim`.
        """
        nearest = sorted(self.samples, key=lambda sample: abs(sample[1] - self.aim))[:3]
        if len(nearest) < 2:
            return None
        return float(np.polyfit(np.log([sample[0] for sample in nearest]), [sample[1] for sample in nearest], 1)[0])
