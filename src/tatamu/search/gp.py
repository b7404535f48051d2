"""The paper's search: a Gaussian process with a Matern kernel, and expected improvement.

The noise of observations is zero (beta = 0).

This search differs from the paper's search in two ways. First, the kernel has a separate length for each parameter.
Second, a part of the objective may be known before a trial runs, such as l_x of Eq. (10). Then the process models the
logarithm of the rest, and the known part need not be learned. The logarithm is used because objectives of good folds
differ from each other only by hundredths, but objectives of bad folds by whole numbers.

A proposal takes a few milliseconds.
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
"""Controls the number of threads of linear algebra. With more than one thread, small matrices take ten times as
long."""
MIN_UNKNOWN = 1e-6
"""Least value of the unknown part of an objective (the objective minus its known part).

Without this limit, rounding errors could make the unknown part zero or negative.
"""
MIN_DEVIATION = 0.1
"""Least standard deviation by which observed logarithms are divided.

Without it, small differences between nearly equal values would be enlarged to unit variance."""
APART = 0.03
"""Least difference between a proposal and every known or pending point, in at least one parameter.

It is a fraction of the side of the unit cube."""
TAKEN = 1e9
"""Amount by which log expected improvement is lowered at points nearer than `APART` to a known or pending point.

Such a point is proposed only if no other point is expected to improve on the best trial."""


@dataclass(frozen=True)
class Maximisation:
    """Settings of the search for the maximum of an acquisition function.

    Points are first scattered over the cube. In later rounds, clouds of points around the best points become narrower.
    """

    scattered: int = 1024
    """Number of points that are scattered over the whole unit cube at the start."""
    around_best: int = 512
    """Number of points that are placed around the best trials at the start."""
    best_trials: int = 4
    """Number of best trials around which points are placed."""
    spreads: tuple[float, ...] = (0.02, 0.1, 0.3)
    """Standard deviations of the points around the best trials, in sides of the unit cube."""
    kept: int = 6
    """Number of best points that each round of the maximisation keeps. New points are placed around them."""
    per_kept: int = 21
    """Number of new points that each round of the maximisation places around each of the best points."""
    rounds: int = 8
    first_spread: float = 0.15
    """Standard deviation of the new points in the first round of the maximisation, in sides of the unit cube."""
    narrowing: float = 0.6
    """Ratio of the new points' standard deviation in a round of the maximisation to that in the previous round."""
    changed: float = 0.6
    """Probability, for each coordinate, that a new point differs from the point around which it is placed."""


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
        with THREADS.limit(limits=1):
            acquisition = _acquisition(self.space, points, objectives, pending)
            best = leading(points, objectives, self.maximisation.best_trials)
            taken = np.concatenate([points, pending])
            acquisition = away_from(taken, acquisition)
            point, height = maximise(acquisition, self.space, best, np.random.default_rng(seed), self.maximisation)
        return self.space.parameters(point), float(np.exp(height) / objectives.min())


def _acquisition(
    space: Space, points: np.ndarray, objectives: np.ndarray, pending: np.ndarray
) -> Callable[[np.ndarray], np.ndarray]:
    """Return a function that gives log expected improvement over the best trial.

    The argument of this function is an array of p points with d coordinates, shape (p, d). The result has the shape
    (p,).
    """
    best = float(objectives.min())
    if space.known_part is None:
        process, centre, spread = fit_standardised(points, objectives, pending)
        least = (best - centre) / spread
        return lambda at: np.log(spread) + log_expected_improvement(least, *process.predict(at))
    known_part: KnownPart = space.known_part
    process, centre, spread = fit_standardised(points, log_unknown(space, points, objectives), pending)

    def improvement(at: np.ndarray) -> np.ndarray:
        mean, deviation = process.predict(at)
        return log_expected_improvement_beyond(
            best, known_part(space.values(at)), centre + spread * mean, spread * deviation
        )

    return improvement


def away_from(taken: np.ndarray, acquisition: Callable[[np.ndarray], np.ndarray]) -> Callable[[np.ndarray], np.ndarray]:
    """Return an acquisition function whose values are lowered near n taken points, shape (n, d).

    Taken points are known or pending. A point is near if it differs by less than `APART` from a taken point.
    """

    def lowered(at: np.ndarray) -> np.ndarray:
        near = (np.abs(at[:, None] - taken[None]).max(axis=2) < APART).any(axis=1)
        return acquisition(at) - TAKEN * near

    return lowered


def log_unknown(space: Space, points: np.ndarray, objectives: np.ndarray) -> np.ndarray:
    """Return the logarithms of the unknown parts of n objectives, shape (n,).

    The unknown part is the objective minus its known part. If no part is known, return the objectives themselves.
    """
    if space.known_part is None:
        return objectives
    return np.asarray(np.log(np.maximum(objectives - space.known_part(space.values(points)), MIN_UNKNOWN)))


def leading(points: np.ndarray, objectives: np.ndarray, count: int) -> np.ndarray:
    """Return the `count` points with the lowest objectives, best first, shape (count, d)."""
    return points[np.argsort(objectives, kind="stable")[:count]]


def fit_standardised(
    points: np.ndarray, values: np.ndarray, pending: np.ndarray, least: float = MIN_DEVIATION
) -> tuple[GaussianProcess, float, float]:
    """Fit a Gaussian process to standardised values, and add its own mean as an observation at pending points.

    Args:
        points: The n points of the unit cube whose values were observed, shape (n, d).
        values: Observed values, shape (n,).
        pending: Points of the p trials that are still running, shape (p, d).
        least: Least standard deviation by which values are divided. Without it, small differences would be enlarged.

    Returns:
        The process, and the two numbers with which the values were standardised: their centre and their spread.
    """
    centre = float(values.mean())
    spread = max(float(values.std()), least)
    return GaussianProcess.fit(points, (values - centre) / spread).believing(pending), centre, spread


def maximise(
    acquisition: Callable[[np.ndarray], np.ndarray],
    space: Space,
    best: np.ndarray,
    random: np.random.Generator,
    settings: Maximisation,
) -> tuple[np.ndarray, float]:
    """Find the point with the largest acquisition, and return its d coordinates and its acquisition.

    Gradients would save little time, because a thousand points are evaluated in a millisecond.

    Args:
        acquisition: Function of p points, shape (p, d), that returns their acquisition, shape (p,).
        space: The search space.
        best: Points of the b best trials, shape (b, d).
        random: Random number generator for the points.
        settings: Numbers of points that are tried, and their spreads.
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
