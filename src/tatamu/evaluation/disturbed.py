"""The objective under disturbances: its mean, or a quantile (value at risk), over disturbed worlds.

The same worlds serve all trials (common random numbers). Simulations are spent where they decide (racing): if the
nominal fold alone is worse than the incumbent, the trial cannot win. Otherwise the worlds follow in which any known
trial ended worst. A world that is not simulated counts as the nominal one, which bounds the objective from below, so a
trial ends as soon as this bound exceeds the incumbent.

In a world in which a fold fails, alpha D counts twice: the objective alone would prefer a path that is four centimetres
shorter to two millimetres of distance, even if just these two are beyond the limit of success.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from tatamu.disturbances import Disturbances, Stream, World, sample_sobol
from tatamu.errors import InputError
from tatamu.evaluation.evaluator import NOTHING, Evaluation, Evaluator, Incumbent, Wrapper
from tatamu.folding.score import Limits

Estimate = Callable[[Evaluation, Incumbent], Evaluation | None]
"""Estimates the objective from a nominal evaluation more cheaply than by simulating worlds; None if it cannot."""


@dataclass(frozen=True)
class Disturbed(Wrapper):
    """Evaluates the mean, or a quantile, of the objective over disturbed worlds."""

    disturbances: Disturbances
    quantile: float | None = 0.95
    """The quantile that is minimised; None for the mean."""
    worlds: int = 20
    """How many worlds there are."""
    seed: int = 0
    """Random seed of the worlds."""
    limits: Limits = field(default_factory=Limits)
    """Beyond these, alpha D counts twice."""

    def __post_init__(self) -> None:
        if self.quantile is not None and not 0.0 < self.quantile < 1.0:
            raise InputError(f"quantile: must be above 0 and below 1, given {self.quantile:g}")
        if not 1 <= self.worlds <= 4096:
            raise InputError(f"worlds: must be from 1 to 4096, given {self.worlds}")

    def for_step(self, number: int) -> Disturbed:
        """Return the evaluator of a step of a plan.

        From the second step on half as many worlds may lie beyond the quantile, of twice as many. Later folds end
        nearer to their limits, and a search overfits to few worlds: a fold that holds in nine worlds of ten holds in
        all of 20 once in 8 times, in all of 40 once in 68.

        Args:
            number: Number of the step, from 0.
        """
        if number == 0 or self.quantile is None:
            return self
        return replace(self, quantile=0.5 * (1.0 + self.quantile), worlds=2 * self.worlds)

    @property
    def contains_length(self) -> bool:
        """Whether l_x of Eq. (10) is a part of the objective."""
        return self.inner.contains_length

    def without_disturbances(self) -> Evaluator:
        """Return the inner evaluator."""
        return self.inner.without_disturbances()

    @cached_property
    def sample(self) -> tuple[World, ...]:
        """The disturbed worlds."""
        return tuple(sample_sobol(self.disturbances, self.worlds, self.seed, Stream.LEARNING))

    @property
    def n_tail_worlds(self) -> int:
        """How many of the worst worlds make the objective: all for the mean, those from the quantile upwards."""
        if self.quantile is None:
            return self.worlds
        below = int(self.quantile * (self.worlds + 1)) - 1
        return min(max(1, self.worlds - below), self.worlds)

    @property
    def n_shared_worlds(self) -> int:
        """How many of a trial's hardest worlds others are simulated in: all for the mean, twice the tail."""
        return self.worlds if self.quantile is None else min(self.worlds, 2 * self.n_tail_worlds)

    @property
    def n_confirmed_worlds(self) -> int:
        """How many of the hardest worlds of an estimate are simulated.

        In a first step, those that make the quantile. In later ones estimates are less sure which are hardest.
        """
        return self.n_tail_worlds if self.task.number == 0 else 2 * self.n_shared_worlds

    def aggregate(self, objectives: Sequence[float]) -> float:
        """Return the mean or the quantile of objectives.

        The quantile of n worlds is their order statistic of rank q (n + 1) (Weibull 1939), interpolated: another world
        lies beyond it with a probability of 1 - q. The default of numpy, rank 1 + q (n - 1), lies lower: 2 of 21 other
        worlds lie beyond the 95 % quantile of 20.
        """
        if self.quantile is None:
            return float(np.mean(objectives))
        return float(np.quantile(objectives, self.quantile, method="weibull"))

    def incumbent(self, known: Sequence[Evaluation], parameters: Mapping[str, int | float]) -> Incumbent:
        """Return the best of the complete evaluations, and the worlds that decide: the hardest of each of them."""
        able = sorted((each for each in known if each.hardest), key=lambda each: each.objective)
        ranks = range(self.n_shared_worlds)
        hardest = tuple(dict.fromkeys(one.hardest[rank] for rank in ranks for one in able if rank < len(one.hardest)))
        if not able:
            return Incumbent(hardest=hardest)
        return Incumbent(able[0].objective, max(0.0, able[0].cost), hardest)

    def __call__(
        self, parameters: Mapping[str, int | float], beat: Incumbent = NOTHING, estimate: Estimate | None = None
    ) -> Evaluation:
        """Evaluate a manipulation.

        Args:
            parameters: x1, z1, x2, z2 [m], g1 and g2 of Eq. (9).
            beat: What the evaluation has to beat.
            estimate: Estimates the objective from the nominal evaluation; only its hardest worlds are then simulated.
        """
        nominal = self.inner(parameters)
        estimated = None if nominal.failed or estimate is None else estimate(nominal, beat)
        if estimated is not None:
            return self._confirm(parameters, nominal, estimated, beat)
        return self.add_worlds(parameters, nominal, beat)

    def add_worlds(self, parameters: Mapping[str, int | float], nominal: Evaluation, beat: Incumbent) -> Evaluation:
        """Return a nominal evaluation with the objective over disturbed worlds.

        A trial that cannot win gets an objective that is worse than the incumbent's, by what disturbances add to the
        latter at least.
        """
        floor = self._penalise(nominal)
        if nominal.failed:
            return replace(nominal, objective=floor)
        if floor >= beat.objective:
            return replace(nominal, objective=floor + beat.cost)
        known: dict[int, float] = {}
        for number in beat.hardest or range(self.worlds):
            known[number] = self._objective_in(parameters, number)
            least = self._bound(known, floor)
            if least >= beat.objective and len(known) < self.worlds:
                return replace(nominal, objective=max(least, floor + beat.cost), simulations=1 + len(known))
        return replace(nominal, objective=least, simulations=1 + len(known), hardest=_worst_first(known))

    def _confirm(
        self, parameters: Mapping[str, int | float], nominal: Evaluation, estimate: Evaluation, beat: Incumbent
    ) -> Evaluation:
        """Simulate the hardest worlds of an estimate, and raise it to what they come to, until the trial cannot win.

        The mean would take all worlds, so its estimate stays; so does one that cannot win.
        """
        found = replace(
            nominal, objective=estimate.objective, simulations=estimate.simulations, hardest=estimate.hardest
        )
        if self.quantile is None or estimate.objective >= beat.objective:
            return found
        floor = self._penalise(nominal)
        known: dict[int, float] = {}
        objective = estimate.objective
        for number in estimate.hardest[: self.n_confirmed_worlds]:
            known[number] = self._objective_in(parameters, number)
            objective = max(objective, self._bound(known, floor))
            if objective >= beat.objective:
                break
        others = (number for number in estimate.hardest if number not in known)
        return replace(
            found,
            objective=objective,
            simulations=estimate.simulations + len(known),
            hardest=(*_worst_first(known), *others),
        )

    def _objective_in(self, parameters: Mapping[str, int | float], number: int) -> float:
        """Return the penalised objective in one world."""
        return self._penalise(self.inner.in_world(parameters, self.sample[number]))

    def _bound(self, known: Mapping[int, float], floor: float) -> float:
        """Return a lower bound of the objective: worlds that are not known count as the nominal one."""
        return self.aggregate([known.get(number, floor) for number in range(self.worlds)])

    def _penalise(self, found: Evaluation) -> float:
        """Return l_x + alpha D, or l_x + 2 alpha D if the fold fails."""
        if found.score is None or self.limits.hold(found.score):
            return found.nominal
        return 2.0 * found.nominal - found.trajectory_length


def _worst_first(objectives: Mapping[int, float]) -> tuple[int, ...]:
    """Return the numbers of worlds, that of the highest objective first."""
    return tuple(sorted(objectives, key=lambda each: (-objectives[each], each)))
