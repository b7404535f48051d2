"""The posterior of a set-up's systematic errors: their normal distribution, given all its measured folds.

In fold n of a set-up, these marks were measured:

    y_n = b + A (s + r_n + c_n - mean) + e_n

The systematic errors s are the same in every fold, r_n are the random errors of fold n, and c_n is its correction. e_n
are the errors of ruler and emulator. The posterior is that of a Kalman filter, with two changes: the gain is computed
for larger systematic errors than stated, because stated deviations are guesses; and a fold whose numbers no systematic
error explains has less weight, because its errors are Student t variables.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc

from tatamu.after.feedback.emulator import ROUNDS, TAILS, Emulator
from tatamu.after.feedback.measured import MeasuredFold
from tatamu.base.errors import InputError
from tatamu.evaluation.disturbances import Disturbances, Scenario, Split, join, split
from tatamu.folding.score import MARKS

WIDER = 2.0
"""Factor of the systematic variances for which the gain is computed. The notes compare values."""
IMPLAUSIBLE = 1e-3
"""Chance below which a measured fold is left out, see `Fold.chance`."""


@dataclass(frozen=True)
class Fold:
    """A measured fold, the emulator of the fold that was carried out, and its correction."""

    measured: MeasuredFold
    emulator: Emulator
    correction: np.ndarray
    """Change of the disturbances that has the effect of the correction, shape (k,)."""

    @property
    def places(self) -> list[int]:
        """Indices of the measured marks."""
        return [MARKS.index(number.name) for number in self.measured.measured]

    @property
    def values(self) -> np.ndarray:
        """The measured numbers [m]."""
        return np.array([number.value for number in self.measured.measured])

    @property
    def slopes(self) -> np.ndarray:
        """Change of each measured number per unit of each disturbance, shape (numbers, k)."""
        return self.emulator.slopes[self.places]

    def apart(self, mean: np.ndarray) -> np.ndarray:
        """Return the measured numbers minus those that are expected with systematic errors [m]."""
        return self.values - self.emulator.marks(mean + self.correction)[self.places]

    def noise(self, random: np.ndarray) -> np.ndarray:
        """Return the covariance of what is new in each fold and of all errors of the numbers [m^2]."""
        ruler = np.array([number.deviation**2 for number in self.measured.measured])
        own = self.emulator.residual[np.ix_(self.places, self.places)]
        return np.asarray(self.slopes * random @ self.slopes.T + own + np.diag(ruler))

    def chance(self, prior: Split) -> float:
        """Return the chance of at least as large a deviation in a set-up that is worse than any should be.

        Its systematic deviations are four times as large as stated.
        """
        if not self.places:
            return 1.0
        wide = 4.0**2 * self.slopes @ prior.systematic @ self.slopes.T + 4.0 * self.noise(prior.random)
        apart = self.apart(prior.mean)
        return float(chdtrc(len(apart), apart @ np.linalg.solve(wide, apart)))


@dataclass(frozen=True)
class Alike:
    """Two disturbances that the measured folds cannot separate."""

    one: str
    other: str
    correlation: float


@dataclass(frozen=True)
class Posterior:
    """The k systematic errors of a set-up, given its measured folds."""

    prior: Split
    mean: np.ndarray
    """Means, shape (k,)."""
    covariance: np.ndarray
    """Covariance, shape (k, k)."""
    chances: tuple[float, ...]
    """Chance of each measured fold, see `Fold.chance`. Folds with less than `IMPLAUSIBLE` were left out."""
    used: int
    """Number of measured folds from which the posterior was computed."""
    source: Disturbances
    """The disturbances before any fold was measured."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the disturbances."""
        return self.prior.names

    @property
    def scenario(self) -> Scenario:
        """The scenario in which every disturbance has its posterior mean."""
        return Scenario({name: float(value) for name, value in zip(self.names, self.mean, strict=True) if value})

    @property
    def disturbances(self) -> Disturbances:
        """The posterior as disturbances. Their random parts are those of the prior."""
        return join(Split(self.names, self.mean, self.covariance, self.prior.random), self.source)

    @property
    def deviations(self) -> list[tuple[str, float, float]]:
        """Name, prior deviation and posterior deviation of each systematic error."""
        before, after = (
            np.sqrt(np.clip(np.diag(each), 0.0, None)) for each in (self.prior.systematic, self.covariance)
        )
        return [(name, float(b), float(a)) for name, b, a in zip(self.names, before, after, strict=True) if b]

    def undetermined(self, share: float = 0.9) -> list[str]:
        """Return the disturbances whose deviation is still at least the fraction `share` of that before."""
        return [name for name, before, after in self.deviations if after >= share * before]

    def alike(self, minimum: float = 0.4) -> list[Alike]:
        """Return pairs of disturbances that cannot be separated. The most correlated pair comes first."""
        scale = np.sqrt(np.clip(np.diag(self.covariance), 1e-30, None))
        now = self.covariance / np.outer(scale, scale)
        own = np.sqrt(np.clip(np.diag(self.prior.systematic), 1e-30, None))
        change = np.abs(now - self.prior.systematic / np.outer(own, own))
        pairs = [
            Alike(self.names[i], self.names[j], float(now[i, j]))
            for i in range(len(now))
            for j in range(i)
            if change[i, j] >= minimum
        ]
        return sorted(pairs, key=lambda pair: -abs(pair.correlation))

    def ends(self, emulator: Emulator, correction: np.ndarray) -> np.ndarray:
        """Return marks of n possible next folds with a correction, shape (k,) [m], shape (n, m); n is 4000."""
        slopes = emulator.slopes
        spread = slopes @ (self.covariance + np.diag(self.prior.random)) @ slopes.T + emulator.residual
        mean = emulator.marks(self.mean + correction)
        return np.random.default_rng(0).multivariate_normal(mean, spread, 4000, method="eigh")


def posterior(disturbances: Disturbances, folds: Sequence[Fold]) -> Posterior:
    """Return the posterior of a set-up's systematic errors. Implausible folds are left out.

    Raises:
        InputError: If no disturbance has a systematic part.
    """
    prior = split(disturbances)
    if not np.diag(prior.systematic).any():
        raise InputError("systematic: must be above 0 for at least one disturbance, given 0 for all")
    chances = tuple(fold.chance(prior) for fold in folds)
    used = [fold for fold, chance in zip(folds, chances, strict=True) if chance >= IMPLAUSIBLE and fold.places]
    mean, wide, covariance = prior.mean, WIDER * prior.systematic, prior.systematic
    for fold in used:
        gain, noise = _gain(fold, mean, wide, prior.random)
        mean = mean + gain @ fold.apart(mean)
        kept = np.eye(len(mean)) - gain @ fold.slopes
        wide, covariance = (kept @ each @ kept.T + gain @ noise @ gain.T for each in (wide, covariance))
    return Posterior(prior, mean, covariance, chances, len(used), disturbances)


def _gain(fold: Fold, mean: np.ndarray, covariance: np.ndarray, random: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the gain of a fold, shape (k, numbers), and the covariance of its errors, divided by its weight."""
    apart, noise, weight = fold.apart(mean), fold.noise(random), 1.0
    for _ in range(ROUNDS):
        spread = fold.slopes @ covariance @ fold.slopes.T + noise / weight
        gain = np.linalg.solve(spread, fold.slopes @ covariance).T
        left = apart - fold.slopes @ gain @ apart
        weight = min(1.0, (TAILS + len(left)) / (TAILS + left @ np.linalg.solve(noise, left)))
    return gain, noise / weight
