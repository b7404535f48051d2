"""Gaussian-process regression of a function that is observed without noise (Rasmussen and Williams 2006).

    k(x, x') = s^2 (1 + sqrt(5) r + 5/3 r^2) exp(-sqrt(5) r),   r^2 = sum_k ((x_k - x'_k) / l_k)^2      Matern 5/2
    f(x)     ~ GP(mu, k)

The lengths l_k have the largest posterior density, with a log-normal prior: log l_k has the mean m and the standard
deviation v. For given lengths, mu (generalised least squares) and s^2 have closed forms. The prior of s^2 counts like
n0 = PRIOR_OBSERVATIONS observations of unit variance. With the n observations y, the matrix R = k / s^2 of their
points, and here r = y - mu, the density p is

    -log p = (n + n0)/2 log s^2 + 1/2 log |R| + sum_k (log l_k - m)^2 / (2 v^2),    s^2 = (r' R^-1 r + n0) / (n + n0)

The caller standardises the observations to mean zero and variance one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dpotrf, dpotri, dpotrs, dtrtrs
from scipy.optimize import minimize

SQRT5 = np.sqrt(5.0)
JITTER = 1e-6
"""Added to the diagonal of R, which otherwise cannot be factorised if two observations lie close together."""
PRIOR_OBSERVATIONS = 2.0
LOG_LENGTH_SPREAD = 1.0
"""Standard deviation v of log l_k in its prior."""


@dataclass(frozen=True)
class GaussianProcess:
    """A process for a function that is known at n points of the unit cube, shape (n, d)."""

    points: np.ndarray
    values: np.ndarray
    """Observed values, shape (n,)."""
    lengths: np.ndarray
    """Lengths l_k, shape (d,)."""
    mean: float
    variance: float
    _factor: np.ndarray
    """Lower Cholesky factor of R, shape (n, n)."""
    _weights: np.ndarray
    """R^-1 (y - mu), shape (n,)."""

    @classmethod
    def fit(cls, points: np.ndarray, values: np.ndarray) -> GaussianProcess:
        """Fit the lengths, the mean and the variance to at least one value."""
        dimensions = points.shape[1]
        posterior = _Posterior(points, values)
        found = minimize(
            posterior.loss,
            np.full(dimensions, np.log(0.5)),
            jac=True,
            method="L-BFGS-B",
            bounds=[(np.log(0.03), np.log(30.0))] * dimensions,
            options={"maxiter": 30, "ftol": 1e-5, "gtol": 1e-2},
        )
        return cls._with(points, values, np.exp(found.x))

    @classmethod
    def _with(
        cls, points: np.ndarray, values: np.ndarray, lengths: np.ndarray, variance: float | None = None
    ) -> GaussianProcess:
        factor, _ = dpotrf(_with_jitter(_correlation(points, points, lengths)), lower=1)
        mean, weights, estimated = _closed_forms(factor, values)
        return cls(points, values, lengths, mean, estimated if variance is None else variance, factor, weights)

    def predict(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the mean and the standard deviation of the function at p points, shape (p, d), both of shape (p,)."""
        correlation = _correlation(points, self.points, self.lengths)
        mean = self.mean + correlation @ self._weights
        whitened, _ = dtrtrs(self._factor, np.asfortranarray(correlation.T), lower=1)
        explained = np.einsum("ij,ij->j", whitened, whitened)
        return mean, np.sqrt(self.variance * np.maximum(1.0 + JITTER - explained, 1e-12))

    def believing(self, points: np.ndarray) -> GaussianProcess:
        """Return the process that results if its own mean is observed at p points, shape (p, d).

        With this "kriging believer" (Ginsbourger et al. 2010), the deviation near the points becomes smaller, so a
        search avoids points near trials that are still running.
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
        """The mean m: lengths are longer in more dimensions, where points are farther apart (Hvarfner et al. 2024)."""

    def loss(self, log_lengths: np.ndarray) -> tuple[float, np.ndarray]:
        """Return -log p, up to a constant, and its gradient, shape (d,)."""
        count = len(self._values)
        inverse_squares = np.exp(-2.0 * log_lengths)
        distance = SQRT5 * np.sqrt(inverse_squares @ self._squares)
        decay = np.exp(-distance)
        correlation = (1.0 + distance + distance * distance / 3.0) * decay
        factor, singular = dpotrf(_with_jitter(correlation.reshape(count, count)), lower=1)
        if singular:
            return 1e25, np.zeros_like(log_lengths)
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
    """Return the correlations between the function's values at p and at q points, shape (p, q)."""
    a = a / lengths
    b = b / lengths
    square = (a * a).sum(axis=1)[:, None] + (b * b).sum(axis=1) - 2.0 * a @ b.T
    distance = SQRT5 * np.sqrt(np.maximum(square, 0.0))
    return (1.0 + distance + distance * distance / 3.0) * np.exp(-distance)


def _with_jitter(correlation: np.ndarray) -> np.ndarray:
    correlation[np.diag_indices_from(correlation)] += JITTER
    return correlation


def _closed_forms(factor: np.ndarray, values: np.ndarray) -> tuple[float, np.ndarray, float]:
    """Return mu, R^-1 (y - mu) and s^2, from the Cholesky factor of R."""
    ones = np.ones_like(values)
    solved, _ = dpotrs(factor, np.column_stack([values, ones]), lower=1)
    mean = float(solved[:, 0].sum() / solved[:, 1].sum())
    weights = solved[:, 0] - mean * solved[:, 1]
    variance = ((values - mean) @ weights + PRIOR_OBSERVATIONS) / (len(values) + PRIOR_OBSERVATIONS)
    return mean, weights, float(variance)
