"""Covariance matrix adaptation evolution strategy (Hansen 2016) as an Optuna sampler, on the package `cmaes`.

Optuna's own sampler is made of the same package, but keeps its strategy in the trials that it proposed. This one makes
the strategy again from the finished trials, generation by generation, so that a proposal depends on these, on how many
trials there are, and on the seed only.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from cmaes import CMA
from optuna.distributions import BaseDistribution
from optuna.samplers import BaseSampler, RandomSampler
from optuna.search_space import IntersectionSearchSpace
from optuna.study import Study
from optuna.trial import FrozenTrial, TrialState

from tatamu.learning.unit_cube import UnitCube

FIRST_SPREAD = 1.0 / 6.0
"""Standard deviation of the first generation, about the middle, in sides of the unit cube; as Optuna's."""


class EvolutionSampler(BaseSampler):
    """Draws each trial from the normal distribution that whole generations of trials before it have led to.

    The first trial is random, as with Optuna's sampler.
    """

    def __init__(self, seed: int) -> None:
        """Make a sampler of one trial, whose draw has this seed."""
        self._seed = seed
        self._space = IntersectionSearchSpace()
        self._independent = RandomSampler(seed=seed)

    def infer_relative_search_space(self, study: Study, trial: FrozenTrial) -> dict[str, BaseDistribution]:
        """The parameters that all finished trials have."""
        return self._space.calculate(study)

    def sample_relative(
        self, study: Study, trial: FrozenTrial, search_space: dict[str, BaseDistribution]
    ) -> dict[str, Any]:
        """Parameters of the next trial; none where no trial has finished."""
        if not search_space:
            return {}
        cube = UnitCube(search_space)
        finished = study.get_trials(deepcopy=False, states=(TrialState.COMPLETE,))
        points = cube.points([other.params for other in finished])
        objectives = np.array([other.values[0] for other in finished])
        strategy = adapted(points, objectives)
        strategy.reseed_rng(self._seed % 2**32)
        return cube.parameters(cube.snapped(strategy.ask()[None])[0])

    def sample_independent(
        self, study: Study, trial: FrozenTrial, param_name: str, param_distribution: BaseDistribution
    ) -> Any:
        """A random value: of the first trial."""
        return self._independent.sample_independent(study, trial, param_name, param_distribution)


def adapted(points: np.ndarray, objectives: np.ndarray) -> CMA:
    """The strategy after all whole generations of observations, in the order given.

    Args:
        points: Where the objective was observed, in the unit cube, shape (n, d).
        objectives: What was observed, shape (n,).
    """
    dimensions = points.shape[1]
    bounds = np.tile([0.0, 1.0], (dimensions, 1))
    strategy = CMA(np.full(dimensions, 0.5), FIRST_SPREAD, bounds, seed=0, n_max_resampling=10 * dimensions)
    size = strategy.population_size
    for first in range(0, len(points) - size + 1, size):
        generation = slice(first, first + size)
        strategy.tell(list(zip(points[generation], objectives[generation].tolist(), strict=True)))
    return strategy
