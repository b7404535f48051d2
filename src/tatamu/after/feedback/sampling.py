"""Tempered sampling of a posterior whose prior is standard normal: sequential Monte Carlo with pCN moves.

A member is one point of an ensemble. All members are drawn from the prior. The likelihood is then introduced in steps.
Each step raises the exponent of the likelihood. It raises it as far as the effective sample size of the importance
weights allows. Then the members are resampled and moved by the preconditioned Crank-Nicolson proposal z' = sqrt(1 -
r^2) z + r xi. This proposal does not change the prior distribution. z is a member, xi a standard normal vector, and r
the size of the move.

Sources: Del Moral, Doucet and Jasra 2006, J. Royal Statistical Society B 68; Cotter, Roberts, Stuart and White 2013,
Statistical Science 28; Kantas, Beskos and Jasra 2014, SIAM/ASA J. Uncertainty Quantification 2.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

MEMBERS = 4000
"""Number of members, the points of the ensemble."""
KEPT = 0.5
"""Effective sample size that each step keeps, as a fraction of the members."""
MOVES = 20
"""Number of moves of each member in each step."""
ACCEPTED = 0.3
"""Intended fraction of accepted moves."""
MOST_STEPS = 60
"""Largest number of steps. If more steps are needed, the observation counts as impossible."""


@dataclass(frozen=True)
class Sample:
    """Equally probable members (points) of a posterior."""

    members: np.ndarray
    """The members, each a vector of standard normal numbers, shape (members, dimensions)."""
    effective: float
    """Effective number of members of the prior from which these members come."""
    evidence: float
    """Logarithm of the mean likelihood under the prior."""
    steps: int
    """Number of steps."""


def sample(likelihood: Callable[[np.ndarray], np.ndarray], dimensions: int, seed: int) -> Sample:
    """Return members of a posterior.

    Args:
        likelihood: Function that returns the logarithm of each member's likelihood, shape (members,). Its argument has
            the shape (members, dimensions).
        dimensions: Number of dimensions.
        seed: Random seed.
    """
    generator = np.random.default_rng(np.random.SeedSequence([seed, dimensions]))
    members = generator.standard_normal((MEMBERS, dimensions))
    values = likelihood(members)
    origins = np.arange(MEMBERS)
    power, evidence, steps, reach = 0.0, 0.0, 0, 0.5
    while power < 1.0 and steps < MOST_STEPS:
        step = _step(values, 1.0 - power)
        weights, mean = _weights(step * values)
        power, evidence, steps = power + step, evidence + mean, steps + 1
        chosen = _resampled(weights, generator)
        members, values, origins = members[chosen], values[chosen], origins[chosen]
        for _ in range(MOVES):
            proposed = np.sqrt(1.0 - reach**2) * members + reach * generator.standard_normal(members.shape)
            new = likelihood(proposed)
            accepted = np.log(generator.random(MEMBERS)) < power * (new - values)
            members = np.where(accepted[:, None], proposed, members)
            values = np.where(accepted, new, values)
            reach = float(np.clip(reach * np.exp(0.5 * (accepted.mean() - ACCEPTED)), 0.01, 1.0))
    counts = np.bincount(origins, minlength=MEMBERS)
    return Sample(members, float(MEMBERS**2 / (counts**2).sum()), evidence, steps)


def _step(values: np.ndarray, left: float) -> float:
    """Return the largest step of the exponent that keeps the effective sample size. Bisection finds it."""
    if _effective(left * values) >= KEPT * len(values):
        return left
    low, high = 0.0, left
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _effective(middle * values) >= KEPT * len(values) else (low, middle)
    return low


def _effective(logarithms: np.ndarray) -> float:
    weights, _ = _weights(logarithms)
    return float(1.0 / (weights**2).sum())


def _weights(logarithms: np.ndarray) -> tuple[np.ndarray, float]:
    """Return weights that sum to 1, and the logarithm of the mean of the unnormalised weights."""
    most = logarithms.max()
    raw = np.exp(logarithms - most)
    return raw / raw.sum(), float(most + np.log(raw.mean()))


def _resampled(weights: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """Return one index per member, by systematic resampling (Kitagawa 1996)."""
    places = (generator.random() + np.arange(len(weights))) / len(weights)
    return np.minimum(np.searchsorted(np.cumsum(weights), places), len(weights) - 1)
