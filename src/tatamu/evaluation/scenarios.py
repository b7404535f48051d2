"""Folds that succeed under disturbances: the evaluator over the scenarios of an orthogonal array.

Each scenario has every disturbance at plus or minus a number of deviations (Taguchi's outer array). A fold is simulated
undisturbed first. Only if it would be the best by half a per cent, it is simulated in the scenarios of the ask, in
their order, until it does not pass one. A fold passes a scenario if it succeeds, or is only put down beside the target,
which no path changes. With n vertices and the limit d of the mean distance, its value is

    C, at least beat                                if it would not be the best by half a per cent
    C                                               if it passes all of them
    max(C, beat) + alpha n d (1 + failed share)     otherwise

so that the value falls with the number of scenarios passed, and no fold that fails beats one that passes.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from tatamu.base.errors import InputError
from tatamu.evaluation.array import LEVEL, check_level, orthogonal_array
from tatamu.evaluation.disturbances import Disturbances, Scenario
from tatamu.evaluation.disturbances.channels import CHANNELS
from tatamu.evaluation.disturbances.scenario import deviations, scenarios_of
from tatamu.evaluation.evaluator import Ask, Evaluation, Evaluator
from tatamu.evaluation.nominal import Nominal
from tatamu.evaluation.outcome import BESIDE_TARGET, Outcome
from tatamu.folding.score import ALPHA, Limits
from tatamu.folding.task import Task
from tatamu.simulation.side_by_side import processors
from tatamu.simulation.simulators import capabilities

WORTHWHILE = 0.005
"""Smallest gain for which a fold is simulated in scenarios, as a fraction of the best value."""


def array_scenarios(disturbances: Disturbances, level: float = LEVEL) -> list[Scenario]:
    """Return the scenarios of an orthogonal array, with every disturbance at plus or minus `level` deviations.

    Correlated disturbances are drawn in the space of independent normal variables.

    Raises:
        InputError: If no disturbance has a deviation above zero.
    """
    names = list(deviations(disturbances))
    if not names:
        raise InputError("disturbances: must have at least one standard deviation above 0, given only zeros")
    columns = [index for index, channel in enumerate(CHANNELS) if channel.name in names]
    signs = orthogonal_array(len(columns))
    rows = np.zeros((len(signs), len(CHANNELS)))
    rows[:, columns] = level * signs
    return scenarios_of(disturbances, rows)


@dataclass(frozen=True)
class Scenarios(Evaluator):
    """Scores a fold over scenarios."""

    inner: Nominal
    disturbances: Disturbances
    level: float = LEVEL
    """Size of every disturbance, in its deviations."""
    limits: Limits = field(default_factory=Limits)

    contains_length = True

    def __post_init__(self) -> None:
        check_level(self.level)

    @cached_property
    def sample(self) -> list[Scenario]:
        """The scenarios, by their index."""
        return array_scenarios(self.disturbances, self.level)

    @property
    def task(self) -> Task:  # type: ignore[override]
        return self.inner.task

    @property
    def scenario_count(self) -> int:  # type: ignore[override]
        return len(self.sample)

    @property
    def undisturbed(self) -> Evaluator:
        return self.inner

    def on(self, task: Task) -> Scenarios:
        return replace(self, inner=self.inner.on(task))

    def __call__(self, ask: Ask | Mapping[str, int | float]) -> Evaluation:
        ask = Ask.of(ask)
        found = self.inner(ask)
        if found.failed or found.objective >= ask.beat:
            return found
        if found.objective > (1.0 - WORTHWHILE) * ask.beat:
            return replace(found, objective=ask.beat)
        indices = range(len(self.sample)) if ask.scenarios is None else ask.scenarios
        if not self._succeeds(found):
            return self._penalise(found, ask, 1.0)
        tried, failures = 0, []
        for index, passed in zip(indices, self._passes(ask, indices), strict=False):
            tried += 1
            if not passed:
                failures.append(index)
                if ask.beat < np.inf:
                    break
        found = replace(found, scenarios=tried, failed_in=tuple(failures))
        if not failures:
            return found
        return self._penalise(found, ask, 1.0 - (tried - len(failures)) / len(indices))

    def _penalise(self, found: Evaluation, ask: Ask, failed_share: float) -> Evaluation:
        base = found.nominal if np.isinf(ask.beat) else max(found.nominal, ask.beat)
        limit = ALPHA * len(self.task.fold.start) * self.limits.mean_vertex_distance
        return replace(found, objective=base + limit * (1.0 + failed_share))

    def _succeeds(self, found: Evaluation) -> bool:
        return found.score is not None and self.limits.hold(found.score)

    def _passes(self, ask: Ask, indices: Sequence[int]) -> Iterator[bool]:
        """Yield whether the fold passes the scenarios, in order.

        A fold that fails mostly fails in one of the first scenarios, so these are simulated one after another if there
        is something to beat, and the others on half of the processors, at least two and at most four.
        """

        def passes(index: int) -> bool:
            found = self.inner.simulate(ask.parameters, self.sample[index])
            return self._succeeds(found) or Outcome.of(found, self.task.fold).cause(self.limits) == BESIDE_TARGET

        side_by_side = processors() > 1 and capabilities(self.task.simulator).parallel
        alone = len(indices) if not side_by_side else 0 if np.isinf(ask.beat) else 3
        yield from map(passes, indices[:alone])
        count = processors() if np.isinf(ask.beat) else max(2, min(4, processors() // 2))
        threads = ThreadPoolExecutor(count)
        try:
            yield from threads.map(passes, indices[alone:])
        finally:
            threads.shutdown(wait=False, cancel_futures=True)
