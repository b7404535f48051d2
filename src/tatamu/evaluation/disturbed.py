"""The objective under disturbances: C of folds that hold, or the mean of C over disturbed worlds.

A world is one random draw of the disturbances. The nominal world has no disturbances. A fold holds in a world if it
succeeds there, within the limits of `folding.score.Limits`. The objective of Eq. (10) is C = l_x + alpha D, with the
trajectory length l_x and the shape distance D.

By default, the search minimises C under a chance constraint (Charnes and Cooper 1959). The fold must hold in 97.5 % of
the disturbed worlds. Each world gets a value. If the fold holds in the world, the value is the nominal C, without
disturbances. If it does not hold, the value is l_x + 2 alpha D of this world. The search minimises a quantile (value at
risk) of these values over all worlds. Folds that hold are thus compared by the nominal C alone. Their C in the world is
not used, because errors of the hands displace every fold by about the same distance.

In some worlds no path helps. For example, the hands release the cloth 20 mm from its target, or hit the table. To
recognise such worlds, one fixed fold serves as a yardstick: the first of several arched and high curves whose fold
succeeds without disturbances. A fold needs to hold only in worlds in which the yardstick holds.

All trials are simulated in the same worlds (common random numbers). Trials are raced to save simulations: a trial ends
as soon as it cannot beat the incumbent, the best trial so far. If the nominal fold of a trial is worse than the
incumbent, or better by less than `LEAST_GAIN`, the trial ends at once. Otherwise it is simulated in one world after
another, and the hardest worlds come first. In a world that is not simulated, a trial gets its nominal value. This gives
a lower bound of the objective. The trial ends as soon as this bound exceeds the objective of the incumbent.

The hardest worlds are the worlds in which known trials failed, and then the worlds in which their values were largest.
To know these values, the first trial is simulated in all worlds. Later trials on the coarse mesh are simulated in the
harder half of the worlds. In fewer worlds, a fold could become the incumbent that fails in worlds in which no earlier
fold failed, and later folds that hold would end because they do not beat it. On the fine mesh, where simulations are
slow, a trial is simulated only in the hardest few worlds, or in all worlds in which a trial failed if these are more.
This is constraint generation, also called the cutting-plane method (Kelley 1960).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Generator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import repeat

import numpy as np

from tatamu.base.errors import InputError
from tatamu.evaluation.disturbances import Disturbances, Stream, World, hand_failure, sample_sobol
from tatamu.evaluation.evaluator import NOTHING, Evaluation, Evaluator, Incumbent, Wrapper
from tatamu.folding.parameters import arched_inwards, later_curves
from tatamu.folding.score import ALPHA, Limits
from tatamu.search import HIGH, LOW, Parameters
from tatamu.simulation.side_by_side import processors
from tatamu.simulation.simulators import capabilities

RACING_THREADS = 4
"""Largest number of worlds (draws of the disturbances) in which a trial that may end early is simulated at a time.

At most half of the processors are used, because two trials usually run at the same time. More threads would simulate
worlds in vain that delay the other trial.
"""
SCOUTS = 1
"""Number of trials at the start of a search that are simulated in all worlds (draws of the disturbances).

They show which worlds are the hardest. Later trials are simulated in these worlds.
"""
LEAST_GAIN = 0.005
"""Least improvement on the best trial for which a trial is simulated with disturbances.

It is a fraction of the trial's objective without disturbances. A trial that holds needs many simulations, which a
smaller improvement is not worth.
"""


@dataclass(frozen=True)
class Disturbed(Wrapper):
    """Evaluates the objective C of a fold that must hold in most disturbed worlds, or the mean of C over these worlds.

    A world is one random draw of all disturbances.
    """

    disturbances: Disturbances
    quantile: float | None = 0.975
    """Fraction of the worlds in which the fold must hold. None to minimise the mean of C instead.

    The quantile of the objective at this fraction is minimised."""
    worlds: int = 40
    """Number of worlds (random draws of the disturbances)."""
    seed: int = 0
    """Random seed of the worlds."""
    limits: Limits = field(default_factory=Limits)
    """Limits of a successful fold. If a fold exceeds one of them, the part alpha D of its objective counts twice."""

    def __post_init__(self) -> None:
        if self.quantile is not None and not 0.0 < self.quantile < 1.0:
            raise InputError(f"quantile: must be above 0 and below 1, given {self.quantile:g}")
        if not 1 <= self.worlds <= 4096:
            raise InputError(f"worlds: must be from 1 to 4096, given {self.worlds}")

    @property
    def contains_length(self) -> bool:
        """Whether the trajectory length l_x of Eq. (10) is a part of the objective."""
        return self.inner.contains_length

    @property
    def scouts(self) -> int:
        """Number of evaluations at the start of a search that are simulated in all worlds.

        A world is one random draw of all disturbances. Later evaluations wait until these evaluations are complete.
        """
        return SCOUTS

    def without_disturbances(self) -> Evaluator:
        """Return the wrapped evaluator, which has no disturbances."""
        return self.inner.without_disturbances()

    @cached_property
    def sample(self) -> tuple[World, ...]:
        """The disturbed worlds, which are random draws of all disturbances."""
        return tuple(sample_sobol(self.disturbances, self.worlds, self.seed, Stream.LEARNING))

    @property
    def n_tail_worlds(self) -> int:
        """Number of worst worlds (draws of the disturbances) that determine the objective.

        If the objective is a mean, all worlds determine it.
        """
        if self.quantile is None:
            return self.worlds
        below = int(self.quantile * (self.worlds + 1)) - 1
        return min(max(1, self.worlds - below), self.worlds)

    @property
    def n_coarse_worlds(self) -> int:
        """Number of hard worlds (draws of the disturbances) in which a raced trial on the coarse mesh is simulated.

        It is half of all worlds, or all of them if the objective is a mean.
        """
        return max(self.n_raced_worlds, self.worlds // 2)

    @property
    def n_raced_worlds(self) -> int:
        """Number of hard worlds (draws of the disturbances) in which a raced trial on the fine mesh is simulated.

        It is three times `n_tail_worlds`. If the objective is a mean, it is the number of all worlds. A raced trial
        ends as soon as it cannot beat the best trial.
        """
        return self.worlds if self.quantile is None else min(self.worlds, 3 * self.n_tail_worlds)

    def aggregate(self, objectives: Sequence[float]) -> float:
        """Return the mean or the quantile of the objectives of one trial in several worlds (draws of the disturbances).

        A further world should exceed the quantile with the probability 1 - q, where q is the fraction of the quantile.
        The quantile of n worlds is therefore their order statistic of rank q (n + 1), interpolated (Weibull 1939). The
        default of numpy, the rank 1 + q (n - 1), is lower. With 20 worlds and q = 0.95, a further world exceeds it with
        the probability 2/21.
        """
        if self.quantile is None:
            return float(np.mean(objectives))
        return float(np.quantile(objectives, self.quantile, method="weibull"))

    @cached_property
    def yardstick(self) -> Parameters | None:
        """Parameters of the first arched or high curve whose fold succeeds without disturbances.

        If the fold along this curve fails in a world (draw of the disturbances), the world counts as too hard for all
        folds. If every such curve fails without disturbances, the result is None, and no world counts as too hard.
        """
        curves = [arched_inwards(self.task.fold), *later_curves(self.task.fold)]
        return next((curve for curve in curves if self._holds(self.inner(curve))), None)

    @cached_property
    def _held(self) -> dict[tuple[frozenset[tuple[str, int | float]], int], bool]:
        """Whether a fold succeeds in a world, by its parameters and the number of the world."""
        return {}

    def incumbent(self, known: Sequence[Evaluation], parameters: Mapping[str, int | float]) -> Incumbent:
        """Return the incumbent: the result of the best complete evaluation, and the worlds of the next trial.

        A world is one random draw of all disturbances. The hardest worlds come first: the worlds in which most known
        evaluations failed, and then the hardest worlds of all complete evaluations. If fewer than `SCOUTS` evaluations
        are complete, return `NOTHING`. The next trial is then simulated in all worlds. Otherwise it is simulated in the
        `n_coarse_worlds` or `n_raced_worlds` hardest worlds, or in every world in which a trial failed if these are
        more.
        """
        able = sorted((each for each in known if each.hardest), key=lambda each: each.objective)
        if len(able) < SCOUTS:
            return NOTHING
        failures = Counter(number for each in known for number in each.failed_in)
        failed = sorted(failures, key=lambda number: (-failures[number], number))
        hard = (one.hardest[rank] for rank in range(self.worlds) for one in able if rank < len(one.hardest))
        worlds = tuple(dict.fromkeys([*failed, *hard]))
        coarse = getattr(parameters, "fidelity", HIGH) == LOW
        count = max(self.n_coarse_worlds if coarse else self.n_raced_worlds, len(failed))
        return Incumbent(able[0].objective, max(0.0, able[0].cost), worlds[:count])

    def __call__(self, parameters: Mapping[str, int | float], beat: Incumbent = NOTHING) -> Evaluation:
        """Evaluate a manipulation.

        A trial that cannot beat the incumbent (the best trial so far) is stopped early. Its returned objective is then
        a lower bound, which is at least the objective of the incumbent. A trial that could beat the incumbent by less
        than `LEAST_GAIN` is stopped early too, and gets the objective of the incumbent.
        """
        nominal = self.inner(parameters)
        floor = self._penalise(nominal)
        if nominal.failed:
            return replace(nominal, objective=floor)
        if floor + LEAST_GAIN * abs(floor) >= beat.objective:
            return replace(nominal, objective=max(floor + beat.cost, beat.objective))
        errors: dict[int, float] = {}
        counted: dict[int, float] = {}
        failed: list[int] = []
        numbers = beat.hardest or range(self.worlds)
        with closing(self._in_worlds(parameters, numbers, beat)) as outcomes:
            for number, found in zip(numbers, outcomes, strict=True):
                holds = self._holds(found)
                self._held[frozenset(parameters.items()), number] = holds
                decides = self.quantile is None or holds or not self._is_lost_to_all(number)
                errors[number] = self._penalise(found) if decides else floor
                if decides and not holds:
                    failed.append(number)
                counted[number] = floor if holds and self.quantile is not None else errors[number]
                least = self._bound(counted, floor)
                if least >= beat.objective and len(counted) < self.worlds:
                    bound = max(least, floor + beat.cost)
                    return replace(nominal, objective=bound, simulations=1 + len(counted), failed_in=tuple(failed))
        hardest = _worst_first(errors)
        return replace(nominal, objective=least, simulations=1 + len(counted), hardest=hardest, failed_in=tuple(failed))

    def _in_worlds(
        self, parameters: Mapping[str, int | float], numbers: Sequence[int], beat: Incumbent
    ) -> Generator[Evaluation]:
        """Evaluate a manipulation in worlds (draws of the disturbances), in threads, and yield the results in order.

        If an incumbent may end the trial early, there are few threads, because worlds ahead may be simulated in vain.
        """
        count = processors() if np.isinf(beat.objective) else min(RACING_THREADS, max(1, processors() // 2))
        if count == 1 or not capabilities(self.task.simulator).parallel:
            yield from (self._in_world(parameters, number) for number in numbers)
            return
        threads = ThreadPoolExecutor(count)
        try:
            yield from threads.map(self._in_world, repeat(parameters), numbers)
        finally:
            threads.shutdown(wait=False, cancel_futures=True)

    def _in_world(self, parameters: Mapping[str, int | float], number: int) -> Evaluation:
        """Evaluate a manipulation in a world (draw of the disturbances).

        The evaluation fails without a simulation if a hand misses the cloth or must stop.
        """
        world = self.sample[number]
        failure = hand_failure(self.task.fold, self.task.manipulation(parameters), world)
        return self.inner.in_world(parameters, world) if failure is None else self.inner.fail(parameters, failure)

    def _is_lost_to_all(self, number: int) -> bool:
        """Return whether the yardstick's fold fails in a world (draw of the disturbances).

        At the first call for a world, this fold is simulated there.
        """
        if self.yardstick is None:
            return False
        case = frozenset(self.yardstick.items()), number
        if case not in self._held:
            self._held[case] = self._holds(self._in_world(self.yardstick, number))
        return not self._held[case]

    def _bound(self, known: Mapping[int, float], floor: float) -> float:
        """Return a lower bound of a trial's objective from the worlds (draws of the disturbances) that were simulated.

        All other worlds count with the nominal value `floor`.
        """
        return self.aggregate([known.get(number, floor) for number in range(self.worlds)])

    def _holds(self, found: Evaluation) -> bool:
        return found.score is not None and self.limits.hold(found.score)

    def _penalise(self, found: Evaluation) -> float:
        """Return the value of a fold in a world: l_x + alpha D if it succeeds there, otherwise l_x + 2 alpha D.

        If the fold does not succeed, D is at least the shape distance at which a fold no longer counts as a success.
        """
        if found.score is None or self._holds(found):
            return found.nominal
        limit = ALPHA * len(self.task.fold.start) * self.limits.mean_vertex_distance
        return found.trajectory_length + 2.0 * max(found.nominal - found.trajectory_length, limit)


def _worst_first(objectives: Mapping[int, float]) -> tuple[int, ...]:
    """Return the numbers of the worlds (draws of the disturbances) from the largest to the smallest objective."""
    return tuple(sorted(objectives, key=lambda each: (-objectives[each], each)))
