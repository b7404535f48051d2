"""Straight lines through points of an edge, a few of which may lie elsewhere."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

ROUNDS = 8
"""Rounds of reweighting."""
TUNING = 2.0
"""Number of deviations from the line beyond which points count little."""


@dataclass(frozen=True)
class Line:
    """A line in the plane."""

    origin: np.ndarray
    """The middle of its points, shape (2,)."""
    direction: np.ndarray
    """Unit vector along it, shape (2,)."""
    rms: float
    """Deviation of the points that count."""
    spread: float
    """Deviation of the points along the line."""
    count: int

    @classmethod
    def through(cls, points: np.ndarray) -> Line:
        """Fit a line to points (n, 2) by total least squares, reweighted by their distance (Cauchy)."""
        weight = np.ones(len(points))
        for _ in range(ROUNDS):
            origin = weight @ points / weight.sum()
            away = points - origin
            _, vectors = np.linalg.eigh((weight[:, None] * away).T @ away)
            off = away @ vectors[:, 0]
            scale = 1.4826 * float(np.median(np.abs(off))) + 1e-12
            weight = 1.0 / (1.0 + (off / (TUNING * scale)) ** 2)
        rms = float(np.sqrt((weight * off**2).sum() / weight.sum()))
        spread = float(np.sqrt((weight * (away @ vectors[:, 1]) ** 2).sum() / weight.sum()))
        return cls(origin, vectors[:, 1], rms, spread, len(points))

    @property
    def normal(self) -> np.ndarray:
        """Unit vector across it, shape (2,)."""
        return np.array([-self.direction[1], self.direction[0]])

    def off(self, points: np.ndarray) -> np.ndarray:
        """Return signed distances of points (n, 2), shape (n,)."""
        return np.asarray((points - self.origin) @ self.normal)

    def deviation_at(self, point: np.ndarray, independent: float) -> float:
        """Return the deviation of the line across itself at a point.

        Args:
            point: The point, shape (2,).
            independent: Number of points that are independent of one another.
        """
        away = float((point - self.origin) @ self.direction) / max(self.spread, 1e-9)
        return float(self.rms * np.sqrt((1.0 + away**2) / max(independent, 1.0)))

    def meets(self, other: Line) -> np.ndarray:
        """Return where two lines meet, shape (2,)."""
        matrix = np.array([self.normal, other.normal])
        return np.asarray(np.linalg.solve(matrix, [self.normal @ self.origin, other.normal @ other.origin]))
