"""Finds the hem, the sleeves and the neck of a T-shirt from its outline alone.

A pocket is a gap between the outline and its convex hull. The one under each sleeve has the corner of the hem at its
lower end and the underarm at its deepest point. A curved neck is another pocket; a straight neck is the level part at
the top. Of the sides between underarm and neck, the end of the sleeve is the one farthest from their midpoint.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from tatamu.base.curves import length
from tatamu.base.errors import InputError


@dataclass(frozen=True)
class _Pocket:
    """A gap between a T-shirt's outline and its convex hull."""

    ends: np.ndarray
    """Indices of its first and last point, the left one first, shape (2,)."""
    middle: np.ndarray
    """Midpoint between the ends, shape (2,)."""
    depth: float
    deepest: int
    """Index of the point farthest from the line between the ends."""


def tshirt_openings(outline: np.ndarray) -> dict[str, np.ndarray]:
    """Find the open parts of a T-shirt's outline: hem, left_sleeve (on the left of the picture), right_sleeve, neck.

    Args:
        outline: Points of a closed curve, x to the right and y down, with the hem at the bottom, shape (k, 2).

    Returns:
        Indices of the points along each open part, by name.

    Raises:
        InputError: If a sleeve has no pocket under it, no neck is found, or the sleeves are very different.
    """
    low, (width, height) = outline.min(axis=0), np.ptp(outline, axis=0)
    pockets = _pockets(outline)
    deep = [pocket for pocket in pockets if pocket.depth > 0.05 * width]
    # in the left and in the right third of the picture
    sides = [[each for each in deep if abs((each.middle[0] - low[0]) / width - k) < 1.0 / 3.0] for k in (0.0, 1.0)]
    # a neckline with less depth counts as straight
    neck = _neck(outline, [pocket for pocket in pockets if pocket.depth > 0.01 * height])
    for found, what in ((sides[0], "left sleeve"), (sides[1], "right sleeve"), (neck, "neck")):
        if not found:
            raise InputError(
                f"garment: no {what} of a T-shirt is found in the photo; lay the sleeves away from the body and take a "
                "photo with the hem at the bottom, or name the openings in a garment file"
            )
    under = [max(found, key=lambda pocket: pocket.depth) for found in sides]
    sleeves = [_sleeve_end(outline, pocket.deepest, end) for pocket, end in zip(under, neck, strict=True)]
    sizes = [float(np.linalg.norm(outline[a] - outline[b])) for a, b in sleeves]
    if max(sizes) > 2.0 * min(sizes):
        raise InputError(
            f"garment: both sleeve ends must be about equally wide, given {sizes[0]:.2f} and {sizes[1]:.2f} m; lay the "
            "sleeves flat and take another photo"
        )
    hem = [max(pocket.ends.tolist(), key=lambda end: float(outline[end, 1])) for pocket in under]
    ends = {"hem": (hem[0], hem[1]), "left_sleeve": sleeves[0], "right_sleeve": sleeves[1], "neck": (neck[0], neck[1])}
    return {name: _shorter_way(outline, *pair) for name, pair in ends.items()}


def _neck(points: np.ndarray, pockets: list[_Pocket]) -> tuple[int, ...]:
    """Return the indices of the ends of a T-shirt's neck, the left one first; none if there is no neck."""
    low, (width, height) = points.min(axis=0), np.ptp(points, axis=0)
    centre = low[0] + 0.5 * width
    top = [p for p in pockets if abs(p.middle[0] - centre) < 0.25 * width and p.middle[1] - low[1] < height / 3.0]
    ends = max(top, key=lambda pocket: pocket.depth).ends if top else _level_part(points, centre)
    return _by_x(ends, points) if len(ends) and 0.08 * width < np.ptp(points[ends, 0]) < 0.6 * width else ()


def _level_part(points: np.ndarray, centre: float) -> np.ndarray:
    """Return the indices of the ends of the level part at the top of a curve that contains x = `centre`, shape (2,).

    There are none if the top is steep there.
    """
    after = np.roll(points, -1, axis=0)
    across = np.flatnonzero((points[:, 0] - centre) * (after[:, 0] - centre) <= 0.0)
    if not len(across):
        return np.empty(0, dtype=np.int64)
    steps = np.abs(after - points)
    # steeper parts are shoulders
    level = steps[:, 1] <= np.tan(np.radians(12.0)) * steps[:, 0]
    first = last = int(across[np.argmin(points[across, 1] + after[across, 1])])
    count = len(points)
    if not level[first]:
        return np.empty(0, dtype=np.int64)
    while level[(first - 1) % count] and (first - 1) % count != last:
        first = (first - 1) % count
    while level[(last + 1) % count] and (last + 1) % count != first:
        last = (last + 1) % count
    return np.array([first, (last + 1) % count])


def _pockets(points: np.ndarray) -> list[_Pocket]:
    """Return the gaps between a closed curve and its convex hull."""
    hull = shapely.MultiPoint(points).convex_hull
    on_hull = np.flatnonzero(shapely.distance(hull.exterior, shapely.points(points)) < 1e-9 * float(np.ptp(points)))
    found = []
    for a, b in zip(on_hull, np.roll(on_hull, -1), strict=True):
        between = _shorter_way(points, int(a), int(b))[1:-1]
        if not len(between):
            continue
        chord = shapely.LineString(points[[a, b]])
        depths = shapely.distance(chord, shapely.points(points[between]))
        ends = np.array(_by_x(np.array([a, b]), points))
        found.append(_Pocket(ends, points[[a, b]].mean(axis=0), depths.max(), int(between[depths.argmax()])))
    return found


def _by_x(ends: np.ndarray, points: np.ndarray) -> tuple[int, int]:
    first, second = sorted(ends.tolist(), key=lambda end: float(points[end, 0]))
    return first, second


def _sleeve_end(points: np.ndarray, underarm: int, neck: int) -> tuple[int, int]:
    """Return the indices of the ends of a sleeve's opening, the side farthest from the middle of underarm and neck."""
    way = _shorter_way(points, underarm, neck)
    tolerance = 0.02 * float(np.ptp(points[:, 0]))
    corners = shapely.get_coordinates(shapely.simplify(shapely.LineString(points[way]), tolerance))
    at = [int(way[np.argmin(np.linalg.norm(points[way] - corner, axis=1))]) for corner in corners]
    away = np.linalg.norm(corners - 0.5 * (points[underarm] + points[neck]), axis=1)
    side = int(np.argmax(np.minimum(away[:-1], away[1:])))
    return at[side], at[side + 1]


def _shorter_way(points: np.ndarray, start: int, end: int) -> np.ndarray:
    """Return the indices from `start` to `end` along the shorter way around a closed curve."""
    count = len(points)
    ahead = np.arange(start, end + 1 + (count if end < start else 0)) % count
    back = np.arange(start, end - 1 - (count if end > start else 0), -1) % count
    return min(ahead, back, key=lambda way: length(points[way]))
