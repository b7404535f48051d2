"""Curves that hands follow: the cubic Bezier curve, polylines, and the timing of a motion from rest to rest."""

from __future__ import annotations

from dataclasses import dataclass
from math import comb

import numpy as np

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)
SAMPLES = 400
"""Number of segments of the polyline that approximates a Bezier curve."""
FINE = 4000
"""Number of segments of the polyline with which lengths and points of a `Bezier` are found."""
TOP_SPEED_FACTOR = 1.875


def bezier(control_points: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Return s points of a Bezier curve with d coordinates, shape (s, d).

    The points are T(t) = sum_k B_k^N(t) P_k, Eq. (1), with the Bernstein polynomials B_k^N, the N + 1 control points
    P_k, shape (N + 1, d), and the parameters t, shape (s,).
    """
    n = len(control_points) - 1
    basis = np.stack([comb(n, k) * t**k * (1 - t) ** (n - k) for k in range(n + 1)], axis=-1)
    return basis @ control_points


def sampled_bezier(control_points: np.ndarray) -> np.ndarray:
    """Return a Bezier curve as a polyline, shape (SAMPLES + 1, d)."""
    return bezier(control_points, np.linspace(0.0, 1.0, SAMPLES + 1))


def bezier_lengths(control_points: np.ndarray) -> np.ndarray:
    """Return the lengths of p cubic Bezier curves [m], shape (p,), by Gauss-Legendre quadrature.

    Their control points have the shape (p, 4, d).
    """
    u = 0.5 * (_NODES + 1.0)
    basis = 3.0 * np.stack([(1.0 - u) ** 2, 2.0 * (1.0 - u) * u, u**2])  # (3, s): T'(u) per difference of the P_k
    velocity = np.einsum("ks,pkd->psd", basis, np.diff(control_points, axis=1))
    return np.asarray(np.linalg.norm(velocity, axis=2) @ (0.5 * _WEIGHTS))


def arc_lengths(polyline: np.ndarray) -> np.ndarray:
    """Return the length of a polyline of s points, shape (s, d), from its start to each point [m], shape (s,)."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(polyline, axis=0), axis=1))])


def length(polyline: np.ndarray) -> float:
    """Return the length of a polyline of s points, shape (s, d) [m]. For a hand's path, it is l_x of Eq. (10)."""
    return float(np.linalg.norm(np.diff(polyline, axis=0), axis=1).sum())


def along(polyline: np.ndarray, fraction: np.ndarray) -> np.ndarray:
    """Return the points of a polyline at s fractions of its length, shape (s, d)."""
    arc = arc_lengths(polyline)
    return np.column_stack([np.interp(fraction * arc[-1], arc, column) for column in polyline.T])


def minimum_jerk(fraction: np.ndarray) -> np.ndarray:
    """Return the fraction of the path that is covered at a fraction s of the time, in a minimum-jerk motion.

    It is 10 s^3 - 15 s^4 + 6 s^5 (Flash and Hogan 1985), the smoothest motion from rest to rest.
    """
    s = np.clip(fraction, 0.0, 1.0)
    return s**3 * (10.0 - 15.0 * s + 6.0 * s**2)


def minimum_jerk_duration(path_length: float, top_speed: float) -> float:
    """Return the duration of a minimum-jerk motion [s] from its length [m] and its top speed [m/s]."""
    return TOP_SPEED_FACTOR * path_length / top_speed


@dataclass(frozen=True)
class Bezier:
    """A cubic Bezier curve in space (paper, Fig. 3)."""

    control: np.ndarray
    """Control points P0 to P3 [m], shape (4, 3)."""

    def at(self, u: np.ndarray) -> np.ndarray:
        """Return the points at n parameters u from 0 to 1, shape (n, 3)."""
        return bezier(self.control, np.asarray(u, dtype=float))

    def arc_lengths(self) -> tuple[np.ndarray, np.ndarray]:
        """Return equally spaced parameters, and the length of the curve up to each of them [m], shapes (FINE + 1,)."""
        u = np.linspace(0, 1, FINE + 1)
        return u, arc_lengths(self.at(u))

    def nearest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the parameters of the curve's points nearest to n points, and their distances [m], shapes (n,)."""
        u = np.linspace(0, 1, FINE // 2 + 1)
        curve = self.at(u)
        best = np.array([np.argmin(((curve - point) ** 2).sum(axis=1)) for point in points])
        low = u[np.maximum(best - 1, 0)]
        high = u[np.minimum(best + 1, len(u) - 1)]
        golden = 0.618034
        for _ in range(40):  # golden section for all points together
            a = high - (high - low) * golden
            b = low + (high - low) * golden
            nearer = self._squares(a, points) < self._squares(b, points)
            low, high = np.where(nearer, low, a), np.where(nearer, b, high)
        u = (low + high) / 2
        return u, np.sqrt(self._squares(u, points))

    def _squares(self, u: np.ndarray, points: np.ndarray) -> np.ndarray:
        return ((self.at(u) - points) ** 2).sum(axis=1)
