"""Gaussian-process regression of a function that is observed without noise (Rasmussen and Williams 2006).

    k(x, x') = s^2 (1 + sqrt(5) r + 5/3 r^2) exp(-sqrt(5) r),   r^2 = sum_k ((x_k - x'_k) / l_k)^2      Matern 5/2
    f(x)     ~ GP(mu, k)

The function f has the mean mu and the covariance k with the variance s^2. The lengths l_k are chosen so that their
posterior density is largest. Their prior is log-normal: log l_k has the mean m and the standard deviation v. For given
lengths, mu (generalised least squares) and s^2 have closed forms, so only the lengths are searched. The prior of s^2
counts like n0 = PRIOR_OBSERVATIONS observations of unit variance. y are the n observations, R is the matrix k / s^2 of
their points, and p is the posterior density. In this formula, r stands for y - mu:

    -log p = (n + n0)/2 log s^2 + 1/2 log |R| + sum_k (log l_k - m)^2 / (2 v^2),    s^2 = (r' R^-1 r + n0) / (n + n0)

The caller must standardise the observations to mean zero and variance one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dpotrf, dpotri, dpotrs, dtrtrs
from scipy.optimize import minimize

SQRT5 = np.sqrt(5.0)
JITTER = 1e-6
"""Number that is added to the diagonal of the correlation matrix R.

Without this number, R cannot be factorised if two observations lie close together.
"""
PRIOR_OBSERVATIONS = 2.0
"""Weight n0 of the prior of the variance, s^2 = 1. The prior counts like this number of observations."""
LOG_LENGTH_SPREAD = 1.0
"""Standard deviation v of log l_k in the prior of the lengths l_k."""
SHORTEST, LONGEST = 0.03, 30.0
"""Smallest and largest length l_k of the covariance, in sides of the unit cube."""
START = 0.5
"""Length l_k at which the search for the lengths starts, in sides of the unit cube."""
IMPOSSIBLE = 1e25
"""Loss that is returned for lengths with which the correlation matrix R cannot be factorised."""


@dataclass(frozen=True)
class GaussianProcess:
    """Gaussian process for a function that is known at n points of the unit cube with d dimensions."""

    points: np.ndarray
    """Points of the observations, shape (n, d)."""
    values: np.ndarray
    """Observed values, shape (n,)."""
    lengths: np.ndarray
    """Lengths l_k of the covariance, shape (d,)."""
    mean: float
    """Mean mu of the process."""
    variance: float
    """Variance s^2 of the process."""
    _factor: np.ndarray
    """Lower Cholesky factor of the correlation matrix R, shape (n, n)."""
    _weights: np.ndarray
    """Weights R^-1 (y - mu) of the observations y, shape (n,)."""

    @classmethod
    def fit(cls, points: np.ndarray, values: np.ndarray) -> GaussianProcess:
        """Fit the lengths, the mean and the variance.

        Args:
            points: Points of the observations in the unit cube, shape (n, d), with n at least 1.
            values: Observed values, standardised to mean zero and variance one, shape (n,).
        """
        dimensions = points.shape[1]
        posterior = _Posterior(points, values)
        found = minimize(
            posterior.loss,
            np.full(dimensions, np.log(START)),
            jac=True,
            method="L-BFGS-B",
            bounds=[(np.log(SHORTEST), np.log(LONGEST))] * dimensions,
            options={"maxiter": 30, "ftol": 1e-5, "gtol": 1e-2},
        )
        return cls._with(points, values, np.exp(found.x))

    @classmethod
    def _with(
        cls, points: np.ndarray, values: np.ndarray, lengths: np.ndarray, variance: float | None = None
    ) -> GaussianProcess:
        """Return the process for given observations and lengths l_k. The variance is estimated if it is None."""
        factor, _ = dpotrf(_with_jitter(_correlation(points, points, lengths)), lower=1)
        mean, weights, estimated = _closed_forms(factor, values)
        return cls(points, values, lengths, mean, estimated if variance is None else variance, factor, weights)

    def predict(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the mean and the standard deviation of the function at other points.

        Args:
            points: Points of the unit cube, p of them with d coordinates, shape (p, d).

        Returns:
            The means and the standard deviations at the points, two arrays of shape (p,).
        """
        correlation = _correlation(points, self.points, self.lengths)
        mean = self.mean + correlation @ self._weights
        whitened, _ = dtrtrs(self._factor, np.asfortranarray(correlation.T), lower=1)
        explained = np.einsum("ij,ij->j", whitened, whitened)
        return mean, np.sqrt(self.variance * np.maximum(1.0 + JITTER - explained, 1e-12))

    def believing(self, points: np.ndarray) -> GaussianProcess:
        """Return the process that results if its own mean is observed at p points with d coordinates, shape (p, d).

        This is the "kriging believer" (Ginsbourger et al. 2010). The mean does not change, and the standard deviation
        near the points becomes smaller. A search therefore avoids points near trials that are still running.
        """
        if not len(points):
            return self
        everything = np.concatenate([self.points, points])
        believed, _ = self.predict(points)
        values = np.concatenate([self.values, believed])
        return self._with(everything, values, self.lengths, self.variance)


class _Posterior:
    """Negative logarithm of the posterior density of the lengths, with its gradient."""

    def __init__(self, points: np.ndarray, values: np.ndarray) -> None:
        count, dimensions = points.shape
        squares = (points[:, None] - points[None]) ** 2
        self._squares = np.ascontiguousarray(squares.reshape(count * count, dimensions).T)  # (d, n n)
        self._values = values
        self._centre = np.sqrt(2.0) + 0.5 * np.log(dimensions) - 1.0
        """The mean m of the prior of log l_k.

        Lengths are longer in more dimensions, because points are farther apart there (Hvarfner et al. 2024)."""

    def loss(self, log_lengths: np.ndarray) -> tuple[float, np.ndarray]:
        """Return the negative logarithm of the density, up to a constant, and its gradient, shape (d,)."""
        count = len(self._values)
        inverse_squares = np.exp(-2.0 * log_lengths)
        distance = SQRT5 * np.sqrt(inverse_squares @ self._squares)
        decay = np.exp(-distance)
        correlation = (1.0 + distance + distance * distance / 3.0) * decay
        factor, singular = dpotrf(_with_jitter(correlation.reshape(count, count)), lower=1)
        if singular:
            return IMPOSSIBLE, np.zeros_like(log_lengths)
        _, weights, variance = _closed_forms(factor, self._values)
        deviation = (log_lengths - self._centre) / LOG_LENGTH_SPREAD
        loss = 0.5 * (count + PRIOR_OBSERVATIONS) * np.log(variance) + np.log(np.diag(factor)).sum()
        loss += 0.5 * (deviation @ deviation)
        lower, _ = dpotri(factor, lower=1)
        inverse = np.tril(lower) + np.tril(lower, -1).T
        sensitivity = (np.outer(weights, weights) / variance - inverse).ravel()
        sensitivity *= 5.0 / 3.0 * (1.0 + distance) * decay  # times dR / dlog l_k, without squares / l_k^2
        gradient = -0.5 * inverse_squares * (self._squares @ sensitivity)
        return float(loss), gradient + deviation / LOG_LENGTH_SPREAD


def _correlation(a: np.ndarray, b: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Return the correlations between the function's values at p points and at q other points, shape (p, q)."""
    a = a / lengths
    b = b / lengths
    square = (a * a).sum(axis=1)[:, None] + (b * b).sum(axis=1) - 2.0 * a @ b.T
    distance = SQRT5 * np.sqrt(np.maximum(square, 0.0))
    return (1.0 + distance + distance * distance / 3.0) * np.exp(-distance)


def _with_jitter(correlation: np.ndarray) -> np.ndarray:
    correlation[np.diag_indices_from(correlation)] += JITTER
    return correlation


def _closed_forms(factor: np.ndarray, values: np.ndarray) -> tuple[float, np.ndarray, float]:
    """Return the mean mu, the weights R^-1 (y - mu) and the variance s^2, from the Cholesky factor of R."""
    ones = np.ones_like(values)
    solved, _ = dpotrs(factor, np.column_stack([values, ones]), lower=1)
    mean = float(solved[:, 0].sum() / solved[:, 1].sum())
    weights = solved[:, 0] - mean * solved[:, 1]
    variance = ((values - mean) @ weights + PRIOR_OBSERVATIONS) / (len(values) + PRIOR_OBSERVATIONS)
    return mean, weights, float(variance)
