"""The order of a study's trials: how many run on the coarser mesh, how many on the task's own, and when it ends."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

Trials = int | Literal["auto"]
"""How many trials a study shall have: a number, or as many as bring something."""

FINE_SHARE, LEAST_FINE = 0.12, 5
"""Of a search that begins on a coarser mesh: the part of its trials, and the least number, on the task's own mesh."""
FINE_SHARE_UNSURE = 0.3
"""That part where coarser meshes rank trials less surely (docs/notes/learning.md, docs/notes/margins.md)."""
GAIN = 0.001
"""A search has converged when less than this part of the best objective is expected to be gained .."""
IN_A_ROW = 3
""".. by so many proposals in a row."""
MOST, MOST_FINE = 100, 20
"""Trials at most of a search that ends by itself, and those of them on the task's own mesh after a coarser one."""


class ScheduledTrial(NamedTuple):
    """A trial that has been proposed, as a schedule sees it."""

    coarse: bool
    """Whether it runs on the coarser mesh."""
    gain: float | None
    """Expected improvement, as a part of the best objective; None: the sampler did not say."""


@dataclass(frozen=True)
class Schedule:
    """The order of the trials of one study."""

    trials: Trials
    meshes: int
    """1, or 2 where the search begins on a coarser mesh."""
    fine_share: float = FINE_SHARE
    """The part of the trials that runs on the task's own mesh after a coarser one."""

    @property
    def most(self) -> int:
        """How many trials there may be in the end."""
        return MOST if self.trials == "auto" else self.trials

    def coarse_next(self, before: Sequence[ScheduledTrial]) -> bool | None:
        """Whether the next trial runs on the coarser mesh; None: there is no next one.

        Args:
            before: All trials before it in order, running ones too.
        """
        if len(before) >= self.most:
            return None
        if self.trials == "auto":
            return self._auto(before)
        fine = max(LEAST_FINE, math.ceil(self.fine_share * self.trials))
        return self.meshes == 2 and self.trials >= 2 * fine and len(before) < self.trials - fine

    def _auto(self, before: Sequence[ScheduledTrial]) -> bool | None:
        fine = [each.gain for each in before if not each.coarse]
        if self.meshes == 1:
            return None if _converged(fine) else False
        if not fine:
            return not _converged([each.gain for each in before]) and len(before) < MOST - MOST_FINE
        return None if _converged(fine) or len(fine) >= MOST_FINE else False


def _converged(gains: Sequence[float | None]) -> bool:
    last = gains[-IN_A_ROW:]
    return len(last) == IN_A_ROW and all(gain is not None and gain < GAIN for gain in last)
