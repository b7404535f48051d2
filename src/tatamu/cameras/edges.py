"""Finds edges of cloth to a fraction of a pixel, from the photograph's colours along lines across these edges.

Straight edges are fitted by lines, from which a few of the points may lie far away.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d, median_filter

from tatamu.cameras import opencv

STEP = 0.5
"""Distance between samples of the colour along a line that crosses an edge of cloth [pixels]."""


@dataclass(frozen=True)
class Edges:
    """The edge of cloth near each of n given points of a curve."""

    points: np.ndarray
    """Points on the edge [pixels], shape (n, 2). If no edge was found near a given point, the given point itself."""
    found: np.ndarray
    """Whether an edge was found near each given point, shape (n,)."""
    width: np.ndarray
    """Width over which the colour changes at the edge near each given point [pixels], shape (n,)."""


def curve_normals(curve: np.ndarray) -> np.ndarray:
    """Return the unit normals of a closed curve, shape (n, 2).

    They point out of a curve that is counter-clockwise where y points up, and clockwise where y points down.
    """
    along = np.roll(curve, -1, axis=0) - np.roll(curve, 1, axis=0)
    across = np.column_stack([along[:, 1], -along[:, 0]])
    return np.asarray(across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-12))


def step_edges(pixels: np.ndarray, points: np.ndarray, normals: np.ndarray, reach: float) -> Edges:
    """Find the edge of cloth near n points [pixels], shape (n, 2), in order along the edge of an 8-bit RGB photograph.

    It is where the colour changes most along the normal through the point, up to the distance `reach` [pixels].
    """
    at = np.arange(-2.0 * reach, 2.0 * reach + 1e-9, STEP)
    places = points[:, None] + at[:, None] * normals[:, None]
    colours = sample(pixels, places)
    before, after = colours[:, at < -0.5 * reach].mean(axis=1), colours[:, at > 0.5 * reach].mean(axis=1)
    step = median_filter(after - before, size=(min(9, len(points)), 1), mode="nearest")
    height = np.linalg.norm(step, axis=1)
    found = height > 4.0  # 8-bit levels
    direction = step / np.maximum(height, 1e-9)[:, None]
    shade = np.einsum("nsc,nc->ns", colours, direction)
    slope = gaussian_filter1d(shade, 1.0 / STEP, axis=1, order=1)
    weight = np.maximum(slope, 0.0) * np.exp(-0.5 * (at / reach) ** 2)
    peak = weight.argmax(axis=1)
    near = np.abs(at[None] - at[peak][:, None]) <= 2.5
    mass = weight * near
    total = np.maximum(mass.sum(axis=1), 1e-9)
    offset = (mass * at).sum(axis=1) / total
    found &= np.abs(offset) < reach
    top = np.maximum(slope[np.arange(len(points)), peak], 1e-9)
    return Edges(np.where(found[:, None], points + offset[:, None] * normals, points), found, height / top * STEP)


def sample(pixels: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return the colours of an 8-bit picture, shape (n, s, 3), at places [pixels], shape (n, s, 2)."""
    cv2 = opencv()
    maps = places.astype(np.float32)
    return np.asarray(
        cv2.remap(pixels, maps[..., 0], maps[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE), dtype=float
    )


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
