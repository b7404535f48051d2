"""Covariance matrix adaptation evolution strategy, CMA-ES (Hansen 2016), by the package `cmaes`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from cmaes import CMA

from tatamu.search.search import Observation, Search
from tatamu.search.space import Parameters, Space


class CMASearch(Search):
    """Search that draws each proposal from a normal distribution, adapted to the results of earlier generations.

    The strategy is replayed from the observations, so that a proposal depends only on them, its index and the seed. The
    first one is random, as in Optuna's sampler.
    """

    def propose(self) -> tuple[Parameters, float | None]:
        seed = self.sub_seed()
        if not self.known:
            return self.space.random(seed), None
        strategy = replay_strategy(self.space, self.known)
        strategy.reseed_rng(seed % 2**32)
        return self.space.parameters(self.space.snap(strategy.ask()[None])[0]), None


def replay_strategy(space: Space, observations: Sequence[Observation]) -> CMA:
    """Return the strategy after all complete generations of observations, in the given order."""
    dimensions = space.dimensions
    bounds = np.tile([0.0, 1.0], (dimensions, 1))
    # the first generation is spread about the middle of the cube as in Optuna
    strategy = CMA(np.full(dimensions, 0.5), 1.0 / 6.0, bounds, seed=0, n_max_resampling=10 * dimensions)
    points = space.points([each.parameters for each in observations])
    size = strategy.population_size
    for first in range(0, len(points) - size + 1, size):
        generation = range(first, first + size)
        strategy.tell([(points[number], observations[number].objective) for number in generation])
    return strategy
