"""How a test was matched."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Fit:
    """One test, and the parameter with which its reading came out."""

    test: str
    parameter: str
    measured: float
    """The reading: L1 - L2 [m], theta [rad], sag [m], height of the loop [m], how far the far edge moved [m]."""
    uncertainty: float
    """Its standard uncertainty."""
    aim: float
    """What was matched: the reading, or where it bounds the parameter, that moved by its uncertainty."""
    simulated: float
    """The same reading, simulated with the parameter found."""
    unit: str
    bound: str | None
    """None where the test tells the parameter; else "at least" or "at most": all that it tells."""
    samples: tuple[tuple[float, float], ...]
    """Simulated (parameter, reading); of friction (parameter, speed)."""
    alone: float | None = None
    """What this test alone says of the parameter, where it did not decide alone: of several tests that tell it, or of a
    bound that what was assumed keeps."""
    resolution: float | None = None
    """Standard uncertainty of the parameter's logarithm that a search by halving leaves; None: no such search."""
