"""The paper's search: a Gaussian process with a Matern kernel without noise (beta = 0), and expected improvement.

It differs in two ways: the kernel has a length for each parameter, and a part of the objective may be known before a
trial, such as l_x of Eq. (10). Then the process models the logarithm of the rest, because objectives of good folds
differ by hundredths and those of bad folds by whole numbers. A proposal takes a few milliseconds.

Expected improvement (Jones et al. 1998) itself is too small for a number far from the best, so its logarithm is used.
Let b be the lowest objective so far, C the objective at a point, EI the expected improvement, and Phi and phi the
distribution function and the density of the standard normal variable. C is either a normal variable Y, or a known part
l plus a log-normal variable e^Y:

    C = Y,          Y ~ N(m, s^2):      EI = s (z Phi(z) + phi(z)),                      z = (b - m) / s
    C = l + e^Y,    Y ~ N(m, s^2):      EI = (b - l) Phi(d) - e^(m + s^2/2) Phi(d - s),  d = (log(b - l) - m) / s

The second is also the price of a put option (Black and Scholes 1973). It is for the objective C = l_x + alpha D of Eq.
(10), whose part l_x is known before a trial runs, while alpha D is positive.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.special import erfcx, log_ndtr, ndtr
from threadpoolctl import ThreadpoolController

from tatamu.search.gaussian_process import GaussianProcess
from tatamu.search.search import Search
from tatamu.search.space import KnownPart, Parameters, Space

THREADS = ThreadpoolController()
"""Controls the threads of linear algebra. With more than one, small matrices take ten times as long."""
APART = 0.03
"""Minimum difference between a proposal and every known or pending point in at least one parameter, in sides of the
cube."""
LOG_SQRT_2PI = 0.5 * np.log(2.0 * np.pi)
TINY = 1e-300


class GPSearch(Search):
    """Search that proposes the point of largest expected improvement. Its first proposal is random."""

    def propose(self) -> tuple[Parameters, float | None]:
        seed = self.sub_seed()
        if not self.known:
            return self.space.random(seed), None
        points = self.space.points([each.parameters for each in self.known])
        objectives = np.array([each.objective for each in self.known])
        pending = self.space.points(self.pending)
        taken = np.concatenate([points, pending])
        best = points[np.argsort(objectives, kind="stable")[:4]]
        with THREADS.limit(limits=1):
            improvement = _acquisition(self.space, points, objectives, pending)

            def acquisition(at: np.ndarray) -> np.ndarray:
                """Lower the improvement near known and pending points: they are proposed only if no other improves."""
                near = (np.abs(at[:, None] - taken[None]).max(axis=2) < APART).any(axis=1)
                return improvement(at) - 1e9 * near

            point, height = maximise(acquisition, self.space, best, np.random.default_rng(seed))
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
    acquisition: Callable[[np.ndarray], np.ndarray], space: Space, best: np.ndarray, random: np.random.Generator
) -> tuple[np.ndarray, float]:
    """Return the d coordinates of the point with the maximum acquisition, and this maximum.

    Points are scattered over the cube and around the best trials, then clouds around the best points become narrower.
    Spreads are standard deviations in sides of the cube. Gradients would save little time, because a thousand points
    are evaluated in a millisecond.
    """
    scattered = random.random((1024, space.dimensions))
    middles = best[random.integers(len(best), size=512)]
    spreads = random.choice((0.02, 0.1, 0.3), size=(len(middles), 1))
    around = middles + spreads * random.standard_normal(middles.shape)
    points = space.snap(np.concatenate([scattered, around]))
    heights = acquisition(points)
    spread = 0.15
    for _ in range(8):
        top = np.argsort(-heights, kind="stable")[:6]
        middles = np.repeat(points[top], 21, axis=0)
        steps = spread * random.standard_normal(middles.shape)
        changed = random.random(middles.shape) < 0.6  # other coordinates stay those of the point in the middle
        cloud = space.snap(middles + steps * changed)
        points = np.concatenate([points[top], cloud])
        heights = np.concatenate([heights[top], acquisition(cloud)])
        spread *= 0.6
    highest = int(np.argmax(heights))
    return points[highest], float(heights[highest])


def log_expected_improvement(best: float, mean: np.ndarray, deviation: np.ndarray) -> np.ndarray:
    """Return the logarithm of the expected improvement at p points with normal objectives, shape (p,)."""
    z = (best - mean) / deviation
    near = z > -1.0  # below, the two terms of the usual formula nearly cancel
    found = np.empty_like(z)
    density = np.exp(-0.5 * z[near] ** 2 - LOG_SQRT_2PI)
    found[near] = np.log(z[near] * ndtr(z[near]) + density + TINY)
    away = -z[~near]
    mills = np.sqrt(np.pi / 2.0) * erfcx(away / np.sqrt(2.0))  # Phi(-a) / phi(a)
    found[~near] = -0.5 * away**2 - LOG_SQRT_2PI + np.log(np.maximum(1.0 - away * mills, TINY))
    return found + np.log(deviation)


def log_expected_improvement_beyond(
    best: float, known: np.ndarray, mean: np.ndarray, deviation: np.ndarray
) -> np.ndarray:
    """Return the logarithm of the expected improvement at p points with a known and a log-normal part, shape (p,).

    Mean and deviation are those of the log-normal part's logarithm. The result is -inf if the known part is not below
    best.
    """
    room = best - known
    hopeful = room > 0.0
    log_room = np.log(np.where(hopeful, room, 1.0))
    d = (log_room - mean) / deviation
    gain = log_ndtr(d) + log_room
    cost = mean + 0.5 * deviation**2 + log_ndtr(d - deviation)
    difference = np.minimum(cost - gain, -1e-12)
    return np.where(hopeful, gain + np.log(-np.expm1(difference)), -np.inf)
