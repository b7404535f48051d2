"""Least squares in which rows that fit badly count little."""

from __future__ import annotations

import numpy as np


def robust_fit(terms: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Return the factors x with which terms @ x is near `wanted`, shape (k, d), by reweighted least squares.

    The rows, shape (n, k) and (n, d), have Cauchy's weights for twice the median distance.
    """
    weight = np.ones(len(terms))
    for _ in range(5):
        root = np.sqrt(weight)[:, None]
        fit = np.linalg.lstsq(terms * root, wanted * root, rcond=None)[0]
        off = np.linalg.norm(wanted - terms @ fit, axis=1)
        weight = 1.0 / (1.0 + (off / (2.0 * np.median(off) + 1e-6)) ** 2)
    return np.asarray(fit)
