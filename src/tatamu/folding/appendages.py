"""Parts of a flat outline that stick out of its body: sleeves, a hood, the foot of a sock.

The body is the morphological opening of the outline with a disc: the union of all discs of one radius that fit inside
the outline. What sticks out far enough is an appendage. It is folded onto the body over a line through the corner at
which it leaves the body.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from tatamu.folding.plan import SIDES
from tatamu.garments import Garment

FACING = {name: SIDES[name] for name in ("+y", "-y", "+x", "-x")}
"""Directions in which appendages may stick out, in the order in which they are folded; +y is the left."""


@dataclass(frozen=True)
class Appendage:
    """A part of a garment that sticks out of its body."""

    region: shapely.Polygon
    """Area of the part outside the body [m]."""
    facing: str
    """Direction in which the part sticks out: +x, -x, +y or -y."""
    line: float
    """Coordinate of its fold line [m]: x if the part faces +x or -x, otherwise y."""

    @property
    def tip(self) -> np.ndarray:
        """Point of the part that is farthest from its fold line [m], shape (2,)."""
        points = np.array(self.region.exterior.coords)
        return np.asarray(points[np.argmax(points @ FACING[self.facing])])


def silhouette(garment: Garment) -> shapely.Polygon:
    """Return the region that a flat garment covers [m]. Holes are filled."""
    return region_of(garment.vertices[:, :2], garment.faces)


def region_of(plan: np.ndarray, faces: np.ndarray) -> shapely.Polygon:
    """Return the largest piece of the region below a mesh, with holes filled, from positions [m], shape (n, 2)."""
    triangles = shapely.polygons(plan[faces])
    covered = shapely.union_all(triangles[shapely.area(triangles) > 1e-12], grid_size=1e-6)
    largest = max(shapely.get_parts(covered.buffer(0)), key=lambda part: float(part.area))
    return shapely.Polygon(largest.exterior)


def appendages(outline: shapely.Polygon) -> list[Appendage]:
    """Return the appendages of an outline: first those at the left and the right side, then those at the two ends."""
    radius = 0.6 * float(shapely.maximum_inscribed_circle(outline, 1e-3).length)  # of the disc
    body = outline.buffer(-radius).buffer(radius)
    sliver = 0.12 * radius  # half the width of strips along the body, which could join two appendages
    apart = outline.difference(body).buffer(-sliver).buffer(sliver).intersection(outline)
    found = [  # right-angled corners stick out by 0.41 radii
        _appendage(outline, body, part)
        for part in shapely.get_parts(apart)
        if isinstance(part, shapely.Polygon) and not part.is_empty and _depth(part, body) > 0.7 * radius
    ]
    order = list(FACING)
    return sorted(found, key=lambda each: (order.index(each.facing), float(each.region.centroid.x)))


def _depth(part: shapely.Polygon, body: shapely.Geometry) -> float:
    corners = shapely.points(np.array(part.exterior.coords))
    return float(shapely.distance(corners, body).max())


def _appendage(outline: shapely.Polygon, body: shapely.Geometry, part: shapely.Polygon) -> Appendage:
    """Return a part with its fold line. It faces the direction most nearly perpendicular to its root."""
    root = _root(part, body)
    chord = root[1] - root[0]
    across = np.array([chord[1], -chord[0]]) / (np.linalg.norm(chord) + 1e-12)
    outwards = np.array(part.centroid.coords[0]) - root.mean(axis=0)
    across = across if across @ outwards > 0 else -across
    facing = max(FACING, key=lambda name: float(across @ FACING[name]))
    direction = np.array(FACING[facing])
    near = shapely.LineString(root).buffer(float(np.linalg.norm(chord)))
    corners = [corner for corner in _reflex(outline) if shapely.contains_xy(near, *corner)]
    places = [float(corner @ direction) for corner in (corners or list(root))]
    return Appendage(part, facing, max(places) * float(direction.sum()))


def _root(part: shapely.Polygon, body: shapely.Geometry) -> np.ndarray:
    """Return both ends of the border between a part and the body [m], shape (2, 2)."""
    corners = np.array(part.exterior.coords[:-1])
    distance = shapely.distance(shapely.points(corners), body)
    touching = corners[distance <= distance.min() + 0.25 * (np.median(distance) - distance.min()) + 1e-9]
    apart = np.linalg.norm(touching[:, None] - touching[None], axis=2)
    return np.asarray(touching[list(np.unravel_index(int(apart.argmax()), apart.shape))])


def _reflex(outline: shapely.Polygon) -> np.ndarray:
    """Return the corners at which a simplified outline turns inwards by at least 12 degrees [m], shape (k, 2)."""
    simple = shapely.orient_polygons(shapely.simplify(outline, 0.006))
    points = np.array(simple.exterior.coords[:-1])
    before = points - np.roll(points, 1, axis=0)
    after = np.roll(points, -1, axis=0) - points
    turn = np.arctan2(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0], (before * after).sum(axis=1))
    return points[turn < -np.radians(12.0)]


def has_legs(outline: shapely.Polygon) -> bool:
    """Return whether a notch near the middle of the garment's lower end divides it into two legs."""
    low_x, low_y, high_x, high_y = outline.bounds
    middle = 0.5 * (low_y + high_y)
    aside = 0.15 * (high_y - low_y)  # maximum sideways distance between the notch and the middle
    notch = 0.35  # minimum depth, as a fraction of the garment's length
    strip = shapely.box(low_x, middle - aside, low_x + notch * (high_x - low_x), middle + aside)
    ends = shapely.LineString([(low_x, middle - aside), (low_x, middle + aside)])
    free = strip.difference(outline)
    depth = [part.bounds[2] - low_x for part in shapely.get_parts(free) if part.distance(ends) < 1e-3]
    return max(depth, default=0.0) > (notch - 0.02) * (high_x - low_x)
