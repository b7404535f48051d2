"""How far one disturbance alone may go: to where the fold still holds far out, or by halving to where it fails."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass

from tatamu.disturbances import Channel, World
from tatamu.folding.score import Limits
from tatamu.robustness import Verdict, WorldSearch

FARTHEST = 6.0
"""How far is tried, in standard deviations: what is normal goes beyond in two of a thousand million."""
NEAR = 2.0
"""Where a fold that fails there is asked next: most margins that are found are less than this."""
HALVINGS = 3
"""Of what is then left."""


@dataclass(frozen=True)
class Side:
    """One disturbance in one direction."""

    channel: Channel
    deviation: float
    sign: float

    def world(self, deviations: float) -> World:
        """Return the world with this disturbance alone, by this many standard deviations."""
        return World({self.channel.name: self.sign * deviations * self.deviation})

    def shown(self, deviations: float) -> float:
        """The value as people read it."""
        return self.channel.shown(self.sign * deviations * self.deviation)

    def search(self, limits: Limits) -> WorldSearch:
        """Find the farthest value at which the fold still holds; None where it holds at the farthest that is tried."""
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
