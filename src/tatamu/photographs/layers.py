"""Edges of cloth that lies on cloth: faint straight lines inside an outline.

The table about an expected edge is resampled as a patch with the edge along one side. For every line through the patch,
the mean slope of brightness across it is compared with that of all other lines. An edge of a layer stands out, because
its rim has another brightness and casts a shadow.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from scipy.ndimage import gaussian_filter1d

from tatamu.photographs.edges import sample
from tatamu.photographs.lines import Line
from tatamu.photographs.photograph import Photograph
from tatamu.photographs.pose import Pose

FINEST = 0.0005
"""Resolution of a patch [m]."""
SOFT = 0.0012
"""Deviation of the smoothing across an edge [m]."""
TURN = 0.14
"""Largest rise of a line, as a fraction of its length."""
TURNS = 29
"""Number of directions that are tried."""
CLEAR = 6.0
"""An edge stands out of all other lines by this many deviations."""
LEAST = 0.25
"""Least slope of brightness of an edge [8-bit levels per resolution]."""
RIM = 0.0045
"""Distance from the outline within which places are ignored [m]."""
WIDE = 0.006
"""An edge's two slopes, of a dark or bright line, lie within this distance [m]."""
SEEN = 0.7
"""Deviation by which a camera blurs [pixels]."""
SECOND = 0.35
"""Least strength of the weaker slope, as a fraction of the stronger one."""


@dataclass(frozen=True)
class Window:
    """The area in which an edge is expected, in the fold's frame."""

    corner: np.ndarray
    """Starting corner of the window [m], shape (2,)."""
    along: np.ndarray
    """Unit vector along it, shape (2,)."""
    outward: np.ndarray
    """Unit vector across it, out of the layer, shape (2,)."""
    length: float
    """[m]"""
    reach: float
    """Distance to either side within which it is searched [m]."""

    def coordinates(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return places along and across the window of points (n, 2)."""
        away = points - self.corner
        return away @ self.along, away @ self.outward

    def line(self, middle: float, turn: float, rms: float) -> Line:
        """Return the line at `middle` across the window that rises by `turn` per length."""
        direction = self.along + turn * self.outward
        origin = self.corner + 0.5 * self.length * self.along + middle * self.outward
        return Line(origin, direction / np.linalg.norm(direction), rms, self.length / np.sqrt(12.0), 1)


def inner_edge(
    photograph: Photograph, frame: Pose, window: Window, height: float, cloth: shapely.Polygon
) -> Line | None:
    """Return the edge of a layer on other cloth; None if none is clear.

    Args:
        photograph: The photograph.
        frame: Pose of the fold's frame on the board.
        window: Part of the picture in which the edge is expected.
        height: Height of the edge [m].
        cloth: Area inside the outline, in the fold's frame.
    """
    step = max(FINEST, 0.7 * photograph.resolution(frame.place(window.corner[None])))
    along = np.arange(0.008, window.length, step)
    across = np.arange(-window.reach, window.reach, step)
    places = window.corner + along[:, None, None] * window.along + across[None, :, None] * window.outward
    flat = places.reshape(-1, 2)
    pixels = photograph.in_pixels(frame.place(flat), height).reshape(*places.shape)
    bright = sample(photograph.pixels, pixels).mean(axis=2)
    inside = shapely.contains_xy(cloth.buffer(-RIM), flat[:, 0], flat[:, 1]).reshape(bright.shape)
    slope = gaussian_filter1d(bright, SOFT / step, axis=1, order=1)
    slope -= np.median(slope[inside]) if inside.any() else 0.0
    centre = np.interp(along, along[[0, -1]], [-0.5, 0.5])
    turns = np.linspace(-TURN, TURN, TURNS)
    scores = np.full((TURNS, len(across)), np.nan)
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
    if strength[row, best] < max(CLEAR * noise, LEAST):
        return None
    soft = np.hypot(SOFT, SEEN * photograph.resolution(frame.place(window.corner[None])))
    middle = _rim(across, np.where(known[row], scores[row], 0.0), int(best), float(soft))
    return window.line(middle, float(turns[row]), max(step, 0.3 * SOFT))


def _rim(across: np.ndarray, slopes: np.ndarray, best: int, soft: float) -> float:
    """Return the end of a layer whose rim is a dark or bright band between two slopes, one of them the strongest.

    The slopes at the ends of a band of width w are steepest sqrt(soft^2 + w^2/4) from its middle.
    """
    reach = round(WIDE / float(across[1] - across[0]))
    strength = np.abs(slopes)
    peaks = np.flatnonzero((strength[1:-1] >= strength[:-2]) & (strength[1:-1] >= strength[2:])) + 1
    opposite = slopes[peaks] * slopes[best] < 0
    other = peaks[opposite & (np.abs(peaks - best) <= reach) & (strength[peaks] > SECOND * strength[best])]
    if not len(other):
        return float(across[best])
    ends = across[[best, other[strength[other].argmax()]]]
    half = 0.5 * float(np.ptp(ends))
    return float(ends.mean()) - float(np.sqrt(max(half**2 - soft**2, 0.0)))


def outer_edge(points: np.ndarray, window: Window) -> Line | None:
    """Return the outline's line in a window; None if no part of the outline runs along the window.

    Args:
        points: The outline in the fold's frame [m], shape (n, 2).
        window: Part of the picture in which the edge is expected.
    """
    along, across = window.coordinates(points)
    near = (along > 0.01) & (along < window.length) & (np.abs(across) < window.reach)
    if near.sum() < 8 or np.ptp(along[near]) < 0.6 * window.length:
        return None
    line = Line.through(points[near])
    turn = abs(float(line.direction @ window.outward))
    return line if turn < 1.5 * TURN and line.rms < 0.004 else None
