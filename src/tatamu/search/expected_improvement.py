"""The logarithm of expected improvement (Jones et al. 1998), which itself is too small for a number far from the best.

Let b be the lowest objective so far, C the objective at a point, EI the expected improvement, and Phi and phi the
distribution function and the density of the standard normal variable. C is either a normal variable Y, or a known part
l plus a log-normal variable e^Y:

    C = Y,          Y ~ N(m, s^2):      EI = s (z Phi(z) + phi(z)),                      z = (b - m) / s
    C = l + e^Y,    Y ~ N(m, s^2):      EI = (b - l) Phi(d) - e^(m + s^2/2) Phi(d - s),  d = (log(b - l) - m) / s

The second is also the price of a put option (Black and Scholes 1973). It is for the objective C = l_x + alpha D of Eq.
(10), whose part l_x is known before a trial runs, while alpha D is positive.
"""

from __future__ import annotations

import numpy as np
from scipy.special import erfcx, log_ndtr, ndtr

LOG_SQRT_2PI = 0.5 * np.log(2.0 * np.pi)
TINY = 1e-300


def log_expected_improvement(best: float, mean: np.ndarray, deviation: np.ndarray) -> np.ndarray:
    """Return the logarithm of the expected improvement at p points with normal objectives, shape (p,)."""
    z = (best - mean) / deviation
    near = z > -1.0  # below, the two terms of the usual formula nearly cancel
    found = np.empty_like(z)
    density = np.exp(-0.5 * z[near] ** 2 - LOG_SQRT_2PI)
    found[near] = np.log(z[near] * ndtr(z[near]) + density + TINY)
    away = -z[~near]
    mills = np.sqrt(np.pi / 2.0) * erfcx(away / np.sqrt(2.0))  # Phi(-a) / phi(a)
    found[~near] = -0.5 * away**2 - LOG_SQRT_2PI + np.log(np.maximum(1.0 - away * mills, TINY))
    return found + np.log(deviation)


def log_expected_improvement_beyond(
    best: float, known: np.ndarray, mean: np.ndarray, deviation: np.ndarray
) -> np.ndarray:
    """Return the logarithm of the expected improvement at p points with a known and a log-normal part, shape (p,).

    Mean and deviation are those of the log-normal part's logarithm. The result is -inf if the known part is not below
    best.
    """
    room = best - known
    hopeful = room > 0.0
    log_room = np.log(np.where(hopeful, room, 1.0))
    d = (log_room - mean) / deviation
    gain = log_ndtr(d) + log_room
    cost = mean + 0.5 * deviation**2 + log_ndtr(d - deviation)
    difference = np.minimum(cost - gain, -1e-12)
    return np.where(hopeful, gain + np.log(-np.expm1(difference)), -np.inf)
