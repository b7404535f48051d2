"""Finds the range of a single disturbance within which a fold succeeds.

The farthest value that is tried is `FARTHEST` standard deviations away from the mean. If the fold succeeds at this
value, the range ends there. Otherwise the end of the range is found by bisection.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass

from tatamu.evaluation.disturbances import NOMINAL, Channel, World
from tatamu.evaluation.robustness import Verdict, WorldSearch
from tatamu.folding.score import Limits

FARTHEST = 6.0
"""Farthest value of a disturbance that is tried, in standard deviations from its mean.

A normally distributed number is even farther from its mean with a probability of 2e-9."""
NEAR = 2.0
"""Value of a disturbance that is tried next if the fold fails at `FARTHEST`, in standard deviations.

Most ranges of tolerated values end below this value."""
HALVINGS = 3
"""Number of bisections that locate the end of the range of tolerated values."""


@dataclass(frozen=True)
class Side:
    """A search along one disturbance, below or above its mean, while the other disturbances keep their means."""

    channel: Channel
    deviation: float
    sign: float
    centre: World = NOMINAL
    """The world (value of every disturbance) in which all disturbances have their means."""

    def world(self, deviations: float) -> World:
        """Return the world (value of every disturbance) in which only this disturbance deviates from its mean.

        `deviations` is the distance from the mean in standard deviations.
        """
        return World({**self.centre.values, self.channel.name: self._value(deviations)})

    def shown(self, deviations: float) -> float:
        """Return the disturbance's value at `deviations` standard deviations from its mean, in the unit for readers."""
        return self.channel.shown(self._value(deviations))

    def _value(self, deviations: float) -> float:
        return self.centre[self.channel.name] + self.sign * deviations * self.deviation

    def search(self, limits: Limits) -> WorldSearch:
        """Find the disturbance's farthest value at which the fold still succeeds.

        The result is None if the fold succeeds at `FARTHEST`.
        """
        if limits.hold((yield self.world(FARTHEST))):
            return None
        near = limits.hold((yield self.world(NEAR)))
        low, high = (NEAR, FARTHEST) if near else (0.0, NEAR)
        return self.shown((yield from self._halved(low, high, limits)))

    def _halved(self, low: float, high: float, limits: Limits) -> Generator[World, Verdict, float]:
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            held = limits.hold((yield self.world(middle)))
            low, high = (middle, high) if held else (low, middle)
        return low
