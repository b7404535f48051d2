"""The objective in expectation: l_x + alpha E[D] over worlds that are common to all candidates.

Simulations are spent where they decide. The undisturbed world is first: where that alone is worse than the best
expectation known, the trial cannot win. Then come the others, first those in which any trial known ended worst; no
world is taken to be better than the undisturbed one, so that a trial ends as soon as it can no longer win.

Where a fold does not hold, its errors count twice. The objective alone would rather have a path that is four
centimetres shorter and two millimetres more, and does not know that just these two are beyond the limit.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tatamu.disturbances import Disturbances, Stream, World, spread
from tatamu.disturbances.verdict import Limits, Verdict, outcome_in
from tatamu.errors import InputError
from tatamu.folding.manipulation import Manipulation
from tatamu.folding.task import Outcome, Task

WORLDS = 20
"""Disturbed worlds of a trial that may win."""
USUAL_QUANTILE = 0.95
"""Of the objective, which `tatamu learn` minimises unless somebody asks for another, or for the mean."""
LIMITS = Limits()
"""Beyond which the errors of a fold count twice."""


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

    def of_step(self, step: int) -> Expectation:
        """The expectation of a step of a plan.

        From the second step on half as many worlds may be beyond the quantile, of twice as many. Later folds end
        nearer to their limits, and a search finds what holds in the worlds that it asks for: a fold that holds in nine
        worlds of ten holds in all of 20 once in 8 times, in all of 40 once in 68.

        Args:
            step: The number of the step in its plan, from 1.
        """
        if step == 1 or self.quantile is None:
            return self
        return replace(self, quantile=0.5 * (1.0 + self.quantile), worlds=2 * self.worlds)

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
        if self.quantile is None:
            return self.worlds
        below = int(self.quantile * (self.worlds + 1)) - 1
        return min(max(1, self.worlds - below), self.worlds)

    def checked(self, step: int) -> int:
        """In how many worlds that are hardest on a coarser mesh a trial is simulated on its own.

        In a first step in those that make the quantile. Coarser meshes know less well which are the hardest for a later
        one: twice as many as others are simulated in.

        Args:
            step: The number of the step in its plan, from 1.
        """
        return self.making if step == 1 else 2 * self.deciding

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
        """The mean, or the quantile, of objectives.

        The quantile of n worlds is their order statistic of rank q (n + 1) (Weibull 1939), in between two of them by
        interpolation: another world is beyond it with a probability of 1 - q. That of rank 1 + q (n - 1), which numpy
        takes unless it is told, lies lower: 2 of 21 other worlds are beyond the 95 % quantile of 20.
        """
        if self.quantile is None:
            return float(np.mean(values))
        return float(np.quantile(values, self.quantile, method="weibull"))


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

    def of(self, known: Mapping[int, float], own: float) -> float:
        """The expected objective where the worlds that are not known are as good as the undisturbed one.

        Args:
            known: Objectives in some worlds, by their places.
            own: The objective where nothing is off.
        """
        return self.expectation.of([known.get(number, own) for number in range(len(self.worlds))])


@dataclass(frozen=True)
class Expected:
    """The objective in expectation, as far as it was needed."""

    objective: float
    worlds: int
    """How many worlds were simulated, the undisturbed one among them."""
    hardest: tuple[int, ...] = ()
    """Places of the worlds that were simulated, those of the highest objective first; none where the trial could not
    win."""


def counted(outcome: Outcome) -> float:
    """The objective of an outcome in some world: l_x + alpha D, or l_x + 2 alpha D where the fold does not hold."""
    if outcome.score is None or Verdict.of(outcome.score).holds(LIMITS):
        return outcome.objective
    return 2.0 * outcome.objective - outcome.score.trajectory_length


def at_least(task: Task, manipulation: Manipulation, calm: Outcome, demand: Demand, estimate: Expected) -> Expected:
    """An estimate from a coarser mesh, and no less than what its hardest worlds come to on the task's own.

    What disturbances add on the coarser mesh may be too little. So its hardest worlds are simulated, until the trial
    can no longer win. For the mean it would take all, and the estimate stays. So does one that cannot win.

    Args:
        task: The fold, on its own mesh.
        manipulation: What the hands do.
        calm: Its outcome where nothing is off, on that mesh.
        demand: The worlds, and what the manipulation has to beat.
        estimate: What a coarser mesh said.

    Returns:
        Its hardest worlds in the order of the own mesh, as far as they were simulated there; then the others.
    """
    standing = demand.standing
    lost = standing is not None and estimate.objective >= standing.expected
    if demand.expectation.quantile is None or lost:
        return estimate
    own = counted(calm)
    known: dict[int, float] = {}
    objective = estimate.objective
    for number in estimate.hardest[: demand.expectation.checked(task.step[0])]:
        known[number] = counted(outcome_in(task, manipulation, demand.worlds[number]))
        objective = max(objective, demand.of(known, own))
        if standing is not None and objective >= standing.expected:
            break
    others = (number for number in estimate.hardest if number not in known)
    return replace(
        estimate,
        objective=objective,
        worlds=estimate.worlds + len(known),
        hardest=(*_worst_first(known), *others),
    )


def _worst_first(objectives: Mapping[int, float]) -> tuple[int, ...]:
    """Places of worlds, that of the highest objective first."""
    return tuple(sorted(objectives, key=lambda each: (-objectives[each], each)))


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
    own = counted(calm)
    standing = demand.standing
    if calm.failed:
        return Expected(own, 1)
    if standing is not None and own >= standing.expected:
        return Expected(own + standing.gap, 1)
    count = len(demand.worlds)
    known: dict[int, float] = {}
    for number in demand.hardest or range(count):
        known[number] = counted(outcome_in(task, manipulation, demand.worlds[number]))
        least = demand.of(known, own)
        if standing is not None and least >= standing.expected and len(known) < count:
            return Expected(max(least, own + standing.gap), 1 + len(known))
    return Expected(least, 1 + len(known), _worst_first(known))
