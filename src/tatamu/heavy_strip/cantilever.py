"""Heavy elastica: the cantilever of an inextensible strip under its own weight.

    B theta'' = -w (L - s) cos(theta),  theta(0) = 0,  theta'(L) = 0,  x' = cos(theta),  y' = sin(theta)
    Gamma = w L^3 / B = (L / l_b)^3

theta is the slope below the horizontal, w = rho g the weight per area, B the bending rigidity, y the drop. Gamma is
raised step by step, and each solution is the initial guess of the next, because shooting alone finds wrong branches
above Gamma of about 100. The bending length is Peirce's (1930).
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.integrate import solve_bvp

from tatamu.errors import TatamuError

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
    """Return arc in 0..1 and (theta, theta', x, y) / L on it, by continuation from the next smaller power."""
    if gamma <= SMALLEST:
        s = np.linspace(0, 1, 201)
        return _solve(gamma, s, np.vstack([0 * s, 0 * s, s, 0 * s]))
    rung = np.ceil(np.log10(gamma / SMALLEST) * STEPS_PER_DECADE - 1e-9) - 1
    return _solve(gamma, *_continued(float(SMALLEST * 10 ** (rung / STEPS_PER_DECADE))))


def cantilever(gamma: float, count: int = 201) -> np.ndarray:
    """Return reach x / L and drop y / L of the cantilever at equal steps of arc length, shape (count, 2)."""
    s, y = _continued(float(gamma))
    arc = np.linspace(0, 1, count)
    return np.column_stack([np.interp(arc, s, y[2]), np.interp(arc, s, y[3])])


def tip(gamma: float) -> tuple[float, float, float]:
    """Return reach x / L and drop y / L of the tip, and its slope below the horizontal [rad]."""
    _, y = _continued(float(gamma))
    return float(y[2, -1]), float(y[3, -1]), float(y[0, -1])


def slowest_frequency(gamma: float, length: float, gravity: float) -> float:
    """Return an estimate of the lowest angular frequency of a hanging cantilever [rad/s].

    For a beam it is 3.52 sqrt(B / (rho L^4)), the lowest frequency of a clamped beam; for a limp strip that of a
    hanging chain, 1.2 sqrt(g / L).

    Args:
        gamma: w L^3 / B.
        length: L [m].
        gravity: g [m/s^2].
    """
    return float(max(3.52 / np.sqrt(gamma), 1.2) * np.sqrt(gravity / length))


def chord(gamma: float) -> float:
    """Return the angle below the horizontal of the line from clamp to tip [rad]."""
    reach, drop, _ = tip(gamma)
    return float(np.arctan2(drop, reach))
