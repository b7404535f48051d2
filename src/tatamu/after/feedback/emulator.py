"""A linear emulator of a fold: where the cloth ends for given disturbances, fitted to simulated scenarios.

    marks = b + A (w - mean) + e

A few scenarios end unlike all others, because a corner turns in or a hand slips off. The errors e are fitted as Student
t variables, so that these scenarios have little weight (Lange, Little and Taylor 1989, J. American Statistical
Association 84). The mean vertex distance d follows from the marks: d^2 = a + sum_i c_i marks_i^2. So does the judged
distance, which decides whether a fold succeeds, with coefficients of its own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tatamu.base.errors import InputError
from tatamu.evaluation.disturbances import Scenario, Split
from tatamu.evaluation.outcome import Outcome
from tatamu.folding.score import MARKS, judged_distance

TAILS = 3.0
"""Degrees of freedom of the errors."""
ROUNDS = 30
"""Rounds of reweighting. More rounds do not change the result."""
MIN_SCENARIOS = 40
"""Minimum number of simulated scenarios."""


@dataclass(frozen=True)
class Emulator:
    """The m marks of a fold as a linear function of k disturbances."""

    names: tuple[str, ...]
    """Names of the disturbances."""
    centre: np.ndarray
    """Means of the disturbances, shape (k,)."""
    base: np.ndarray
    """Marks if every disturbance has its mean [m], shape (m,)."""
    slopes: np.ndarray
    """Change of each mark per unit of each disturbance, shape (m, k)."""
    residual: np.ndarray
    """Covariance of the errors [m^2], shape (m, m)."""
    distance: np.ndarray
    """Coefficients a [m^2] and c [-] of the mean vertex distance, shape (1 + m,)."""
    judged: np.ndarray
    """The same of the judged distance."""

    def marks(self, values: np.ndarray) -> np.ndarray:
        """Return the marks [m] for disturbances. Both are along the last axis."""
        return np.asarray(self.base + (values - self.centre) @ self.slopes.T)

    def moved(self, by: Mapping[str, float]) -> np.ndarray:
        """Return changes of the disturbances, given by their names, as a vector, shape (k,)."""
        return np.array([by.get(name, 0.0) for name in self.names])

    def distances(self, marks: np.ndarray) -> np.ndarray:
        """Return the mean vertex distance [m] for marks along the last axis."""
        return np.asarray(np.sqrt(self.distance[0] + marks**2 @ self.distance[1:]))

    def judged_distances(self, marks: np.ndarray) -> np.ndarray:
        """Return the judged distance [m] for marks along the last axis."""
        return np.asarray(np.sqrt(self.judged[0] + marks**2 @ self.judged[1:]))


def fit(parts: Split, scenarios: Sequence[tuple[Scenario, Outcome]]) -> Emulator:
    """Fit an emulator to simulated scenarios.

    Args:
        parts: The disturbances.
        scenarios: Scenarios with their outcomes. Outcomes without marks are left out.

    Raises:
        InputError: If too few scenarios have marks.
    """
    known = [(scenario, v.marks, (v.mean_vertex_distance, judged_distance(v))) for scenario, v in scenarios]
    usable = [(scenario, marks, d) for scenario, marks, d in known if marks is not None and None not in d]
    if len(usable) < MIN_SCENARIOS:
        raise InputError(
            f"feedback: only {len(usable)} of {len(scenarios)} scenarios could be simulated to the end, but at least "
            f"{MIN_SCENARIOS} are needed; learn a fold that succeeds more often"
        )
    scale = np.where(parts.deviations > 0.0, parts.deviations, 1.0)
    x = (np.array([[scenario[name] for name in parts.names] for scenario, *_ in usable]) - parts.mean) / scale
    y = np.array([[marks[name] for name in MARKS] for _, marks, _ in usable])
    base, slopes, residual, weights = _regression(x, y)
    distance, judged = (_distance_of(y, each, weights) for each in np.array([d for *_, d in usable]).T)
    return Emulator(parts.names, parts.mean, base, slopes.T / scale, residual, distance, judged)


def _regression(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return b, A', the scale matrix of leave-one-out residuals, and the scenarios' weights of at most 1."""
    design = np.column_stack([np.ones(len(x)), x])
    penalty = np.diag([0.0, *[1.0] * x.shape[1]])  # as one scenario without an effect
    weights = np.ones(len(x))
    for _ in range(ROUNDS):
        weighted = design * weights[:, None]
        inverse = np.linalg.inv(design.T @ weighted + penalty)
        coefficients = inverse @ weighted.T @ y
        leverage = weights * np.einsum("ij,jk,ik->i", design, inverse, design)
        errors = (y - design @ coefficients) / (1.0 - np.minimum(leverage, 0.9))[:, None]
        residual = (errors * weights[:, None]).T @ errors / len(x) + 1e-12 * np.eye(y.shape[1])
        squared = np.einsum("ij,jk,ik->i", errors, np.linalg.inv(residual), errors)
        weights = (TAILS + y.shape[1]) / (TAILS + squared)
    return coefficients[0], coefficients[1:], residual, np.minimum(weights, 1.0)


def _distance_of(y: np.ndarray, distances: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Return a and c of distances d^2 = a + sum c_i marks_i^2. None of them is negative."""
    from scipy.optimize import nnls

    roots = np.sqrt(weights) / (distances + 1e-3)
    design = np.column_stack([np.ones(len(y)), y**2])
    found, _ = nnls(design * roots[:, None], distances**2 * roots)
    return np.asarray(found)
