"""Divides an outline into sides, and names unnamed sides: bottom, top, left and right."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from shapely import LineString, Point, distance, line_interpolate_point, points

from tatamu.base.errors import InputError

MIN_SIDE = 0.03
"""Minimum length of an unnamed side, as a fraction of the outline's; a shorter one becomes part of its neighbour."""
MAX_GAP = 0.03
"""Maximum distance of the ends of a curve that names a side from the outline, relative to its larger extent."""
BESIDE = 0.15
"""Maximum distance of its other points, which is large because a straight curve may name a curved neckline."""


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
    """Return whether a curve, shape (k, 2), starts and ends on a closed loop and stays close to it."""
    extent = float(np.ptp(loop, axis=0).max())
    ring = LineString(np.vstack([loop, loop[:1]]))
    places = line_interpolate_point(LineString(curve), np.linspace(0.0, 1.0, 33), normalized=True)
    away = distance(places, ring)
    apart = abs(ring.project(places[-1]) - ring.project(places[0])) > 1e-3 * ring.length
    return apart and float(away[[0, -1]].max()) <= MAX_GAP * extent and float(away.max()) <= BESIDE * extent


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
        sizes = [float(length[np.arange(a, b) % len(label)].sum()) for a, b in runs]
        short = [k for k, size in enumerate(sizes) if label[runs[k][0] % len(label)] not in kept]
        short = [k for k in short if sizes[k] < MIN_SIDE * length.sum()]
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
    """Return runs of equally labelled segments around a closed loop: the first one, and the first one after the run."""
    starts = np.flatnonzero(label != np.roll(label, 1))
    if not len(starts):
        return [(0, len(label))]
    return [(int(a), int(b)) for a, b in zip(starts, [*starts[1:], starts[0] + len(label)], strict=True)]


def _main_first(
    runs: list[tuple[int, int]], label: np.ndarray, extremes: Mapping[str, np.ndarray]
) -> list[tuple[int, int]]:
    """Return the runs; of all that face one direction, the outermost comes first."""

    def rank(run: tuple[int, int]) -> float:
        reach = extremes.get(str(label[run[0] % len(label)]))
        return 0.0 if reach is None else float(reach[np.arange(run[0], run[1] + 1) % len(label)].mean())

    return sorted(runs, key=rank)


def with_ends(loop: np.ndarray, named: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return a closed loop with an additional point at each end of the curves that name its sides."""
    ring = LineString(np.vstack([loop, loop[:1]]))
    corners = [ring.project(Point(p)) for p in loop]
    ends = [ring.project(Point(p)) for curve in named.values() for p in np.asarray(curve, dtype=float)[[0, -1]]]
    near = 1e-3 * ring.length
    added = [at for at in ends if min(abs(at - c) for c in [*corners, ring.length]) > near]
    at = np.unique(np.concatenate([corners, added]))
    return np.array([ring.interpolate(a).coords[0] for a in at])
