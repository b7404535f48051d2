"""The fidelity of each trial of a study, and when the study ends."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from tatamu.search.search import HIGH, LOW, Proposal

Trials = int | Literal["auto"]
"""Number of trials of a study, or "auto" to stop when little improvement is expected."""


@dataclass(frozen=True)
class Schedule:
    """The order of the trials of one study."""

    trials: Trials
    fidelities: int = 1
    """1, or 2 if a search starts at low fidelity."""
    high_share: float = 0.12
    """With two fidelities, the fraction of the trials that runs at high fidelity, after the trials at low fidelity."""
    least_high: int = 5
    """Least number of trials at high fidelity."""
    least_gain: float = 0.001
    """With "auto": a search has converged if the expected gain is below this fraction of the best objective ..."""
    in_a_row: int = 3
    """... by this many proposals in a row."""
    most_auto: int = 100
    """With "auto": the largest number of trials."""
    most_high: int = 20
    """With "auto" and two fidelities: the largest number of trials at high fidelity."""

    @property
    def most(self) -> int:
        """The largest number of trials."""
        return self.most_auto if self.trials == "auto" else self.trials

    @property
    def until_gain(self) -> float | None:
        """The expected gain below which the search ends by itself; None if the number of trials is given."""
        return self.least_gain if self.trials == "auto" else None

    def next_fidelity(self, before: Sequence[Proposal]) -> int | None:
        """Return the fidelity of the next trial; None if there is no next one.

        Args:
            before: The proposals of all earlier trials in order, pending trials included.
        """
        if len(before) >= self.most:
            return None
        if self.trials == "auto":
            return self._next_of_auto(before)
        high = max(self.least_high, math.ceil(self.high_share * self.trials))
        low_next = self.fidelities == 2 and self.trials >= 2 * high and len(before) < self.trials - high
        return LOW if low_next else HIGH

    def _next_of_auto(self, before: Sequence[Proposal]) -> int | None:
        high = [each.gain for each in before if each.fidelity == HIGH]
        if self.fidelities == 1:
            return None if self._converged(high) else HIGH
        if not high:
            enough = self._converged([each.gain for each in before]) or len(before) >= self.most_auto - self.most_high
            return HIGH if enough else LOW
        return None if self._converged(high) or len(high) >= self.most_high else HIGH

    def _converged(self, gains: Sequence[float | None]) -> bool:
        last = gains[-self.in_a_row :]
        return len(last) == self.in_a_row and all(gain is not None and gain < self.least_gain for gain in last)
