"""Paths of a hand relative to its grasp, in the vertical plane of the fold, and how fast they are followed."""

from __future__ import annotations

from math import comb

import numpy as np

SAMPLES = 400


def bezier(control_points: np.ndarray, t: np.ndarray) -> np.ndarray:
    """T(t) = sum_k B_k^N(t) P_k, Eq. (1): shape (k, d) and (s,) to (s, d)."""
    n = len(control_points) - 1
    basis = np.stack([comb(n, k) * t**k * (1 - t) ** (n - k) for k in range(n + 1)], axis=-1)
    return basis @ control_points


def sampled_bezier(control_points: np.ndarray) -> np.ndarray:
    """A Bezier curve as a fine polyline, shape (SAMPLES + 1, d)."""
    return bezier(control_points, np.linspace(0.0, 1.0, SAMPLES + 1))


def length(path: np.ndarray) -> float:
    """Length of a polyline [m]: l_x of Eq. (10)."""
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def minimum_jerk(fraction: np.ndarray) -> np.ndarray:
    """Way over time of the smoothest motion from rest to rest, 10 s^3 - 15 s^4 + 6 s^5 (Flash and Hogan 1985)."""
    s = np.clip(fraction, 0.0, 1.0)
    return s**3 * (10.0 - 15.0 * s + 6.0 * s**2)


TOP_SPEED_FACTOR = 1.875
"""Top speed of the minimum-jerk motion over its mean speed."""


def duration(way: float, top_speed: float) -> float:
    """Time that a minimum-jerk motion of that way needs at that top speed [s]."""
    return TOP_SPEED_FACTOR * way / top_speed


def along(path: np.ndarray, fraction: np.ndarray) -> np.ndarray:
    """Points at fractions of the path's length, shape (s,) to (s, d)."""
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    return np.column_stack([np.interp(fraction * way[-1], way, column) for column in path.T])
