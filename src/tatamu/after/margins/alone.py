"""The range of one disturbance in which a fold succeeds, found by bisection."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass

from tatamu.evaluation.disturbances import NOMINAL, Channel, World
from tatamu.evaluation.outcome import Outcome
from tatamu.folding.score import Limits

MAX_DEVIATIONS = 3.0
"""Largest disturbance that is tried, in deviations. Larger ones occur once in 400 folds."""
HALVINGS = 3
"""Bisections of a range. The last range is an eighth of `MAX_DEVIATIONS`, 0.4 deviations."""

Bisection = Generator[World, Outcome, float | None]
"""Yields scenarios, receives their outcomes, and returns the last value that succeeds; None if all do."""


@dataclass(frozen=True)
class Side:
    """One direction of one disturbance, from its mean."""

    channel: Channel
    deviation: float
    sign: float
    centre: World = NOMINAL

    def scenario(self, deviations: float) -> World:
        """Return the scenario in which only this disturbance differs from its mean."""
        return World({**self.centre.values, self.channel.name: self._value(deviations)})

    def shown(self, deviations: float) -> float:
        """Return a disturbance as files have it."""
        return self.channel.shown(self._value(deviations))

    def _value(self, deviations: float) -> float:
        return self.centre[self.channel.name] + self.sign * deviations * self.deviation

    def bisect(self, limits: Limits) -> Bisection:
        """Find the largest disturbance at which the fold still succeeds."""
        if limits.hold((yield self.scenario(MAX_DEVIATIONS))):
            return None
        low, high = 0.0, MAX_DEVIATIONS
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            succeeds = limits.hold((yield self.scenario(middle)))
            low, high = (middle, high) if succeeds else (low, middle)
        return self.shown(low)
