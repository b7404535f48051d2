"""An emulator of the simulator: a statistical model of the outcome of a fold, fitted to simulated draws.

    marks(x) = b + A x + tanh(t / T) B q + s e,      x = (w - mean) / deviation

The marks are the lengths that are measured after a fold. The model has these variables:

- w are the disturbances of one draw, and x are the same disturbances in standard deviations.
- q is the place at which each hand would lay the hem down if it were alone. q is linear in w.
- t is the time by which the left hand opens later than the right hand. It matters because the cloth follows the hand
  that opens last. T is a constant.
- e is the remaining error, and s is its factor. If the hands stretch or squeeze the hem between them by d, the factor
  grows: s^2 = 1 + (d / D)^2, with a constant D.

In a few draws a corner turned in, or a hand slipped off. The error e is a Student t variable, so that these draws have
little influence. The coefficients b, A and B and the scale matrix of e are fitted together by expectation maximisation.
The scale matrix is computed from leave-one-out residuals. The mean vertex distance d_v follows from the marks: d_v^2 =
a + sum_i c_i marks_i^2. Its coefficients a and c_i are not negative.

Sources: Lange, Little and Taylor 1989, J. American Statistical Association 84 (regression with Student t errors);
Kennedy and O'Hagan 2001, J. Royal Statistical Society B 63.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tatamu.base.errors import InputError
from tatamu.evaluation.disturbances import World
from tatamu.evaluation.robustness import Verdict
from tatamu.folding.marks import MARKS

RIDGE = 1.0
"""Penalty on each coefficient. It has the weight of this number of draws without an effect."""
TAILS = 3.0
"""Degrees of freedom of the errors. The number is small, because some draws end far from the emulated result."""
ROUNDS = 30
"""Number of rounds of reweighting. More rounds do not change the result."""
FEWEST = 40
"""Least number of draws to which an emulator is fitted."""
FOLLOWS = 0.02
"""The constant T: delay of the later hand from which this hand determines most of the cloth's place [s]."""
APART = 0.007
"""The constant D: a length by which the hands stretch or squeeze the hem between them [m].

If the hands stretch or squeeze the hem by D, the errors of the emulator have twice the variance. The emulator is a
statistical model that predicts the result of a fold.
"""
LATER = "hands.opening_delay"
"""Name of the disturbance t, the delay between the openings of the hands."""


@dataclass(frozen=True)
class Inputs:
    """The k disturbances of an emulator, and their effects on h hands."""

    names: tuple[str, ...]
    """Names of the disturbances."""
    centre: np.ndarray
    """Value of each disturbance at which x is 0, shape (k,). x is the disturbance in standard deviations."""
    scale: np.ndarray
    """Change of each disturbance that changes x by 1, shape (k,)."""
    laid: np.ndarray
    """Place at which each hand alone would lay the hem down, per unit of each disturbance [m], shape (k, h, 2).

    The two coordinates of a place are along the fold and across it."""

    def features(self, values: np.ndarray) -> np.ndarray:
        """Return x and tanh(t / T) q for disturbances, whose last axis has the length k.

        The last axis of the result has the length k + 2 h for h = 2 hands. It has the length k for a single hand.
        """
        x = (values - self.centre) / self.scale
        if not self._later:
            return np.asarray(x)
        laid = np.tensordot(values, self.laid, axes=1).reshape(*values.shape[:-1], -1) / APART
        return np.concatenate([x, np.tanh(values[..., self._later] / FOLLOWS) * laid], axis=-1)

    def widths(self, values: np.ndarray) -> np.ndarray:
        """Return s^2, the factor of the errors' variance, for each set of k disturbances.

        The disturbances are along the last axis of `values`.
        """
        if self.laid.shape[1] < 2:
            return np.ones(values.shape[:-1])
        apart = values @ (self.laid[:, 0, 1] - self.laid[:, 1, 1])
        return np.asarray(1.0 + (apart / APART) ** 2)

    @property
    def _later(self) -> list[int]:
        """Return the index of t, the delay, in a list.

        It is empty if a single hand folds, or if both hands open together.
        """
        return [self.names.index(LATER)] if LATER in self.names and self.laid.shape[1] > 1 else []


@dataclass(frozen=True)
class Emulator:
    """Marks of a fold as a function of disturbances: k disturbances, f features, m = len(MARKS) marks.

    The module's docstring gives the formula. Marks are the lengths that are measured after a fold.
    """

    inputs: Inputs
    base: np.ndarray
    """Marks b without disturbances [m], shape (m,)."""
    slopes: np.ndarray
    """Coefficients A and B of the features [m], shape (f, m)."""
    residual: np.ndarray
    """Scale matrix of the errors e [m^2], shape (m, m)."""
    distance: np.ndarray
    """Coefficients a [m^2] and c [-] of the mean vertex distance, shape (1 + m,)."""

    def marks(self, values: np.ndarray) -> np.ndarray:
        """Return the m marks [m] of each set of k disturbances. Both are along the last axis."""
        return np.asarray(self.base + self.inputs.features(values) @ self.slopes)

    def ends(self, values: np.ndarray, generator: np.random.Generator) -> np.ndarray:
        """Return the m marks with random errors [m], shape (n, m), of n sets of k disturbances, shape (n, k)."""
        spread, axes = np.linalg.eigh(self.residual)
        errors = generator.standard_normal((len(values), len(MARKS))) * np.sqrt(np.clip(spread, 0.0, None)) @ axes.T
        tails = TAILS / generator.chisquare(TAILS, len(values))
        return np.asarray(self.marks(values) + np.sqrt(self.inputs.widths(values) * tails)[:, None] * errors)

    def distances(self, marks: np.ndarray) -> np.ndarray:
        """Return the mean vertex distance [m] of each set of m marks. Marks are along the last axis."""
        return np.asarray(np.sqrt(self.distance[0] + marks**2 @ self.distance[1:]))

    def moved(self, by: Mapping[str, float]) -> np.ndarray:
        """Return changes of the k disturbances as a vector in the emulator's order, shape (k,).

        `by` contains the change of each disturbance under the disturbance's name. A disturbance that is missing in `by`
        does not change. Disturbances that the emulator does not have are left out.
        """
        return np.array([by.get(name, 0.0) for name in self.inputs.names])


def fit(inputs: Inputs, draws: Sequence[tuple[World, Verdict]], correction: np.ndarray) -> Emulator:
    """Fit an emulator to draws.

    Args:
        inputs: The disturbances.
        draws: Worlds (random draws), and the results of the fold in them. Results without marks are left out.
        correction: Marks of the nominal fold on the fine mesh minus its marks on the mesh of the draws [m], shape (m,).

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
    values = np.array([[world[name] for name in inputs.names] for world, _, _ in usable])
    y = np.array([[marks[name] for name in MARKS] for _, marks, _ in usable])
    base, slopes, residual, weights = _regression(inputs.features(values), y, inputs.widths(values))
    distance = _distance_of(y, np.array([d for *_, d in usable]), weights)
    return Emulator(inputs, base + correction, slopes, residual, distance)


def _regression(x: np.ndarray, y: np.ndarray, widths: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return b, the slopes, the scale matrix of leave-one-out residuals, and the weights of the draws.

    Weights are at most 1.
    """
    design = np.column_stack([np.ones(len(x)), x])
    penalty = np.diag([0.0, *[RIDGE] * x.shape[1]])
    tails = np.ones(len(x))
    for _ in range(ROUNDS):
        weights = tails / widths
        weighted = design * weights[:, None]
        inverse = np.linalg.inv(design.T @ weighted + penalty)
        coefficients = inverse @ weighted.T @ y
        leverage = weights * np.einsum("ij,jk,ik->i", design, inverse, design)
        errors = (y - design @ coefficients) / (1.0 - np.minimum(leverage, 0.9))[:, None]
        scaled = errors / np.sqrt(widths)[:, None]
        residual = (scaled * tails[:, None]).T @ scaled / len(x) + 1e-12 * np.eye(y.shape[1])
        squared = np.einsum("ij,jk,ik->i", scaled, np.linalg.inv(residual), scaled)
        tails = (TAILS + y.shape[1]) / (TAILS + squared)
    return coefficients[0], coefficients[1:], residual, np.minimum(tails, 1.0)


def _distance_of(y: np.ndarray, distances: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Return a and c of the mean vertex distance d^2 = a + sum c_i marks_i^2. None of them is negative."""
    from scipy.optimize import nnls

    roots = np.sqrt(weights) / (distances + 1e-3)
    design = np.column_stack([np.ones(len(y)), y**2])
    found, _ = nnls(design * roots[:, None], distances**2 * roots)
    return np.asarray(found)
