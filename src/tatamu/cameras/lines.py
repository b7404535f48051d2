"""Fits straight lines to the points of an edge. A few of the points may lie far from the line."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Line:
    """A line in the plane that was fitted to points."""

    origin: np.ndarray
    """Weighted mean of the points to which the line was fitted, shape (2,)."""
    direction: np.ndarray
    """Unit vector along the line, shape (2,)."""
    rms: float
    """Standard deviation of the distances of the fitted points from the line."""
    spread: float
    """Standard deviation of the positions of the fitted points along the line."""
    count: int

    @classmethod
    def through(cls, points: np.ndarray) -> Line:
        """Fit a line to points, shape (n, 2), by total least squares with Cauchy's weights."""
        weight = np.ones(len(points))
        for _ in range(8):
            origin = weight @ points / weight.sum()
            away = points - origin
            _, vectors = np.linalg.eigh((weight[:, None] * away).T @ away)
            off = away @ vectors[:, 0]
            scale = 1.4826 * float(np.median(np.abs(off))) + 1e-12
            weight = 1.0 / (1.0 + (off / (2.0 * scale)) ** 2)
        rms = float(np.sqrt((weight * off**2).sum() / weight.sum()))
        spread = float(np.sqrt((weight * (away @ vectors[:, 1]) ** 2).sum() / weight.sum()))
        return cls(origin, vectors[:, 1], rms, spread, len(points))

    @property
    def normal(self) -> np.ndarray:
        """Unit vector across the line, shape (2,)."""
        return np.array([-self.direction[1], self.direction[0]])

    def off(self, points: np.ndarray) -> np.ndarray:
        """Return the signed distances of n points from the line, shape (n,); positive on the side of `normal`."""
        return np.asarray((points - self.origin) @ self.normal)

    def deviation_at(self, point: np.ndarray, independent: float) -> float:
        """Return the standard deviation of the line across itself at a point, shape (2,), from independent errors."""
        away = float((point - self.origin) @ self.direction) / max(self.spread, 1e-9)
        return float(self.rms * np.sqrt((1.0 + away**2) / max(independent, 1.0)))

    def meets(self, other: Line) -> np.ndarray:
        """Return the point at which this line and another line meet, shape (2,)."""
        matrix = np.array([self.normal, other.normal])
        return np.asarray(np.linalg.solve(matrix, [self.normal @ self.origin, other.normal @ other.origin]))
