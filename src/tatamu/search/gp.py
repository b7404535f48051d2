"""The paper's search: a Gaussian process with a Matern kernel without noise (beta = 0), and expected improvement.

It differs in two ways: the kernel has a length for each parameter, and a part of the objective may be known before a
trial, such as l_x of Eq. (10). Then the process models the logarithm of the rest, because objectives of good folds
differ by hundredths and those of bad folds by whole numbers. A proposal takes a few milliseconds.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from threadpoolctl import ThreadpoolController

from tatamu.search.expected_improvement import log_expected_improvement, log_expected_improvement_beyond
from tatamu.search.gaussian_process import GaussianProcess
from tatamu.search.search import Search
from tatamu.search.space import KnownPart, Parameters, Space

THREADS = ThreadpoolController()
"""Controls the threads of linear algebra. With more than one, small matrices take ten times as long."""
APART = 0.03
"""Minimum difference between a proposal and every known or pending point in at least one parameter, in sides of the
cube."""


@dataclass(frozen=True)
class Maximisation:
    """How to maximise an acquisition function: points are scattered, then clouds around the best become narrower.

    Spreads are standard deviations in sides of the unit cube.
    """

    scattered: int = 1024
    around_best: int = 512
    """Number of points around the best trials at the start."""
    best_trials: int = 4
    spreads: tuple[float, ...] = (0.02, 0.1, 0.3)
    kept: int = 6
    """How many points each round keeps, to place new ones around them."""
    per_kept: int = 21
    rounds: int = 8
    first_spread: float = 0.15
    narrowing: float = 0.6
    """Ratio of the spread in a round to that in the round before."""
    changed: float = 0.6
    """Probability, for each coordinate, that a new point differs from the one around which it is placed."""


class GPSearch(Search):
    """Search that proposes the point of largest expected improvement. Its first proposal is random."""

    maximisation = Maximisation()

    def propose(self) -> tuple[Parameters, float | None]:
        seed = self.sub_seed()
        if not self.known:
            return self.space.random(seed), None
        points = self.space.points([each.parameters for each in self.known])
        objectives = np.array([each.objective for each in self.known])
        pending = self.space.points(self.pending)
        taken = np.concatenate([points, pending])
        best = points[np.argsort(objectives, kind="stable")[: self.maximisation.best_trials]]
        with THREADS.limit(limits=1):
            improvement = _acquisition(self.space, points, objectives, pending)

            def acquisition(at: np.ndarray) -> np.ndarray:
                """Lower the improvement near known and pending points: they are proposed only if no other improves."""
                near = (np.abs(at[:, None] - taken[None]).max(axis=2) < APART).any(axis=1)
                return improvement(at) - 1e9 * near

            point, height = maximise(acquisition, self.space, best, np.random.default_rng(seed), self.maximisation)
        return self.space.parameters(point), float(np.exp(height) / objectives.min())


def _acquisition(
    space: Space, points: np.ndarray, objectives: np.ndarray, pending: np.ndarray
) -> Callable[[np.ndarray], np.ndarray]:
    """Return log expected improvement over the best trial, shape (p,), as a function of p points, shape (p, d)."""
    best = float(objectives.min())
    if space.known_part is None:
        process, centre, spread = fit_standardised(points, objectives, pending)
        least = (best - centre) / spread
        return lambda at: np.log(spread) + log_expected_improvement(least, *process.predict(at))
    known_part: KnownPart = space.known_part
    unknown = np.maximum(objectives - known_part(space.values(points)), 1e-6)  # rounding errors could make it negative
    process, centre, spread = fit_standardised(points, np.log(unknown), pending)

    def improvement(at: np.ndarray) -> np.ndarray:
        mean, deviation = process.predict(at)
        return log_expected_improvement_beyond(
            best, known_part(space.values(at)), centre + spread * mean, spread * deviation
        )

    return improvement


def fit_standardised(
    points: np.ndarray, values: np.ndarray, pending: np.ndarray
) -> tuple[GaussianProcess, float, float]:
    """Return a process of standardised values that believes pending points, with the values' centre and spread."""
    centre = float(values.mean())
    spread = max(float(values.std()), 0.1)  # small differences stay small
    return GaussianProcess.fit(points, (values - centre) / spread).believing(pending), centre, spread


def maximise(
    acquisition: Callable[[np.ndarray], np.ndarray],
    space: Space,
    best: np.ndarray,
    random: np.random.Generator,
    settings: Maximisation,
) -> tuple[np.ndarray, float]:
    """Return the d coordinates of the point with the maximum acquisition, and this maximum.

    Gradients would save little time, because a thousand points are evaluated in a millisecond.
    """
    scattered = random.random((settings.scattered, space.dimensions))
    middles = best[random.integers(len(best), size=settings.around_best)]
    spreads = random.choice(settings.spreads, size=(settings.around_best, 1))
    around = middles + spreads * random.standard_normal(middles.shape)
    points = space.snap(np.concatenate([scattered, around]))
    heights = acquisition(points)
    spread = settings.first_spread
    for _ in range(settings.rounds):
        top = np.argsort(-heights, kind="stable")[: settings.kept]
        middles = np.repeat(points[top], settings.per_kept, axis=0)
        steps = spread * random.standard_normal(middles.shape)
        changed = random.random(middles.shape) < settings.changed
        cloud = space.snap(middles + steps * changed)
        points = np.concatenate([points[top], cloud])
        heights = np.concatenate([heights[top], acquisition(cloud)])
        spread *= settings.narrowing
    highest = int(np.argmax(heights))
    return points[highest], float(heights[highest])
