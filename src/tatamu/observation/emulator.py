"""An emulator of the simulator: where a fold ends in a world, from the draws that were simulated.

    marks(x) = b + A x + e,      x = (w - mean) / deviation

w are the disturbances of a world, A is fitted by ridge regression with Huber's weights, so that the few draws in which
a corner turned in or a hand slipped off do not decide it, and e is what remains: a Student t variable whose covariance
is that of the leave-one-out residuals. The mean vertex distance follows from the marks, d^2 = a + sum_i c_i marks_i^2
with a and c not negative.

Huber 1964, Annals of Mathematical Statistics 35; Kennedy and O'Hagan 2001, J. Royal Statistical Society B 63.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from tatamu.disturbances import World
from tatamu.errors import InputError
from tatamu.folding.marks import MARKS
from tatamu.robustness import Verdict

RIDGE = 1.0
"""Penalty of the coefficients, in draws: one observation of no effect for each disturbance."""
HUBER = 1.5
"""Number of robust deviations beyond which residuals count less."""
ROUNDS = 20
"""Rounds of reweighting; more change nothing."""
FEWEST = 40
"""Least number of draws to fit to."""


@dataclass(frozen=True)
class Emulator:
    """Marks of a fold as a linear function of disturbances; k disturbances, m = len(MARKS) marks."""

    names: tuple[str, ...]
    """Names of the disturbances."""
    centre: np.ndarray
    """Disturbances at which x is 0, shape (k,)."""
    scale: np.ndarray
    """Disturbances at which x is 1 more, shape (k,)."""
    base: np.ndarray
    """Marks b at the mean of the disturbances [m], shape (m,)."""
    slopes: np.ndarray
    """A [m], shape (k, m)."""
    residual: np.ndarray
    """Covariance of e [m^2], shape (m, m)."""
    distance: np.ndarray
    """a [m^2] and c [-], shape (1 + m,)."""
    seen: np.ndarray
    """Marks of the draws that it was fitted to [m], shape (n, m)."""
    weights: np.ndarray
    """Their Huber weights, shape (n,)."""

    def marks(self, values: np.ndarray) -> np.ndarray:
        """Return the marks [m], shape (.., m), of disturbances (.., k)."""
        return np.asarray(self.base + (values - self.centre) / self.scale @ self.slopes)

    def distances(self, marks: np.ndarray) -> np.ndarray:
        """Return mean vertex distances [m], shape (..,), of marks (.., m)."""
        return np.asarray(np.sqrt(self.distance[0] + marks**2 @ self.distance[1:]))

    def moved(self, by: Mapping[str, float]) -> np.ndarray:
        """Return a change of disturbances, shape (k,), by their names; those that are not emulated are left out."""
        return np.array([by.get(name, 0.0) for name in self.names])


def fit(
    names: Sequence[str],
    centre: np.ndarray,
    scale: np.ndarray,
    draws: Sequence[tuple[World, Verdict]],
    correction: np.ndarray,
) -> Emulator:
    """Fit an emulator to draws.

    Args:
        names: Names of the disturbances, k of them.
        centre: Their means, shape (k,).
        scale: Their standard deviations, above 0, shape (k,).
        draws: Worlds, and how the fold ended in them; those without marks are left out.
        correction: Marks of the nominal fold on the fine mesh less those on the mesh of the draws [m], shape (m,).

    Raises:
        InputError: If too few draws have marks.
    """
    known = [(world, verdict.marks, verdict.mean_vertex_distance) for world, verdict in draws]
    usable = [
        (world, marks, distance) for world, marks, distance in known if marks is not None and distance is not None
    ]
    if len(usable) < FEWEST:
        raise InputError(
            f"draws: at least {FEWEST} must end on the table to learn from, given {len(usable)} of {len(draws)}; "
            "learn a fold that holds more often"
        )
    x = np.array(
        [[(world[name] - c) / s for name, c, s in zip(names, centre, scale, strict=True)] for world, _, _ in usable]
    )
    y = np.array([[marks[name] for name in MARKS] for _, marks, _ in usable])
    base, slopes, weights, residual = _robust(x, y)
    distance = _distance_of(y, np.array([d for *_, d in usable]), weights)
    return Emulator(tuple(names), centre, scale, base + correction, slopes, residual, distance, y + correction, weights)


def _robust(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return b, A, the weights of the draws and the covariance of the leave-one-out residuals."""
    design = np.column_stack([np.ones(len(x)), x])
    penalty = np.diag([0.0, *[RIDGE] * x.shape[1]])
    weights = np.ones(len(x))
    for _ in range(ROUNDS):
        weighted = design * weights[:, None]
        inverse = np.linalg.inv(design.T @ weighted + penalty)
        coefficients = inverse @ weighted.T @ y
        errors = y - design @ coefficients
        spread = 1.4826 * np.median(np.abs(errors), axis=0) + 1e-6
        worst = np.abs(errors / spread).max(axis=1)
        weights = np.minimum(1.0, 2.0 * HUBER / np.maximum(worst, 1e-9))
    leverage = weights * np.einsum("ij,jk,ik->i", design, inverse, design)
    left_out = errors / (1.0 - np.minimum(leverage, 0.9))[:, None]
    weighted_errors = weights[:, None] * left_out
    covariance = weighted_errors.T @ left_out / weights.sum()
    return coefficients[0], coefficients[1:], weights, covariance


def _distance_of(y: np.ndarray, distances: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Return a and c of d^2 = a + sum c_i marks_i^2, not negative."""
    roots = np.sqrt(weights) / (distances + 1e-3)
    design = np.column_stack([np.ones(len(y)), y**2])
    found, _ = nnls(design * roots[:, None], distances**2 * roots)
    return np.asarray(found)
