"""How a test was matched."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Fit:
    """One test, and the parameter with which its reading came out."""

    test: str
    parameter: str
    measured: float
    """The reading, in `unit`."""
    uncertainty: float
    """Its standard uncertainty."""
    aim: float
    """The value that was matched: the reading, moved by its uncertainty where it only bounds the parameter."""
    simulated: float
    """The same reading, simulated with the parameter found."""
    unit: str
    bound: str | None
    """None where the test tells the parameter; else "at least" or "at most": all that it tells."""
    samples: tuple[tuple[float, float], ...]
    """Simulated (parameter, reading); of a search by halving (parameter, speed)."""
    alone: float | None = None
    """The parameter by this test alone, where it did not decide alone: as one of several tests, or as a bound that the
    assumed value keeps."""
    resolution: float | None = None
    """Standard uncertainty of the parameter's logarithm that a search by halving leaves; None: no such search."""

    @property
    def slope(self) -> float | None:
        """Change of the reading with the parameter's logarithm; None where fewer than two samples tell it.

        Of the three nearest to what was matched.
        """
        nearest = sorted(self.samples, key=lambda sample: abs(sample[1] - self.aim))[:3]
        if len(nearest) < 2:
            return None
        return float(np.polyfit(np.log([sample[0] for sample in nearest]), [sample[1] for sample in nearest], 1)[0])
