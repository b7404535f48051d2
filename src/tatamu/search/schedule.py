"""The schedule of a study: the fidelity of each trial, and the condition for the end of the study.

When a fold is learned, trials at high fidelity run on the fine mesh, and trials at low fidelity on a coarser mesh.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from tatamu.search.search import HIGH, LOW, Proposal

Trials = int | Literal["auto"]
"""Number of trials of a study. If it is "auto", the study ends when little improvement is expected."""


@dataclass(frozen=True)
class Schedule:
    """The numbers of trials of one study at each fidelity."""

    trials: Trials
    fidelities: int = 1
    """Number of fidelities, the accuracies of the model that is evaluated.

    It is 2 if the search starts at low fidelity, otherwise 1.
    """
    high_share: float = 0.12
    """Fraction of a study's trials that run at high fidelity, after the trials at low fidelity.

    The field has no effect if there is only one fidelity.
    """
    least_high: int = 5
    """Least number of trials at high fidelity."""
    least_gain: float = 0.001
    """Smallest expected gain of a useful proposal, as a fraction of the best objective.

    A search with the number of trials "auto" ends when `in_a_row` successive proposals have a smaller expected gain. If
    the number of trials is given, the field has no effect."""
    in_a_row: int = 3
    """Number of successive proposals with an expected gain below `least_gain` that end a search with "auto" trials."""
    most_auto: int = 100
    """Largest number of trials of a study whose number of trials is "auto"."""
    most_high: int = 20
    """Largest number of trials at high fidelity, if the number of trials is "auto" and there are two fidelities."""

    @property
    def most(self) -> int:
        """Largest number of trials of the study."""
        return self.most_auto if self.trials == "auto" else self.trials

    @property
    def until_gain(self) -> float | None:
        """Smallest expected gain of a useful proposal; None if the number of trials is given.

        The search ends by itself when successive proposals have a smaller expected gain.
        """
        return self.least_gain if self.trials == "auto" else None

    def next_fidelity(self, before: Sequence[Proposal]) -> int | None:
        """Return the fidelity of the next trial; None if the study is over.

        Args:
            before: Proposals of all earlier trials in order. Pending trials are included.
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
