"""The logarithm of expected improvement (Jones et al. 1998).

Far from the best point, expected improvement is below the smallest floating-point number. Therefore the logarithm is
used.

Let b be the lowest objective so far, and C the objective at a point. EI is the expected improvement. Phi is the
distribution function of the standard normal variable, and phi is its density. C is either a normal variable Y, or a
known part l plus a log-normal variable e^Y:

    C = Y,          Y ~ N(m, s^2):      EI = s (z Phi(z) + phi(z)),                      z = (b - m) / s
    C = l + e^Y,    Y ~ N(m, s^2):      EI = (b - l) Phi(d) - e^(m + s^2/2) Phi(d - s),  d = (log(b - l) - m) / s

The second formula is also known as the price of a put option (Black and Scholes 1973). It is used for the objective of
a fold:

    C = l_x + alpha D

This is Eq. (10) of the paper whose method tatamu uses (ICMA 2019). Here l_x is the trajectory length of the hands, D
the distance of the folded shape from its target, and alpha the weight of D. The length l_x is known before a trial
runs, so the known part l is l_x. The product alpha D is positive, so it is modelled as the log-normal part.
"""

from __future__ import annotations

import numpy as np
from scipy.special import erfcx, log_ndtr, ndtr

LOG_SQRT_2PI = 0.5 * np.log(2.0 * np.pi)
FAR = -1.0
"""Smallest z for the usual formula of expected improvement.

If z is smaller, its two terms nearly cancel and rounding errors would be large. Then another formula is used."""
TINY = 1e-300


def log_expected_improvement(best: float, mean: np.ndarray, deviation: np.ndarray) -> np.ndarray:
    """Return the logarithm of the expected improvement at p points whose objectives are normal variables.

    All arrays have the shape (p,).
    """
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
    """Return the logarithm of the expected improvement of objectives with a known part and a log-normal part.

    If the known part is not below `best`, no improvement is possible, and the result is minus infinity.

    Args:
        best: Lowest objective so far.
        known: Known part of the objective at each of p points, shape (p,).
        mean: Mean of the logarithm of the log-normal part, shape (p,).
        deviation: Standard deviation of this logarithm, shape (p,).
    """
    room = best - known
    hopeful = room > 0.0
    log_room = np.log(np.where(hopeful, room, 1.0))
    d = (log_room - mean) / deviation
    gain = log_ndtr(d) + log_room
    cost = mean + 0.5 * deviation**2 + log_ndtr(d - deviation)
    difference = np.minimum(cost - gain, -1e-12)
    return np.where(hopeful, gain + np.log(-np.expm1(difference)), -np.inf)
