"""The cantilever: an inextensible strip, clamped at one end, that bends under its own weight.

The slope theta is measured downwards. From the clamp, x is the horizontal reach and y the vertical drop:

    B theta'' = -w (L - s) cos(theta),  theta(0) = 0,  theta'(L) = 0,  x' = cos(theta),  y' = sin(theta)
    Gamma = w L^3 / B = (L / l_b)^3

Gamma is raised step by step, because a solver finds wrong solutions above about 100 without a good initial guess.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.integrate import solve_bvp

from tatamu.base.errors import TatamuError


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
    """Return arc lengths and theta, theta', x and y at each of them in units of L, from a smaller Gamma."""
    least, steps_per_decade = 0.01, 30
    if gamma <= least:
        s = np.linspace(0, 1, 201)
        return _solve(gamma, s, np.vstack([0 * s, 0 * s, s, 0 * s]))
    rung = np.ceil(np.log10(gamma / least) * steps_per_decade - 1e-9) - 1
    return _solve(gamma, *_continued(float(least * 10 ** (rung / steps_per_decade))))


def cantilever(gamma: float, count: int = 201) -> np.ndarray:
    """Return the reach x / L and the drop y / L at equal steps of arc length, shape (count, 2)."""
    s, y = _continued(float(gamma))
    arc = np.linspace(0, 1, count)
    return np.column_stack([np.interp(arc, s, y[2]), np.interp(arc, s, y[3])])


def tip(gamma: float) -> tuple[float, float, float]:
    """Return the reach x / L and the drop y / L of the tip, and its slope below the horizontal [rad]."""
    _, y = _continued(float(gamma))
    return float(y[2, -1]), float(y[3, -1]), float(y[0, -1])


def slowest_frequency(gamma: float, length: float, gravity: float) -> float:
    """Estimate the lowest angular frequency of a hanging cantilever [rad/s].

    It is the larger one of a clamped beam, 3.52 sqrt(B / (rho L^4)), and of a hanging chain, 1.2 sqrt(g / L).
    """
    return float(max(3.52 / np.sqrt(gamma), 1.2) * np.sqrt(gravity / length))


def chord(gamma: float) -> float:
    """Return the angle between the horizontal and the line from the clamp to the tip [rad]."""
    reach, drop, _ = tip(gamma)
    return float(np.arctan2(drop, reach))
