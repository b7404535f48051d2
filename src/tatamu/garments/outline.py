"""Defines the outline of a flat panel of cloth, which consists of named sides."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from shapely import Polygon


@dataclass(frozen=True)
class Outline:
    """A closed counter-clockwise curve of named sides. Each side begins at the end of the side before."""

    sides: Mapping[str, np.ndarray]
    """Points of each side [m], shape (k, 2), including both ends."""
    lines: Mapping[str, np.ndarray] = field(default_factory=dict)
    """Curves inside that a mesh must follow, such as a lower neckline, with both ends on the outline."""
    holes: tuple[np.ndarray, ...] = ()
    """Closed curves around holes [m], shape (k, 2). The last point repeats the first."""

    @property
    def points(self) -> np.ndarray:
        """Points of the whole curve [m], shape (k, 2), of which the first is not repeated."""
        return np.concatenate([side[:-1] for side in self.sides.values()])

    @property
    def polygon(self) -> Polygon:
        """Region inside the outline, without the holes."""
        return Polygon(self.points, [hole[:-1] for hole in self.holes])

    @property
    def size(self) -> tuple[float, float]:
        """Width (y) and length (x) [m]."""
        length, width = np.ptp(self.points, axis=0)
        return float(width), float(length)

    def without_marks(self, spacing: float) -> tuple[Outline, tuple[str, ...]]:
        """Return the outline without holes that are narrower than the spacing [m], and a note on them.

        They are usually buttons, drill holes or letters, and no mesh could follow them.
        """
        rings = [Polygon(hole) for hole in self.holes]
        wide = [4.0 * ring.area >= spacing * ring.length for ring in rings]
        if all(wide):
            return self, ()
        marks = [ring for ring, is_wide in zip(rings, wide, strict=True) if not is_wide]
        holes = tuple(hole for hole, is_wide in zip(self.holes, wide, strict=True) if is_wide)
        note = f"left out: {counted(marks, 'closed curve')} narrower than the spacing of {1e3 * spacing:.1f} mm"
        return replace(self, holes=holes), (note,)

    def fitted(self, size: tuple[float, float] | None) -> Outline:
        """Return the outline centred at the origin and scaled to a width (y) and length (x) [m], if they are given."""
        low = self.points.min(axis=0)
        high = self.points.max(axis=0)
        scale = np.ones(2) if size is None else np.array(size[::-1]) / (high - low)

        def move(points: np.ndarray) -> np.ndarray:
            return (points - 0.5 * (low + high)) * scale

        return Outline(
            {name: move(side) for name, side in self.sides.items()},
            {name: move(line) for name, line in self.lines.items()},
            tuple(move(hole) for hole in self.holes),
        )


def counted(rings: Sequence[Polygon], what: str) -> str:
    """Return the number of closed curves and their area as text."""
    area = sum(ring.area for ring in rings)
    size = f"{area:.4f} m2" if area >= 1e-3 else f"{1e6 * area:.0f} mm2"
    return f"1 {what} of {size}" if len(rings) == 1 else f"{len(rings)} {what}s of {size} in all"


def mirrored(half: list[tuple[str, np.ndarray]]) -> dict[str, np.ndarray]:
    """Return all sides of an outline that is symmetric about y = 0, from its right half (y < 0), counter-clockwise.

    A side "right_.." gets a mirror image "left_..". The others end on y = 0 and are joined with their mirror images.
    """
    twins = {
        name.replace("right_", "left_"): side[::-1] * [1, -1]
        for name, side in reversed(half)
        if name.startswith("right_")
    }
    first = half[0]
    last = half[-1]
    sides: dict[str, np.ndarray] = {}
    for name, side in half:
        if name.startswith("right_"):
            sides[name] = side
    opening = np.concatenate([first[1][::-1] * [1, -1], first[1][1:]])
    closing = np.concatenate([last[1], last[1][::-1][1:] * [1, -1]])
    return {first[0]: opening, **sides, last[0]: closing, **twins}


def resampled(path: np.ndarray, spacing: float) -> np.ndarray:
    """Return points at distances of about `spacing` along a polyline, shape (n, 2), with its ends and corners."""
    steps = np.diff(path, axis=0)
    turn = np.abs(np.angle(np.exp(1j * np.diff(np.arctan2(steps[:, 1], steps[:, 0])))))
    knots = [0, *(np.flatnonzero(turn > np.radians(30.0)) + 1), len(path) - 1]
    pieces = [_even(path[a : b + 1], spacing) for a, b in pairwise(knots)]
    return np.concatenate([pieces[0][:1], *(piece[1:] for piece in pieces)])


def _even(path: np.ndarray, spacing: float) -> np.ndarray:
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    closed = bool((path[0] == path[-1]).all())
    at = np.linspace(0.0, arc[-1], max(4 if closed else 1, round(arc[-1] / spacing)) + 1)
    return np.column_stack([np.interp(at, arc, path[:, k]) for k in (0, 1)])
