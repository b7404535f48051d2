"""Computes the shape of a cantilever: an inextensible strip, clamped at one end, that bends under its own weight.

At the arc length s, the strip has the slope theta, measured downwards from the horizontal. The equations are:

    B theta'' = -w (L - s) cos(theta),  theta(0) = 0,  theta'(L) = 0,  x' = cos(theta),  y' = sin(theta)
    Gamma = w L^3 / B = (L / l_b)^3

B is the bending rigidity, w = rho g is the weight per area, and L is the length of the strip. The horizontal distance
from the clamp is x (the reach), and the vertical distance is y (the drop). The bending length is l_b (Peirce 1930).

The dimensionless weight Gamma is raised step by step, and each solution is the initial guess for the next. Without
these steps, a solver finds wrong solutions if Gamma is above about 100.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.integrate import solve_bvp

from tatamu.base.errors import TatamuError

SMALLEST = 0.01
STEPS_PER_DECADE = 30


def _solve(gamma: float, s: np.ndarray, guess: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    def slope(s: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.vstack([y[1], -gamma * (1 - s) * np.cos(y[0]), np.cos(y[0]), np.sin(y[0])])

    def ends(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.array([a[0], b[1], a[2], a[3]])

    found = solve_bvp(slope, ends, s, guess, tol=1e-8, max_nodes=20000)
    if not found.success:
        raise TatamuError(f"heavy elastica, Gamma {gamma:g}: {found.message}")
    return found.x, found.y


@lru_cache(maxsize=256)
def _continued(gamma: float) -> tuple[np.ndarray, np.ndarray]:
    """Solve a cantilever's equations for a dimensionless weight Gamma, from the solution for a smaller Gamma.

    The first result is an array of arc lengths from 0 to 1. The second result has four values at each of these arc
    lengths: the slope theta, its derivative by arc length, the reach x and the drop y. All lengths are in units of the
    strip's length L.
    """
    if gamma <= SMALLEST:
        s = np.linspace(0, 1, 201)
        return _solve(gamma, s, np.vstack([0 * s, 0 * s, s, 0 * s]))
    rung = np.ceil(np.log10(gamma / SMALLEST) * STEPS_PER_DECADE - 1e-9) - 1
    return _solve(gamma, *_continued(float(SMALLEST * 10 ** (rung / STEPS_PER_DECADE))))


def cantilever(gamma: float, count: int = 201) -> np.ndarray:
    """Return the shape of a cantilever at equal steps of arc length, shape (count, 2).

    Each row has the reach x / L and the drop y / L in units of the length L. The argument is the dimensionless weight
    Gamma = w L^3 / B, with the weight per area w and the bending rigidity B.
    """
    s, y = _continued(float(gamma))
    arc = np.linspace(0, 1, count)
    return np.column_stack([np.interp(arc, s, y[2]), np.interp(arc, s, y[3])])


def tip(gamma: float) -> tuple[float, float, float]:
    """Return the reach x / L and the drop y / L of a cantilever's tip, and its slope below the horizontal [rad].

    L is the length of the cantilever, and `gamma` is its dimensionless weight.
    """
    _, y = _continued(float(gamma))
    return float(y[2, -1]), float(y[3, -1]), float(y[0, -1])


def slowest_frequency(gamma: float, length: float, gravity: float) -> float:
    """Return an estimate of the lowest angular frequency of a hanging cantilever [rad/s].

    The estimate is the larger of two frequencies. A stiff strip has the frequency of a clamped beam,
    3.52 sqrt(B / (rho L^4)), with the mass per area rho. A limp strip has the frequency of a hanging chain,
    1.2 sqrt(g / L).

    Args:
        gamma: Dimensionless weight Gamma = w L^3 / B, with the weight per area w = rho g and the bending rigidity B.
        length: Length of the strip L [m].
        gravity: Acceleration of gravity g [m/s^2].
    """
    return float(max(3.52 / np.sqrt(gamma), 1.2) * np.sqrt(gravity / length))


def chord(gamma: float) -> float:
    """Return the angle between the horizontal and the line from the clamp to the tip of a cantilever [rad].

    The argument `gamma` is the dimensionless weight of the cantilever.
    """
    reach, drop, _ = tip(gamma)
    return float(np.arctan2(drop, reach))
