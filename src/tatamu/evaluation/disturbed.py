"""The objective under disturbances: C of folds that hold, or the mean of C over disturbed worlds.

A world is one random draw of the disturbances; the nominal world has no disturbances. A fold holds in a world if it
succeeds there, within the limits of `folding.score.Limits`.

By default the search minimises C subject to a chance constraint (Charnes and Cooper 1959): the fold is to hold in 97.5
% of the disturbed worlds. In a world where the fold holds, the objective is the nominal C; in another world it is l_x +
2 alpha D. The quantile (value at risk) of this objective over all worlds is minimised. So folds that hold are compared
by C alone, because the displacement by errors of the hands depends on the world and hardly on the manipulation.

In some worlds no path helps: where hands release the cloth 20 mm from its target, or hit the table. So a fold needs to
hold only in worlds in which a yardstick holds: the arched curve with which every search starts.

The same worlds serve all trials (common random numbers). Trials are raced to save simulations: a trial ends as soon as
it cannot beat the incumbent, the best trial so far. If its nominal fold is worse than the incumbent, it ends at once.
Otherwise it is simulated in the hardest worlds: those in which known trials ended worst. To find the hardest worlds,
the first two trials are simulated in all worlds. A world that is not simulated counts as the nominal world. This bounds
the objective from below, so a trial ends as soon as its bound exceeds the incumbent.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from tatamu.disturbances import Disturbances, Stream, World, hand_failure, sample_sobol
from tatamu.errors import InputError
from tatamu.evaluation.evaluator import NOTHING, Evaluation, Evaluator, Incumbent, Wrapper
from tatamu.folding.parameters import arched_inwards
from tatamu.folding.score import ALPHA, Limits
from tatamu.search import Parameters

SCOUTS = 2
"""Number of first trials, which are simulated in all worlds to find the hardest ones."""


@dataclass(frozen=True)
class Disturbed(Wrapper):
    """Evaluates C of a fold that is to hold in most disturbed worlds, or the mean of C over them."""

    disturbances: Disturbances
    quantile: float | None = 0.975
    """Share of the worlds in which the fold is to hold: this quantile is minimised. None to minimise the mean of C."""
    worlds: int = 40
    """Number of worlds."""
    seed: int = 0
    """Random seed of the worlds."""
    limits: Limits = field(default_factory=Limits)
    """Limits of success; beyond them, alpha D counts twice."""

    def __post_init__(self) -> None:
        if self.quantile is not None and not 0.0 < self.quantile < 1.0:
            raise InputError(f"quantile: must be above 0 and below 1, given {self.quantile:g}")
        if not 1 <= self.worlds <= 4096:
            raise InputError(f"worlds: must be from 1 to 4096, given {self.worlds}")

    @property
    def contains_length(self) -> bool:
        """Whether l_x of Eq. (10) is a part of the objective."""
        return self.inner.contains_length

    @property
    def scouts(self) -> int:
        """Number of first evaluations, which are simulated in all worlds; later evaluations wait for them."""
        return SCOUTS

    def without_disturbances(self) -> Evaluator:
        """Return the inner evaluator."""
        return self.inner.without_disturbances()

    @cached_property
    def sample(self) -> tuple[World, ...]:
        """The disturbed worlds."""
        return tuple(sample_sobol(self.disturbances, self.worlds, self.seed, Stream.LEARNING))

    @property
    def n_tail_worlds(self) -> int:
        """Number of worst worlds that determine the objective; all for the mean."""
        if self.quantile is None:
            return self.worlds
        below = int(self.quantile * (self.worlds + 1)) - 1
        return min(max(1, self.worlds - below), self.worlds)

    @property
    def n_shared_worlds(self) -> int:
        """Number of a trial's hardest worlds in which other trials are simulated: twice the tail, all for the mean."""
        return self.worlds if self.quantile is None else min(self.worlds, 2 * self.n_tail_worlds)

    @property
    def n_raced_worlds(self) -> int:
        """Largest number of worlds of a raced trial: three times the tail, or all for the mean."""
        return self.worlds if self.quantile is None else min(self.worlds, 3 * self.n_tail_worlds)

    def aggregate(self, objectives: Sequence[float]) -> float:
        """Return the mean or the quantile of objectives.

        The quantile of n worlds is their order statistic of rank q (n + 1) (Weibull 1939), interpolated: a further
        world exceeds it with a probability of 1 - q. The default of numpy, rank 1 + q (n - 1), is lower: 2 of 21
        further worlds exceed its 95 % quantile of 20.
        """
        if self.quantile is None:
            return float(np.mean(objectives))
        return float(np.quantile(objectives, self.quantile, method="weibull"))

    @cached_property
    def yardstick(self) -> Parameters:
        """The arched curve. If its fold fails in a world, that world counts as too hard for all folds."""
        return arched_inwards(self.task.fold)

    @cached_property
    def _yardstick_serves(self) -> bool:
        """Whether the yardstick's fold holds without disturbances; if not, it is not used."""
        return self._holds(self.inner(self.yardstick))

    @cached_property
    def _yardstick_holds(self) -> dict[int, bool]:
        """Whether the yardstick's fold holds, by number of world."""
        return {}

    def incumbent(self, known: Sequence[Evaluation], parameters: Mapping[str, int | float]) -> Incumbent:
        """Return the best complete evaluation, with the hardest worlds of all complete evaluations.

        While fewer than `SCOUTS` evaluations are complete, it returns `NOTHING`, so trials are simulated in all worlds.
        """
        able = sorted((each for each in known if each.hardest), key=lambda each: each.objective)
        if len(able) < SCOUTS:
            return NOTHING
        ranks = range(self.n_shared_worlds)
        hardest = tuple(dict.fromkeys(one.hardest[rank] for rank in ranks for one in able if rank < len(one.hardest)))
        return Incumbent(able[0].objective, max(0.0, able[0].cost), hardest[: self.n_raced_worlds])

    def __call__(self, parameters: Mapping[str, int | float], beat: Incumbent = NOTHING) -> Evaluation:
        """Evaluate a manipulation.

        If a trial is stopped early because it cannot beat the incumbent, its objective is at least its nominal value
        plus the incumbent's cost of disturbances.
        """
        nominal = self.inner(parameters)
        floor = self._penalise(nominal)
        if nominal.failed:
            return replace(nominal, objective=floor)
        if floor >= beat.objective:
            return replace(nominal, objective=floor + beat.cost)
        errors: dict[int, float] = {}
        counted: dict[int, float] = {}
        for number in beat.hardest or range(self.worlds):
            found = self._in_world(parameters, number)
            holds = self._holds(found)
            if dict(parameters) == self.yardstick:
                self._yardstick_holds[number] = holds
            decides = self.quantile is None or holds or not self._is_lost_to_all(number)
            errors[number] = self._penalise(found) if decides else floor
            counted[number] = floor if holds and self.quantile is not None else errors[number]
            least = self._bound(counted, floor)
            if least >= beat.objective and len(counted) < self.worlds:
                return replace(nominal, objective=max(least, floor + beat.cost), simulations=1 + len(counted))
        return replace(nominal, objective=least, simulations=1 + len(counted), hardest=_worst_first(errors))

    def _in_world(self, parameters: Mapping[str, int | float], number: int) -> Evaluation:
        """Evaluate a manipulation in a world. It fails without a simulation if a hand misses the cloth or must stop."""
        world = self.sample[number]
        failure = hand_failure(self.task.fold, self.task.manipulation(parameters), world)
        return self.inner.in_world(parameters, world) if failure is None else self.inner.fail(parameters, failure)

    def _is_lost_to_all(self, number: int) -> bool:
        """Return whether the yardstick's fold fails in a world; it is simulated there at the first call."""
        if not self._yardstick_serves:
            return False
        if number not in self._yardstick_holds:
            self._yardstick_holds[number] = self._holds(self._in_world(self.yardstick, number))
        return not self._yardstick_holds[number]

    def _bound(self, known: Mapping[int, float], floor: float) -> float:
        """Return a lower bound of the objective: worlds that are not known count as the nominal one."""
        return self.aggregate([known.get(number, floor) for number in range(self.worlds)])

    def _holds(self, found: Evaluation) -> bool:
        return found.score is not None and self.limits.hold(found.score)

    def _penalise(self, found: Evaluation) -> float:
        """Return l_x + alpha D if the fold holds; otherwise l_x + 2 alpha D, with at least the D of the limit."""
        if found.score is None or self._holds(found):
            return found.nominal
        limit = ALPHA * len(self.task.fold.start) * self.limits.mean_vertex_distance
        return found.trajectory_length + 2.0 * max(found.nominal - found.trajectory_length, limit)


def _worst_first(objectives: Mapping[int, float]) -> tuple[int, ...]:
    """Return the numbers of worlds, the largest objective first."""
    return tuple(sorted(objectives, key=lambda each: (-objectives[each], each)))
