"""The objective in expectation: l_x + alpha E[D] over worlds that are common to all candidates.

Simulations are spent where they decide. The undisturbed world is first: where that alone is worse than the best
expectation known, the trial cannot win. Then come the others, first those in which any trial known ended worst; no
world is taken to be better than the undisturbed one, so that a trial ends as soon as it can no longer win.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tatamu.disturbances import Disturbances, Stream, World, spread
from tatamu.disturbances.verdict import outcome_in
from tatamu.errors import InputError
from tatamu.folding.manipulation import Manipulation
from tatamu.folding.task import Outcome, Task

WORLDS = 20
"""Disturbed worlds of a trial that may win."""
USUAL_QUANTILE = 0.95
"""Of the objective, which `tatamu learn` minimises unless somebody asks for another, or for the mean."""


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

    @property
    def deciding(self) -> int:
        """How many of a trial's hardest worlds others are simulated in, too.

        For a quantile twice as many as it is made from; for the mean all.
        """
        return self.worlds if self.quantile is None else min(self.worlds, 2 * self.making)

    @property
    def making(self) -> int:
        """How many of the worst worlds the objective is made from: with a quantile, those from it upwards."""
        return self.worlds if self.quantile is None else self.worlds - int(self.quantile * (self.worlds - 1))

    def hardest(self, orders: Sequence[Sequence[int]]) -> tuple[int, ...]:
        """Places of the worlds that decide: folds that differ fail in different ones, so the hardest of every trial.

        Args:
            orders: `Expected.hardest` of all trials that are known, on any mesh, the best first.

        Returns:
            The hardest world of each, then the second of each, and so on, each world once.
        """
        ranked = (order[rank] for rank in range(self.deciding) for order in orders if rank < len(order))
        return tuple(dict.fromkeys(ranked))

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
class Added:
    """The addition of disturbances to the objective of a manipulation, where it was simulated in the worlds before."""

    objective: float
    worlds: int
    hardest: tuple[int, ...]


@dataclass(frozen=True)
class Demand:
    """The worlds in which a trial is to be simulated, and what it has to beat."""

    expectation: Expectation
    worlds: tuple[World, ...]
    standing: Standing | None = None
    """None: nothing is known yet."""
    hardest: tuple[int, ...] = ()
    """Places of the worlds in which it is simulated (`Expectation.hardest`); none: in all, as nothing is known yet."""
    added: Added | None = None
    """None: it was not simulated in them before."""


@dataclass(frozen=True)
class Expected:
    """The objective in expectation, as far as it was needed."""

    objective: float
    worlds: int
    """How many worlds were simulated, the undisturbed one among them."""
    hardest: tuple[int, ...] = ()
    """Places of the worlds that were simulated, those of the highest objective first; none where the trial could not
    win."""


def at_least(task: Task, manipulation: Manipulation, calm: Outcome, demand: Demand, estimate: Expected) -> Expected:
    """An estimate from a coarser mesh, and no less than what its worst worlds come to on the task's own.

    What disturbances add on the coarser mesh may be too little. For a quantile that is seen in the few worlds that make
    it; for the mean it would take all, and the estimate stays. So does one that cannot win.

    Args:
        task: The fold, on its own mesh.
        manipulation: What the hands do.
        calm: Its outcome where nothing is off, on that mesh.
        demand: The worlds, and what the manipulation has to beat.
        estimate: What a coarser mesh said.
    """
    standing = demand.standing
    lost = standing is not None and estimate.objective >= standing.expected
    worst = estimate.hardest[: demand.expectation.making]
    if demand.expectation.quantile is None or not worst or lost:
        return estimate
    own = [calm.objective] * (len(demand.worlds) - len(worst))
    there = [outcome_in(task, manipulation, demand.worlds[number]).objective for number in worst]
    least = demand.expectation.of([*own, *there])
    return replace(estimate, objective=max(estimate.objective, least), worlds=estimate.worlds + len(worst))


def expected(task: Task, manipulation: Manipulation, calm: Outcome, demand: Demand) -> Expected:
    """The expected objective of a manipulation; a pure function.

    Args:
        task: The fold.
        manipulation: What the hands do.
        calm: Its outcome where nothing is off.
        demand: The worlds, and what the manipulation has to beat.

    Returns:
        Where the trial cannot win, an estimate that is worse than the best: its objective and the gap of the best at
        least.
    """
    own = calm.objective
    standing = demand.standing
    if calm.failed:
        return Expected(own, 1)
    if standing is not None and own >= standing.expected:
        return Expected(own + standing.gap, 1)
    count = len(demand.worlds)
    known: dict[int, float] = {}
    for number in demand.hardest or range(count):
        known[number] = outcome_in(task, manipulation, demand.worlds[number]).objective
        least = demand.expectation.of([known.get(each, own) for each in range(count)])
        if standing is not None and least >= standing.expected and len(known) < count:
            return Expected(max(least, own + standing.gap), 1 + len(known))
    hardest = sorted(known, key=lambda each: (-known[each], each))
    return Expected(least, 1 + len(known), tuple(hardest))
