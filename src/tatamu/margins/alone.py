"""How far one disturbance alone may go: outwards in leaps until the fold fails, then by halving."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass

from tatamu.disturbances import Channel, Limits, Verdict, World

LEAPS = (2.0, 8.0)
"""How far is tried, in standard deviations."""
HALVINGS = 3
"""Of the leap in which the fold fails."""

Asking = Generator[World, Verdict, float | None]
"""Yields worlds, is sent how the fold ends in them, and returns the farthest value at which it held."""


@dataclass(frozen=True)
class Side:
    """One disturbance in one direction."""

    channel: Channel
    deviation: float
    sign: float

    def world(self, leap: float) -> World:
        """The world in which it alone is off, by so many deviations."""
        return World({self.channel.name: self.sign * leap * self.deviation})

    def shown(self, leap: float) -> float:
        """The value as people read it."""
        return self.channel.shown(self.sign * leap * self.deviation)

    def search(self, limits: Limits) -> Asking:
        """Find the farthest value at which the fold still holds; None where it never fails."""
        low = 0.0
        for leap in LEAPS:
            if not (yield self.world(leap)).holds(limits):
                return self.shown((yield from self._halved(low, leap, limits)))
            low = leap
        return None

    def _halved(self, low: float, high: float, limits: Limits) -> Generator[World, Verdict, float]:
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            held = (yield self.world(middle)).holds(limits)
            low, high = (middle, high) if held else (low, middle)
        return low
