"""Finds edges of cloth that lies on cloth: faint straight lines inside an outline.

The photo is resampled in a window along the expected edge, and the mean gradient of brightness across many lines in it
is computed. The edge is a line whose gradient is much larger than those of the others, because the rim of a layer has
another brightness and casts a shadow.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from scipy.ndimage import gaussian_filter1d

from tatamu.cameras.edges import Line, sample
from tatamu.cameras.photograph import Photograph
from tatamu.cameras.pose import Pose

SOFT = 0.0012
"""Standard deviation of the Gaussian filter that smooths brightness across an edge of cloth [m]."""
TURN = 0.14
"""Largest slope, relative to an expected edge, of the lines that are tried as this edge."""


@dataclass(frozen=True)
class Window:
    """The rectangular area in which an edge of a layer of cloth is expected, in the fold's frame."""

    corner: np.ndarray
    """Point at which the window and the expected edge start [m], shape (2,)."""
    along: np.ndarray
    """Unit vector along the expected edge, shape (2,)."""
    outward: np.ndarray
    """Unit vector across the expected edge, which points out of the layer of cloth, shape (2,)."""
    length: float
    """Length of the window along the expected edge [m]."""
    reach: float
    """Distance from the expected edge, to either side, within which the edge is searched [m]."""

    def coordinates(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return two coordinates of each of n points: along the window, and across the window."""
        away = points - self.corner
        return away @ self.along, away @ self.outward

    def line(self, middle: float, turn: float, rms: float) -> Line:
        """Return the line with a position [m] at half the window's length, a slope to the expected edge and an rms."""
        direction = self.along + turn * self.outward
        origin = self.corner + 0.5 * self.length * self.along + middle * self.outward
        return Line(origin, direction / np.linalg.norm(direction), rms, self.length / np.sqrt(12.0), 1)


def inner_edge(
    photograph: Photograph, frame: Pose, window: Window, height: float, cloth: shapely.Polygon
) -> Line | None:
    """Return the edge of a layer that lies on other cloth; None if no line is clearly an edge.

    `window`, and the area `cloth` inside the outline, are in the fold's frame, which has the pose `frame` on the board.
    """
    step = max(0.0005, 0.7 * photograph.resolution(frame.place(window.corner[None])))
    along = np.arange(0.008, window.length, step)
    across = np.arange(-window.reach, window.reach, step)
    places = window.corner + along[:, None, None] * window.along + across[None, :, None] * window.outward
    flat = places.reshape(-1, 2)
    pixels = photograph.in_pixels(frame.place(flat), height).reshape(*places.shape)
    bright = sample(photograph.pixels, pixels).mean(axis=2)
    # the strip along the outline shows its own rim
    inside = shapely.contains_xy(cloth.buffer(-0.0045), flat[:, 0], flat[:, 1]).reshape(bright.shape)
    slope = gaussian_filter1d(bright, SOFT / step, axis=1, order=1)
    slope -= np.median(slope[inside]) if inside.any() else 0.0
    centre = np.interp(along, along[[0, -1]], [-0.5, 0.5])
    turns = np.linspace(-TURN, TURN, 29)
    scores = np.full((len(turns), len(across)), np.nan)
    rows = np.arange(len(along))[:, None]
    for number, turn in enumerate(turns):
        shift = np.round(turn * centre * window.length / step).astype(int)[:, None] + np.arange(len(across))
        there = (shift >= 0) & (shift < len(across))
        column = np.clip(shift, 0, len(across) - 1)
        usable = inside[rows, column] & there
        enough = usable.mean(axis=0) > 0.7
        mean = (slope[rows, column] * usable).sum(axis=0) / np.maximum(usable.sum(axis=0), 1)
        scores[number, enough] = mean[enough]
    known = np.isfinite(scores)
    if known.sum() < 50:
        return None
    noise = 1.4826 * float(np.median(np.abs(scores[known]))) + 1e-9
    strength = np.where(known, np.abs(scores), 0.0)
    row, best = np.unravel_index(int(strength.argmax()), strength.shape)
    if strength[row, best] < max(6.0 * noise, 0.25):
        return None
    soft = np.hypot(SOFT, 0.7 * photograph.resolution(frame.place(window.corner[None])))
    middle = _rim(across, np.where(known[row], scores[row], 0.0), int(best), float(soft))
    return window.line(middle, float(turns[row]), max(step, 0.3 * SOFT))


def _rim(across: np.ndarray, slopes: np.ndarray, best: int, soft: float) -> float:
    """Return the coordinate at which a layer of cloth ends, from the gradients of brightness across its edge.

    The rim may be a dark or bright band of width w, blurred by `soft`, with a strong gradient at each end: at the
    distance sqrt(soft^2 + w^2/4) from its middle. The stronger one has the index `best`.
    """
    reach = round(0.006 / float(across[1] - across[0]))
    strength = np.abs(slopes)
    peaks = np.flatnonzero((strength[1:-1] >= strength[:-2]) & (strength[1:-1] >= strength[2:])) + 1
    opposite = slopes[peaks] * slopes[best] < 0
    other = peaks[opposite & (np.abs(peaks - best) <= reach) & (strength[peaks] > 0.35 * strength[best])]
    if not len(other):
        return float(across[best])
    ends = across[[best, other[strength[other].argmax()]]]
    half = 0.5 * float(np.ptp(ends))
    return float(ends.mean()) - float(np.sqrt(max(half**2 - soft**2, 0.0)))


def outer_edge(points: np.ndarray, window: Window) -> Line | None:
    """Fit a line to the part of an outline, shape (n, 2) [m], in a window; None if no part runs along the window."""
    along, across = window.coordinates(points)
    near = (along > 0.01) & (along < window.length) & (np.abs(across) < window.reach)
    if near.sum() < 8 or np.ptp(along[near]) < 0.6 * window.length:
        return None
    line = Line.through(points[near])
    turn = abs(float(line.direction @ window.outward))
    return line if turn < 1.5 * TURN and line.rms < 0.004 else None
