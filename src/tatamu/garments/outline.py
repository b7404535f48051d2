"""Defines the outline of a flat panel of cloth, divides it into named sides, and these into seams and openings."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import count, pairwise
from typing import NamedTuple

import numpy as np
from shapely import LineString, Point, Polygon, distance, line_interpolate_point, points

from tatamu.base.curves import arc_lengths
from tatamu.base.errors import InputError

MIN_SIDE = 0.03
"""Minimum length of an unnamed side, as a fraction of the outline's; a shorter one becomes part of its neighbour."""
MAX_GAP = 0.03
"""Maximum distance of the ends of a curve that names a side from the outline, relative to its larger extent."""


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


def counted(rings: Sequence[Polygon] | np.ndarray, what: str) -> str:
    """Return the number of closed curves and their area as text."""
    area = sum(ring.area for ring in rings)
    size = f"{area:.4f} m2" if area >= 1e-3 else f"{1e6 * area:.0f} mm2"
    return f"1 {what} of {size}" if len(rings) == 1 else f"{len(rings)} {what}s of {size} in all"


def mirrored(half: list[tuple[str, np.ndarray]]) -> dict[str, np.ndarray]:
    """Return all sides of an outline that is symmetric about y = 0, from its right half (y < 0), counter-clockwise.

    A side "right_.." gets a mirror image "left_..". The others end on y = 0 and are joined with their mirror images.
    """
    right = [(name, side) for name, side in half if name.startswith("right_")]
    twins = {name.replace("right_", "left_"): side[::-1] * [1, -1] for name, side in reversed(right)}
    (first, opening), (last, closing) = half[0], half[-1]
    whole_opening = np.concatenate([opening[::-1] * [1, -1], opening[1:]])
    whole_closing = np.concatenate([closing, closing[::-1][1:] * [1, -1]])
    return {first: whole_opening, **dict(right), last: whole_closing, **twins}


def resampled(path: np.ndarray, spacing: float) -> np.ndarray:
    """Return points at distances of about `spacing` along a polyline, shape (n, 2), with its ends and corners."""
    steps = np.diff(path, axis=0)
    turn = np.abs(np.angle(np.exp(1j * np.diff(np.arctan2(steps[:, 1], steps[:, 0])))))
    knots = [0, *(np.flatnonzero(turn > np.radians(30.0)) + 1), len(path) - 1]
    parts = [path[a : b + 1] for a, b in pairwise(knots)]
    pieces = [even(part, spacing, 4 if (part[0] == part[-1]).all() else 1) for part in parts]
    return np.concatenate([pieces[0][:1], *(piece[1:] for piece in pieces)])


def even(path: np.ndarray, spacing: float, fewest: int) -> np.ndarray:
    """Return points at equal distances of about `spacing` along a polyline, with its ends and `fewest` segments."""
    arc = arc_lengths(path)
    at = np.linspace(0.0, arc[-1], max(fewest, round(arc[-1] / spacing)) + 1)
    return np.column_stack([np.interp(at, arc, path[:, k]) for k in (0, 1)])


def named_sides(loop: np.ndarray, named: Mapping[str, np.ndarray] | None = None) -> dict[str, np.ndarray]:
    """Cut a closed loop, the outline of a garment, into named sides.

    Args:
        loop: Points in counter-clockwise order, of which the first is not repeated [m], shape (k, 2).
        named: Curves [m], shape (j, 2), that give their names to the part of the loop between the points nearest to
            their ends.

    Returns:
        Indices of the points of each side, with both ends, by name.
        Others are named after the direction they face: "bottom" (-x), "right" (-y), "top" (+x), "left" (+y). Of
        several, the outermost has this name, and the next is called "bottom 2".

    Raises:
        InputError: If a named curve does not lie along the loop.
    """
    steps = np.roll(loop, -1, axis=0) - loop
    outward = np.arctan2(-steps[:, 0], steps[:, 1])
    facing = np.round(outward / (0.5 * np.pi)).astype(int) % 4  # 0 is +x, 1 is +y
    label = np.array(["top", "left", "bottom", "right"], dtype=object)[facing]
    for name, curve in (named or {}).items():
        label[_along(loop, name, np.asarray(curve, dtype=float))] = name
    _absorb(label, np.linalg.norm(steps, axis=1), set(named or {}))
    reach = {"bottom": loop[:, 0], "right": loop[:, 1], "top": -loop[:, 0], "left": -loop[:, 1]}
    runs = [(name, np.append(segments, (segments[-1] + 1) % len(loop))) for name, segments in _runs(label)]
    # of all that face one direction, the outermost comes first
    runs.sort(key=lambda run: float(reach[run[0]][run[1]].mean()) if run[0] in reach else 0.0)
    sides: dict[str, np.ndarray] = {}
    for name, along in runs:
        sides[numbered(name, sides)] = along
    return dict(sorted(sides.items(), key=lambda side: int(side[1][0])))


def numbered(name: str, taken: Collection[str]) -> str:
    """Return a name, with a number if it is taken."""
    return next(each for k in count(1) if (each := name if k == 1 else f"{name} {k}") not in taken)


def lies_along(loop: np.ndarray, curve: np.ndarray) -> bool:
    """Return whether a curve, shape (k, 2), starts and ends on a closed loop and stays close to it."""
    extent = float(np.ptp(loop, axis=0).max())
    ring = LineString(np.vstack([loop, loop[:1]]))
    places = line_interpolate_point(LineString(curve), np.linspace(0.0, 1.0, 33), normalized=True)
    away = distance(places, ring)
    apart = abs(ring.project(places[-1]) - ring.project(places[0])) > 1e-3 * ring.length
    # the other points may be far away, because a straight curve may name a curved neckline
    return apart and float(away[[0, -1]].max()) <= MAX_GAP * extent and float(away.max()) <= 0.15 * extent


def _along(loop: np.ndarray, name: str, curve: np.ndarray) -> np.ndarray:
    """Return the indices of the segments of a closed loop that a curve follows."""
    extent = float(np.ptp(loop, axis=0).max())
    away = np.linalg.norm(loop[:, None] - curve[[0, -1]], axis=2)
    start, end = (int(k) for k in away.argmin(axis=0))
    if away.min(axis=0).max() > MAX_GAP * extent or start == end:
        raise InputError(f"openings: {name} must begin and end on the outline, at two different places")
    line = LineString(curve)
    middle = points(0.5 * (loop + np.roll(loop, -1, axis=0)))
    either = [np.arange(a, b if b > a else b + len(loop)) % len(loop) for a, b in ((start, end), (end, start))]
    return min(either, key=lambda part: float(distance(middle[part], line).max()))


def _absorb(label: np.ndarray, length: np.ndarray, kept: set[str]) -> None:
    """Join short sides that are not in `kept` with longer neighbours: change their segments' names in `label`."""
    while True:
        runs = _runs(label)
        sizes = [float(length[segments].sum()) for _, segments in runs]
        beside = [[j % len(runs) for j in (k - 1, k + 1)] for k in range(len(runs))]
        joinable = [[j for j in pair if runs[j][0] not in kept] for pair in beside]
        short = [k for k, (name, _) in enumerate(runs) if name not in kept and sizes[k] < MIN_SIDE * length.sum()]
        short = [k for k in short if joinable[k]]
        if not short or len(runs) <= 2:
            return
        k = min(short, key=lambda k: sizes[k])
        label[runs[k][1]] = runs[max(joinable[k], key=lambda j: sizes[j])][0]


def _runs(label: np.ndarray) -> list[tuple[str, np.ndarray]]:
    """Return runs of equally labelled segments around a closed loop: the label and the segments' indices."""
    starts = np.flatnonzero(label != np.roll(label, 1)).tolist() or [0]
    ends = [*starts[1:], starts[0] + len(label)]
    return [(str(label[a]), np.arange(a, b) % len(label)) for a, b in zip(starts, ends, strict=True)]


def with_ends(loop: np.ndarray, named: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return a closed loop with an additional point at each end of the curves that name its sides."""
    ring = LineString(np.vstack([loop, loop[:1]]))
    corners = [ring.project(Point(p)) for p in loop]
    ends = [ring.project(Point(p)) for curve in named.values() for p in np.asarray(curve, dtype=float)[[0, -1]]]
    near = 1e-3 * ring.length
    added = [at for at in ends if min(abs(at - c) for c in [*corners, ring.length]) > near]
    at = np.unique(np.concatenate([corners, added]))
    return np.array([ring.interpolate(a).coords[0] for a in at])


class _Part(NamedTuple):
    """A sewn or open part of a garment's side, from its `first` to its `last` point."""

    first: int
    last: int
    is_open: bool


def divided(
    sides: Mapping[str, np.ndarray], border: np.ndarray, plan: np.ndarray
) -> tuple[dict[str, np.ndarray], tuple[str, ...]]:
    """Divide the sides of a garment into sewn parts and open parts; return all by name, and the names of the open ones.

    The longest sewn part keeps the name of its side. An open part of the side "top" is called "top opening".

    Args:
        sides: Paths of vertices by name; each path begins at the end of the previous path.
        border: Edges of the mesh that belong to a single triangle, shape (b, 2).
        plan: Positions of the vertices [m], shape (n, 2).
    """
    free = {tuple(pair) for pair in border.tolist()}
    lengths = {side: np.linalg.norm(np.diff(plan[path], axis=0), axis=1) for side, path in sides.items()}
    around = sum(float(each.sum()) for each in lengths.values())
    parted: dict[str, np.ndarray] = {}
    openings = []
    for side, path in sides.items():
        is_open = np.array([tuple(sorted(pair)) in free for pair in pairwise(path.tolist())])
        parts = _parts(is_open, lengths[side], MIN_SIDE * around)
        main = max(parts, key=lambda part: (not part.is_open, part.last - part.first))
        for part in parts:
            wish = f"{side} opening" if part.is_open else side
            name = side if part is main else numbered(wish, {*sides, *parted})
            parted[name] = path[part.first : part.last + 1]
            openings += [name] if part.is_open else []
    return parted, tuple(openings)


def _parts(is_open: np.ndarray, lengths: np.ndarray, shortest: float) -> list[_Part]:
    """Return the parts of a side; one shorter than `shortest` [m] is joined with its longer neighbour."""
    kind = is_open.copy()
    while True:
        bounds = [0, *(np.flatnonzero(np.diff(kind)) + 1).tolist(), len(kind)]
        parts = [_Part(first, last, bool(kind[first])) for first, last in pairwise(bounds)]
        sizes = [float(lengths[part.first : part.last].sum()) for part in parts]
        smallest = int(np.argmin(sizes))
        if len(parts) == 1 or sizes[smallest] >= shortest:
            return parts
        part = parts[smallest]
        kind[part.first : part.last] = not part.is_open
