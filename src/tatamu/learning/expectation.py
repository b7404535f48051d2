"""The objective in expectation: l_x + alpha E[D] over worlds that are common to all candidates.

Simulations are spent where they decide. The undisturbed world is first: where that alone is worse than the best
expectation known, the trial cannot win. Then come the others, in blocks; no world is taken to be better than the
undisturbed one, so that a trial ends as soon as it can no longer win.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tatamu.disturbances import Disturbances, Stream, World, spread
from tatamu.disturbances.verdict import outcome_in
from tatamu.errors import InputError
from tatamu.folding.manipulation import Manipulation
from tatamu.folding.task import Outcome, Task

WORLDS = 12
"""Disturbed worlds of a trial that may win."""
BLOCK = 4
"""Worlds that are simulated before it is asked whether the trial may still win."""


@dataclass(frozen=True)
class Expectation:
    """The objective of a study where not everything is known."""

    disturbances: Disturbances
    quantile: float | None = None
    """Instead of the mean the quantile of this share; None: the mean."""
    worlds: int = WORLDS

    def __post_init__(self) -> None:
        if self.quantile is not None and not 0.0 < self.quantile < 1.0:
            raise InputError(f"quantile: must be above 0 and below 1, given {self.quantile:g}")

    def drawn(self, seed: int) -> tuple[World, ...]:
        """The worlds of a study of that seed."""
        return tuple(spread(self.disturbances, self.worlds, seed, Stream.LEARNING))

    def of(self, values: Sequence[float]) -> float:
        """The mean, or the quantile, of objectives."""
        return float(np.mean(values) if self.quantile is None else np.quantile(values, self.quantile))


@dataclass(frozen=True)
class Standing:
    """The best trial that another one knows of."""

    expected: float
    """Its expected objective."""
    gap: float
    """By how much that is more than its objective where nothing is off."""


@dataclass(frozen=True)
class Demand:
    """The worlds in which a trial is to be simulated, and what it has to beat."""

    expectation: Expectation
    worlds: tuple[World, ...]
    standing: Standing | None = None
    """None: nothing is known yet, so the trial is simulated in all worlds."""


@dataclass(frozen=True)
class Expected:
    """The objective in expectation, as far as it was needed."""

    objective: float
    worlds: int
    """How many worlds were simulated, the undisturbed one among them."""


def expected(task: Task, manipulation: Manipulation, calm: Outcome, demand: Demand) -> Expected:
    """The expected objective of a manipulation; a pure function.

    Args:
        task: The fold.
        manipulation: What the hands do.
        calm: Its outcome where nothing is off.
        demand: The worlds, and what the manipulation has to beat.

    Returns:
        Where the trial cannot win, an estimate that is worse than the best: after the undisturbed world alone its
        objective and the gap of the best.
    """
    own = calm.objective
    standing = demand.standing
    if calm.failed:
        return Expected(own, 1)
    if standing is not None and own >= standing.expected:
        return Expected(own + standing.gap, 1)
    statistic = demand.expectation.of
    values: list[float] = []
    least = own
    while len(values) < len(demand.worlds):
        block = demand.worlds[len(values) : len(values) + BLOCK]
        values += [outcome_in(task, manipulation, world).objective for world in block]
        least = statistic([*values, *[own] * (len(demand.worlds) - len(values))])
        if standing is not None and least >= standing.expected:
            break
    return Expected(max(least, statistic(values)), 1 + len(values))
