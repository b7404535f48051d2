"""Names for the unnamed sides of an outline: bottom, top, left and right."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from shapely import LineString, Point, distance, line_interpolate_point, points

from tatamu.errors import InputError

QUARTERS = ("bottom", "right", "top", "left")
"""Directions in which a side may face: -x, -y, +x, +y."""
SHORTEST = 0.03
"""Least length of an unnamed side, as a fraction of the outline; shorter sides belong to a neighbour."""
FARTHEST = 0.03
"""Largest distance of the ends of a named curve from the outline, as a fraction of the outline's larger extent."""
BESIDE = 0.15
"""Largest distance of its other points, as a fraction of the extent: a straight curve may cross a curved neckline."""


def named_sides(loop: np.ndarray, named: Mapping[str, np.ndarray] | None = None) -> dict[str, np.ndarray]:
    """Cut a closed loop into sides.

    Args:
        loop: Points counter-clockwise [m], shape (k, 2), without the closing point.
        named: Curves along parts of the loop [m], shape (j, 2) each: the part between the points nearest to a curve's
            ends gets its name.

    Returns:
        Numbers of the points of each side, both ends included, one side after the other. The side "bottom" holds the
        point of least x, "right" that of least y, "top" and "left" those of largest; further sides that face the same
        way are "bottom 2", ..

    Raises:
        InputError: If a named curve does not lie along the loop.
    """
    count = len(loop)
    steps = np.roll(loop, -1, axis=0) - loop
    outward = np.arctan2(-steps[:, 0], steps[:, 1])
    facing = np.round(outward / (0.5 * np.pi)).astype(int) % 4  # 0 is +x, 1 is +y
    label = np.array(["top", "left", "bottom", "right"], dtype=object)[facing]
    for name, curve in (named or {}).items():
        label[_along(loop, name, np.asarray(curve, dtype=float))] = name
    _absorb(label, np.linalg.norm(steps, axis=1), set(named or {}))
    runs = _runs(label)
    extremes = {"bottom": loop[:, 0], "right": loop[:, 1], "top": -loop[:, 0], "left": -loop[:, 1]}
    sides: dict[str, np.ndarray] = {}
    for first, last in _main_first(runs, label, extremes):
        name = str(label[first % count])
        number = 1
        while (title := name if number == 1 else f"{name} {number}") in sides:
            number += 1
        sides[title] = np.arange(first, last + 1) % count
    return dict(sorted(sides.items(), key=lambda side: int(side[1][0])))


def lies_along(loop: np.ndarray, curve: np.ndarray) -> bool:
    """Return whether a curve (k, 2) starts and ends on the loop [m] and stays next to it in between."""
    extent = float(np.ptp(loop, axis=0).max())
    ring = LineString(np.vstack([loop, loop[:1]]))
    places = line_interpolate_point(LineString(curve), np.linspace(0.0, 1.0, 33), normalized=True)
    away = distance(places, ring)
    apart = abs(ring.project(places[-1]) - ring.project(places[0])) > 1e-3 * ring.length
    return apart and float(away[[0, -1]].max()) <= FARTHEST * extent and float(away.max()) <= BESIDE * extent


def _along(loop: np.ndarray, name: str, curve: np.ndarray) -> np.ndarray:
    """Return the segments of the loop that a curve follows."""
    extent = float(np.ptp(loop, axis=0).max())
    away = np.linalg.norm(loop[:, None] - curve[[0, -1]], axis=2)
    start, end = (int(k) for k in away.argmin(axis=0))
    if away.min(axis=0).max() > FARTHEST * extent or start == end:
        raise InputError(f"openings: {name} must begin and end on the outline, at two different places")
    line = LineString(curve)
    middle = points(0.5 * (loop + np.roll(loop, -1, axis=0)))
    either = [np.arange(a, b if b > a else b + len(loop)) % len(loop) for a, b in ((start, end), (end, start))]
    return min(either, key=lambda part: float(distance(middle[part], line).max()))


def _absorb(label: np.ndarray, length: np.ndarray, kept: set[str]) -> None:
    """Give runs that are short, and not named, the name of their longer neighbour."""
    while True:
        runs = _runs(label)
        sizes = [float(length[np.arange(a, b) % len(label)].sum()) for a, b in runs]
        short = [k for k, size in enumerate(sizes) if label[runs[k][0] % len(label)] not in kept]
        short = [k for k in short if sizes[k] < SHORTEST * length.sum()]
        around = {
            k: [j for j in ((k - 1) % len(runs), (k + 1) % len(runs)) if _name(runs, label, j) not in kept]
            for k in short
        }
        short = [k for k in short if around[k]]
        if not short or len(runs) <= 2:
            return
        k = min(short, key=lambda k: sizes[k])
        label[np.arange(*runs[k]) % len(label)] = _name(runs, label, max(around[k], key=lambda j: sizes[j]))


def _name(runs: list[tuple[int, int]], label: np.ndarray, k: int) -> str:
    return str(label[runs[k][0] % len(label)])


def _runs(label: np.ndarray) -> list[tuple[int, int]]:
    """Return runs of equal labels around the loop: the first segment, and the first one after the run."""
    starts = np.flatnonzero(label != np.roll(label, 1))
    if not len(starts):
        return [(0, len(label))]
    return [(int(a), int(b)) for a, b in zip(starts, [*starts[1:], starts[0] + len(label)], strict=True)]


def _main_first(
    runs: list[tuple[int, int]], label: np.ndarray, extremes: Mapping[str, np.ndarray]
) -> list[tuple[int, int]]:
    """Return runs in order, with the outermost first among those that face one direction."""

    def rank(run: tuple[int, int]) -> float:
        reach = extremes.get(str(label[run[0] % len(label)]))
        return 0.0 if reach is None else float(reach[np.arange(run[0], run[1] + 1) % len(label)].mean())

    return sorted(runs, key=rank)


def with_ends(loop: np.ndarray, named: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return the loop with an additional point at each end of a named curve."""
    ring = LineString(np.vstack([loop, loop[:1]]))
    corners = [ring.project(Point(p)) for p in loop]
    ends = [ring.project(Point(p)) for curve in named.values() for p in np.asarray(curve, dtype=float)[[0, -1]]]
    near = 1e-3 * ring.length
    added = [at for at in ends if min(abs(at - c) for c in [*corners, ring.length]) > near]
    at = np.unique(np.concatenate([corners, added]))
    return np.array([ring.interpolate(a).coords[0] for a in at])
