"""The match of a test."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Fit:
    """One test, and the parameter with which the simulation reproduces its reading."""

    test: str
    parameter: str
    measured: float
    """The reading, in `unit`."""
    uncertainty: float
    """Standard uncertainty of the reading."""
    aim: float
    """Value that was matched: the reading, shifted by its uncertainty if it only bounds the parameter."""
    simulated: float
    """The same reading, simulated with the parameter found."""
    unit: str
    bound: str | None
    """None if the test determines the parameter, "at least" or "at most" if it only bounds it."""
    samples: tuple[tuple[float, float], ...]
    """Simulated (parameter, reading); of a search by halving (parameter, speed)."""
    alone: float | None = None
    """The parameter by this test alone; None if the test alone determined the parameter. Otherwise the test is one of
    several, or a bound that the assumed value satisfies."""
    resolution: float | None = None
    """Standard uncertainty of the parameter's logarithm after a bisection; None if there was none."""

    @property
    def slope(self) -> float | None:
        """Change of the reading with the parameter's logarithm; None if there are fewer than two samples.

        The slope is fitted to the three samples nearest to the aim.
        """
        nearest = sorted(self.samples, key=lambda sample: abs(sample[1] - self.aim))[:3]
        if len(nearest) < 2:
            return None
        return float(np.polyfit(np.log([sample[0] for sample in nearest]), [sample[1] for sample in nearest], 1)[0])
