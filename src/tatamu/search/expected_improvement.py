"""The logarithm of expected improvement (Jones et al. 1998).

Far from the best point, expected improvement itself is smaller than the smallest floating-point number.

Let b be the lowest objective so far. The objective at a point is either a normal variable, or a known part plus a
log-normal variable:

    C = Y,          Y ~ N(m, s^2):      EI = s (z Phi(z) + phi(z)),                      z = (b - m) / s
    C = l + e^Y,    Y ~ N(m, s^2):      EI = (b - l) Phi(d) - e^(m + s^2/2) Phi(d - s),  d = (log(b - l) - m) / s

The second formula is the price of a put option (Black and Scholes 1973). It is used for Eq. (10), C = l_x + alpha D:
l_x is known before a trial runs, and D is positive.
"""

from __future__ import annotations

import numpy as np
from scipy.special import erfcx, log_ndtr, ndtr

LOG_SQRT_2PI = 0.5 * np.log(2.0 * np.pi)
FAR = -1.0
"""z below which the two terms of EI nearly cancel, so that another form is used."""
TINY = 1e-300


def log_expected_improvement(best: float, mean: np.ndarray, deviation: np.ndarray) -> np.ndarray:
    """Log EI of normal objectives, all of shape (p,)."""
    z = (best - mean) / deviation
    near = z > FAR
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
    """Return log EI of a known part plus a log-normal part; minus infinity if the known part is not below `best`.

    Args:
        best: Lowest objective so far.
        known: The known part, shape (p,).
        mean: Mean of the logarithm of the other part, shape (p,).
        deviation: Standard deviation of that logarithm, shape (p,).
    """
    room = best - known
    hopeful = room > 0.0
    log_room = np.log(np.where(hopeful, room, 1.0))
    d = (log_room - mean) / deviation
    gain = log_ndtr(d) + log_room
    cost = mean + 0.5 * deviation**2 + log_ndtr(d - deviation)
    difference = np.minimum(cost - gain, -1e-12)
    return np.where(hopeful, gain + np.log(-np.expm1(difference)), -np.inf)
