"""The posterior of the systematic errors of a set-up: their distribution, given all its observed folds.

In the observed fold number n of a set-up, these marks (lengths) were measured:

    y_n = marks(s + r_n + c_n) + e_n

s are the systematic disturbances, which are the same in every fold. r_n are the random disturbances of fold n, and c_n
is its correction. e_n are the errors of the ruler and of the emulator. The prior of s and r_n comes from the
disturbance file. However, its deviations are known only up to a factor. s, this factor and all r_n are sampled
together, given all y_n.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import log_ndtr

from tatamu.after.feedback.draws import WIDER
from tatamu.after.feedback.emulator import TAILS, Emulator
from tatamu.after.feedback.measured import Observation
from tatamu.after.feedback.sampling import sample
from tatamu.base.errors import InputError
from tatamu.evaluation.disturbances import Disturbances, Split, World, join, split
from tatamu.folding.marks import MARKS
from tatamu.folding.score import Limits

WIDTH = 1.0
"""Uncertainty of the deviations in a file: standard deviation of the logarithm of their error factor."""
NINETY = 3.29
"""Width of the 90 % interval of a normal distribution, in its standard deviations."""
UNSURE_DISTANCE = 0.003
"""Standard deviation of an emulated mean vertex distance [m]. It is used if a fold was observed as failed."""
SET_UPS = 10_000
"""Number of simulated set-ups with which an observation is compared, to decide whether it is plausible."""
IMPLAUSIBLE = 1e-3
"""Probability below which an observation is implausible. It refers to set-ups with twice the given deviations."""


@dataclass(frozen=True)
class Fold:
    """An observed fold: its measurement, and the learned fold."""

    observation: Observation
    emulator: Emulator
    correction: np.ndarray
    """The correction of the hands' motion with which the fold was carried out, shape (k,).

    A corrected motion has the same effect as changed disturbances. The correction is given as these k changes."""

    @property
    def places(self) -> list[int]:
        """Indices of the measured marks (lengths)."""
        return [MARKS.index(number.name) for number in self.observation.measured]

    @property
    def values(self) -> np.ndarray:
        """The measured numbers [m]."""
        return np.array([number.value for number in self.observation.measured])

    @property
    def _ruler(self) -> np.ndarray:
        """Standard deviations of the measured numbers [m]."""
        return np.array([number.deviation for number in self.observation.measured])

    @cached_property
    def _whitened(self) -> tuple[np.ndarray, np.ndarray]:
        """Axes along which errors of the emulator are independent, and the variances of the errors along these axes.

        The unit of each variance is the variance of the ruler.
        """
        own = self.emulator.residual[np.ix_(self.places, self.places)] / np.outer(self._ruler, self._ruler)
        variances, axes = np.linalg.eigh(own)
        return axes / self._ruler[:, None], np.clip(variances, 0.0, None)

    def likelihood(self, values: np.ndarray) -> np.ndarray:
        """Return the logarithm of the likelihood of each member, shape (members,).

        A member is one set of the k disturbances of this fold. `values` has the shape (members, k).
        """
        corrected = values + self.correction
        marks = self.emulator.marks(corrected)
        total = np.zeros(len(values))
        if self.places:
            axes, own = self._whitened
            variances = 1.0 + self.emulator.inputs.widths(corrected)[:, None] * own
            squared = (((self.values - marks[:, self.places]) @ axes) ** 2 / variances).sum(axis=1)
            total -= 0.5 * np.log(variances).sum(axis=1)
            total -= 0.5 * (TAILS + len(self.places)) * np.log1p(squared / TAILS)
        if not self.observation.held:
            beyond = self.emulator.distances(marks) - Limits().mean_vertex_distance
            total += log_ndtr(beyond / UNSURE_DISTANCE)
        return total

    def chance(self, prior: Split) -> float:
        """Return the probability that a random set-up gives at least as large a deviation as this fold.

        The deviations of the random set-up are `WIDER` times the given deviations.
        """
        if not self.places:
            return 1.0
        generator = np.random.default_rng(0)
        whole = WIDER**2 * (prior.systematic + np.diag(prior.random))
        values = generator.multivariate_normal(prior.mean + self.correction, whole, SET_UPS, method="eigh")
        ends = self.emulator.ends(values, generator)[:, self.places]
        ends += self._ruler * generator.standard_normal(ends.shape)
        away = np.vstack([ends, self.values]) - np.median(ends, axis=0)
        inverse = np.linalg.inv(np.atleast_2d(np.cov(ends.T)))
        squared = np.einsum("ij,jk,ik->i", away, inverse, away)
        return float((squared[:-1] >= squared[-1]).mean())


@dataclass(frozen=True)
class Alike:
    """Two disturbances that the observations cannot distinguish."""

    one: str
    other: str
    correlation: float


@dataclass(frozen=True)
class Posterior:
    """The k systematic disturbances of a set-up, given its observed folds.

    A member is one of many equally probable sets of values.
    """

    prior: Split
    members: np.ndarray
    """Equally probable sets of values of the systematic disturbances, shape (members, k)."""
    factor: np.ndarray
    """Factor of all deviations in the file for each member, shape (members, 1)."""
    effective: float
    """Effective number of members."""
    chances: tuple[float, ...]
    """Probability of each observed fold, see `Fold.chance`. Folds with less than `IMPLAUSIBLE` were left out."""
    source: Disturbances
    """The disturbances before any fold was observed."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the disturbances."""
        return self.prior.names

    @property
    def used(self) -> int:
        """Number of observed folds from which the posterior was computed."""
        return sum(chance >= IMPLAUSIBLE for chance in self.chances)

    @property
    def mean(self) -> np.ndarray:
        """Posterior means, shape (k,)."""
        return np.asarray(self.members.mean(axis=0)) if self.used else self.prior.mean

    @property
    def covariance(self) -> np.ndarray:
        """Posterior covariance of the systematic parts, shape (k, k). Its deviations are those of `_deviation`."""
        if not self.used:
            return self.prior.systematic
        scale = _deviation(self.members) / np.maximum(self.members.std(axis=0), 1e-30)
        return np.asarray(np.cov(self.members.T) * np.outer(scale, scale))

    @property
    def world(self) -> World:
        """The world in which every disturbance has its posterior mean."""
        return World({name: float(value) for name, value in zip(self.names, self.mean, strict=True) if value})

    @property
    def disturbances(self) -> Disturbances:
        """The posterior in the form of a file of disturbances. Its random parts are those of the prior."""
        return join(Split(self.names, self.mean, self.covariance, self.prior.random), self.source)

    @property
    def deviations(self) -> list[tuple[str, float, float]]:
        """Name, prior deviation and posterior deviation of each systematic part.

        The prior deviation contains the uncertainty of the deviations in the file.
        """
        widened = _widening(np.exp(WIDTH * np.random.default_rng(1).standard_normal(self.factor.shape)))
        before, after = (np.sqrt(np.diag(each)) for each in (widened**2 * self.prior.systematic, self.covariance))
        return [(name, float(b), float(a)) for name, b, a in zip(self.names, before, after, strict=True) if b]

    def untold(self, share: float = 0.9) -> list[str]:
        """Return the disturbances about which the observations tell little, except for the factor of all deviations.

        Their posterior deviation is at least the fraction `share` of the deviation that follows from this factor alone.
        """
        alone = dict(zip(self.names, _widening(self.factor) * np.sqrt(np.diag(self.prior.systematic)), strict=True))
        return [name for name, _, after in self.deviations if after >= share * alone[name]]

    def alike(self, least: float = 0.4) -> list[Alike]:
        """Return pairs of disturbances that cannot be distinguished. The most correlated pair comes first."""
        if not self.used:
            return []
        scale = np.sqrt(np.clip(np.diag(self.covariance), 1e-30, None))
        now = self.covariance / np.outer(scale, scale)
        own = np.sqrt(np.clip(np.diag(self.prior.systematic), 1e-30, None))
        change = now - self.prior.systematic / np.outer(own, own)
        pairs = [
            Alike(self.names[i], self.names[j], float(now[i, j]))
            for i in range(len(now))
            for j in range(i)
            if abs(change[i, j]) >= least
        ]
        return sorted(pairs, key=lambda pair: -abs(pair.correlation))

    def ends(self, emulator: Emulator, correction: np.ndarray) -> np.ndarray:
        """Return the m marks (lengths) with which the next fold may end [m], shape (members, m).

        They include random disturbances and errors of the emulator.

        Args:
            emulator: Emulator of the learned fold.
            correction: Changes of the k disturbances that have the same effect as the correction of the next fold,
                shape (k,).
        """
        generator = np.random.default_rng(0)
        random = generator.standard_normal(self.members.shape) * np.sqrt(self.prior.random)
        return emulator.ends(self.members + random + correction, generator)


def posterior(disturbances: Disturbances, folds: Sequence[Fold], seed: int = 0) -> Posterior:
    """Return the posterior of a set-up's systematic disturbances: their distribution after the observed folds.

    Implausible observed folds are left out, because the emulator would have to extrapolate outside the simulated draws.

    Args:
        disturbances: The disturbances before any observation.
        folds: All observed folds.
        seed: Random seed.

    Raises:
        InputError: If no disturbance has a systematic part.
    """
    prior = split(disturbances)
    if not np.diag(prior.systematic).any():
        raise InputError("systematic: must leave a part of some disturbance that is the same in every fold, given none")
    chances = tuple(fold.chance(prior) for fold in folds)
    used = [fold for fold, chance in zip(folds, chances, strict=True) if chance >= IMPLAUSIBLE]
    model = _Model(prior, used)
    drawn = sample(model.likelihood, model.dimensions, seed)
    members, factor = model.systematic(drawn.members), model.factor(drawn.members)
    return Posterior(prior, members, factor, drawn.effective, chances, disturbances)


def _deviation(members: np.ndarray) -> np.ndarray:
    """Return the standard deviations of the normal distributions with the 90 % intervals of members, shape (k,).

    The standard deviations of the members themselves depend on few very large values.
    """
    low, high = np.quantile(members, (0.05, 0.95), axis=0)
    return np.asarray((high - low) / NINETY)


def _widening(factor: np.ndarray) -> float:
    """Return the `_deviation` of a normal error whose standard deviation is the factor, shape (members, 1)."""
    errors = np.random.default_rng(0).standard_normal((len(factor), 25))
    return float(_deviation((factor * errors).reshape(-1, 1))[0])


class _Model:
    """The likelihood as a function of standard normal numbers.

    The numbers represent the systematic disturbances s, the factor of their deviations, and the random
    disturbances r_n.
    """

    def __init__(self, prior: Split, folds: Sequence[Fold]) -> None:
        self._prior = prior
        self._folds = folds
        self._root = prior.root
        self._new = np.flatnonzero(prior.random)
        self._count = len(prior.names)
        self.dimensions = self._count + 1 + len(folds) * len(self._new)

    def systematic(self, members: np.ndarray) -> np.ndarray:
        """Return the k systematic disturbances of each member (one sample of all numbers), shape (members, k)."""
        drawn = members[:, : self._count] @ self._root.T
        return np.asarray(self._prior.mean + self.factor(members) * drawn)

    def factor(self, members: np.ndarray) -> np.ndarray:
        """Return the factor of the deviations for each member (one sample of all numbers), shape (members, 1)."""
        return np.asarray(np.exp(WIDTH * members[:, [self._count]]))

    def likelihood(self, members: np.ndarray) -> np.ndarray:
        """Return the logarithm of the likelihood of each member (one sample of all numbers), shape (members,)."""
        same = self.systematic(members)
        deviations = self.factor(members) * np.sqrt(self._prior.random[self._new])
        total = np.zeros(len(members))
        first = self._count + 1
        for number, fold in enumerate(self._folds):
            values = same.copy()
            start = first + number * len(self._new)
            values[:, self._new] += members[:, start : start + len(self._new)] * deviations
            total += fold.likelihood(values)
        return total
