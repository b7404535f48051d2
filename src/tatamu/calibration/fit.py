"""The result of matching one test."""

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
    """Standard uncertainty of the reading."""
    aim: float
    """Value that was matched.

    It is the reading itself. If the reading only bounds the parameter, the value is shifted by the reading's
    uncertainty.
    """
    simulated: float
    """The simulated reading, with the parameter that was found."""
    unit: str
    bound: str | None
    """None if the test determines the parameter; "at least" or "at most" if it only bounds the parameter."""
    samples: tuple[tuple[float, float], ...]
    """Pairs of a parameter and its simulated reading. A search by bisection has pairs of a parameter and a speed."""
    alone: float | None = None
    """Value of the parameter by this test alone; None if only this test determined the parameter.

    A value is given if several tests determine the parameter, or if the test's bound is satisfied by the value that was
    assumed before.
    """
    resolution: float | None = None
    """Standard uncertainty of the parameter's logarithm due to a bisection; None if the search was no bisection."""

    @property
    def slope(self) -> float | None:
        """Change of the reading with the parameter's logarithm; None if there are fewer than two samples.

        The slope is fitted to the three samples whose readings are nearest to the aim.
        """
        nearest = sorted(self.samples, key=lambda sample: abs(sample[1] - self.aim))[:3]
        if len(nearest) < 2:
            return None
        return float(np.polyfit(np.log([sample[0] for sample in nearest]), [sample[1] for sample in nearest], 1)[0])
