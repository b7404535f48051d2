"""The range of one disturbance alone: up to `FARTHEST` if the fold still holds there, otherwise found by bisection."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass

from tatamu.disturbances import NOMINAL, Channel, World
from tatamu.folding.score import Limits
from tatamu.robustness import Verdict, WorldSearch

FARTHEST = 6.0
"""Farthest value tried, in standard deviations; a normal variable is beyond it in two of a thousand million draws."""
NEAR = 2.0
"""Value tried next if the fold fails at `FARTHEST`, in standard deviations; most ranges end below it."""
HALVINGS = 3
"""Number of bisections of the remaining interval."""


@dataclass(frozen=True)
class Side:
    """One disturbance in one direction."""

    channel: Channel
    deviation: float
    sign: float
    centre: World = NOMINAL
    """The world of the means."""

    def world(self, deviations: float) -> World:
        """Return the world with this disturbance alone, by this many standard deviations from its mean."""
        return World({**self.centre.values, self.channel.name: self._value(deviations)})

    def shown(self, deviations: float) -> float:
        """Return the value for readers."""
        return self.channel.shown(self._value(deviations))

    def _value(self, deviations: float) -> float:
        return self.centre[self.channel.name] + self.sign * deviations * self.deviation

    def search(self, limits: Limits) -> WorldSearch:
        """Find the farthest value at which the fold still holds; None if it holds at `FARTHEST`."""
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
