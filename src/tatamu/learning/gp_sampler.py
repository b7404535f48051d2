"""The paper's search as an Optuna sampler: Gaussian process, Matern kernel, expected improvement, no noise (beta = 0).

Two things are more than the paper's. The kernel has a length of its own for each parameter. And where a part of the
objective is known before a trial runs, as l_x of Eq. (10) is, the process models the logarithm of the rest alone: good
folds differ by hundredths and bad ones by ones, and what is known need not be learned.

A proposal takes a few milliseconds and depends on the finished trials, the running ones and the seed only.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from optuna.distributions import BaseDistribution
from optuna.samplers import BaseSampler, RandomSampler
from optuna.search_space import IntersectionSearchSpace
from optuna.study import Study
from optuna.trial import FrozenTrial, TrialState

from tatamu.learning.expected_improvement import log_expected_improvement, log_expected_improvement_beyond
from tatamu.learning.gaussian_process import GaussianProcess
from tatamu.learning.unit_cube import UnitCube

KnownPart = Callable[[Mapping[str, np.ndarray]], np.ndarray]
"""From parameters by name, each of shape (p,), to the part of the objective that is known, shape (p,)."""

SCATTERED = 1024
"""Points all over the cube at which the acquisition is looked at first."""
AROUND_BEST = 512
"""Points around the best trials, likewise."""
BEST_TRIALS = 4
SPREADS = (0.02, 0.1, 0.3)
"""Spreads of the points around the best trials, in sides of the cube."""
KEPT = 6
"""Points around which each round looks more closely."""
PER_KEPT = 21
"""Points around each of them in a round."""
ROUNDS = 8
FIRST_SPREAD, NARROWING = 0.15, 0.6
"""Spread of the first round, and that of each next one over that of the one before it."""
CHANGED = 0.6
"""Chance of each coordinate to be changed."""
LEAST_UNKNOWN = 1e-6
"""Where rounding leaves nothing beside the known part, the rest counts as this."""
LEAST_DEVIATION = 0.1
"""Of the observed logarithms: nearly equal ones are not blown up to unit variance."""


class GaussianProcessSampler(BaseSampler):
    """Proposes the point of largest expected improvement; the first trial is random."""

    def __init__(self, seed: int, known: KnownPart | None = None) -> None:
        """Make a sampler.

        Args:
            seed: Of its random points.
            known: The known part of the objective; None: nothing is known, and the objective itself is modelled.
        """
        self._random = np.random.default_rng(seed)
        self._known = known
        self._space = IntersectionSearchSpace()
        self._independent = RandomSampler(seed=seed)
        self.expected_gain: float | None = None
        """Expected improvement of the last proposal, as a part of the best objective; None: it was random."""

    def infer_relative_search_space(self, study: Study, trial: FrozenTrial) -> dict[str, BaseDistribution]:
        """The parameters that all finished trials have."""
        return self._space.calculate(study)

    def sample_relative(
        self, study: Study, trial: FrozenTrial, search_space: dict[str, BaseDistribution]
    ) -> dict[str, Any]:
        """Parameters of the next trial; none where no trial has finished."""
        finished = study.get_trials(deepcopy=False, states=(TrialState.COMPLETE,))
        if not finished or not search_space:
            return {}
        cube = UnitCube(search_space)
        running = study.get_trials(deepcopy=False, states=(TrialState.RUNNING,))
        pending = [other.params for other in running if search_space.keys() <= other.params.keys()]
        points = cube.points([other.params for other in finished])
        objectives = np.array([other.values[0] for other in finished])
        acquisition = self._acquisition(cube, points, objectives, cube.points(pending))
        best = points[np.argsort(objectives, kind="stable")[:BEST_TRIALS]]
        point, height = maximised(acquisition, cube, best, self._random)
        self.expected_gain = float(np.exp(height) / objectives.min())
        return cube.parameters(point)

    def sample_independent(
        self, study: Study, trial: FrozenTrial, param_name: str, param_distribution: BaseDistribution
    ) -> Any:
        """A random value: of the first trial."""
        return self._independent.sample_independent(study, trial, param_name, param_distribution)

    def _acquisition(
        self, cube: UnitCube, points: np.ndarray, objectives: np.ndarray, pending: np.ndarray
    ) -> Callable[[np.ndarray], np.ndarray]:
        """Log expected improvement over the best trial, from points, shape (p, d), to shape (p,)."""
        known = self._known
        best = float(objectives.min())
        if known is None:
            process, centre, spread = standardised_fit(points, objectives, pending)
            least = (best - centre) / spread
            return lambda at: np.log(spread) + log_expected_improvement(least, *process.predict(at))
        unknown = np.maximum(objectives - known(cube.values(points)), LEAST_UNKNOWN)
        process, centre, spread = standardised_fit(points, np.log(unknown), pending)

        def improvement(at: np.ndarray) -> np.ndarray:
            mean, deviation = process.predict(at)
            return log_expected_improvement_beyond(
                best, known(cube.values(at)), centre + spread * mean, spread * deviation
            )

        return improvement


def standardised_fit(
    points: np.ndarray, values: np.ndarray, pending: np.ndarray, least: float = LEAST_DEVIATION
) -> tuple[GaussianProcess, float, float]:
    """The process of standardised values that expects its own mean at pending points; centre and spread.

    Args:
        points: Where the values were observed, in the unit cube, shape (n, d).
        values: What was observed, shape (n,).
        pending: Where trials are still running, shape (p, d).
        least: Least spread; nearly equal values are not blown up to unit variance.
    """
    centre = float(values.mean())
    spread = max(float(values.std()), least)
    return GaussianProcess.fit(points, (values - centre) / spread).believing(pending), centre, spread


def maximised(
    acquisition: Callable[[np.ndarray], np.ndarray], cube: UnitCube, best: np.ndarray, random: np.random.Generator
) -> tuple[np.ndarray, float]:
    """The point of largest acquisition that is found, shape (d,), and the acquisition there.

    Scattered points first, and points around the best trials, shape (b, d); then ever narrower clouds around the
    highest. Gradients would gain little: one look at a thousand points takes a millisecond.
    """
    scattered = random.random((SCATTERED, cube.dimensions))
    middles = best[random.integers(len(best), size=AROUND_BEST)]
    spreads = random.choice(SPREADS, size=(AROUND_BEST, 1))
    around = middles + spreads * random.standard_normal(middles.shape)
    points = cube.snapped(np.concatenate([scattered, around]))
    heights = acquisition(points)
    spread = FIRST_SPREAD
    for _ in range(ROUNDS):
        top = np.argsort(-heights, kind="stable")[:KEPT]
        middles = np.repeat(points[top], PER_KEPT, axis=0)
        steps = spread * random.standard_normal(middles.shape)
        changed = random.random(middles.shape) < CHANGED
        cloud = cube.snapped(middles + steps * changed)
        points = np.concatenate([points[top], cloud])
        heights = np.concatenate([heights[top], acquisition(cloud)])
        spread *= NARROWING
    highest = int(np.argmax(heights))
    return points[highest], float(heights[highest])
