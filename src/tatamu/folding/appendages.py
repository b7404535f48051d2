"""Parts of a flat outline that stick out of its body: sleeves, a hood, the foot of a sock.

The body is the morphological opening of the outline with a disc: the union of all discs of one radius that fit inside
the outline. A part outside the body is an appendage if it sticks out far enough. An appendage is folded onto the body
over a line through the corner where the appendage leaves the body.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from tatamu.folding.plan import SIDES
from tatamu.garments import Garment

OPENING = 0.6
"""Radius of the discs that form a garment's body, as a fraction of the radius of the largest disc inside the outline.

The body is the union of all discs of this size that fit inside the outline. Sleeves and hoods are too narrow for such a
disc.
"""
LEAST_DEPTH = 0.7
"""Least distance by which an appendage, such as a sleeve, sticks out of the garment's body.

The unit is the radius of the discs that form the body. The right-angled corners of a garment also stick out of the
body, but only by 0.41 radii.
"""
BRIDGE = 0.12
"""Half of the largest width at which a narrow strip of cloth along the body is cut away.

The unit is the radius of the discs that form the garment's body. Such a strip could join two appendages, such as
sleeves, which would then count as one.
"""
COARSE = 0.006
"""Largest distance by which simplification may move an outline [m].

Outlines are simplified before their corners are found.
"""
REFLEX = np.radians(12.0)
"""Least angle by which an outline turns inwards at a corner where a sleeve or another appendage may begin [rad]."""
NOTCH = 0.35
"""Least depth of the notch between two trouser legs, as a fraction of the garment's length."""
NOTCH_ASIDE = 0.15
"""Largest sideways distance between the notch of trouser legs and the garment's middle, as a fraction of the width."""
FACING = {name: SIDES[name] for name in ("+y", "-y", "+x", "-x")}
"""The four directions in which sleeves and other appendages may stick out, in the order in which they are folded.

+y is the left.
"""


@dataclass(frozen=True)
class Appendage:
    """A part of a garment that sticks out of its body, such as a sleeve."""

    region: shapely.Polygon
    """The area outside the garment's body that the part covers, as a polygon with coordinates in metres."""
    facing: str
    """Direction in which the part sticks out of the garment's body: +x, -x, +y or -y."""
    line: float
    """Coordinate of the line over which the part is folded [m]: x if the part faces +x or -x, otherwise y."""

    @property
    def tip(self) -> np.ndarray:
        """Point of the part that is farthest from its fold line [m], shape (2,)."""
        points = np.array(self.region.exterior.coords)
        return np.asarray(points[np.argmax(points @ FACING[self.facing])])


def silhouette(garment: Garment) -> shapely.Polygon:
    """Return the region that a flat garment covers [m]. Holes are filled."""
    return region_of(garment.vertices[:, :2], garment.faces)


def region_of(plan: np.ndarray, faces: np.ndarray) -> shapely.Polygon:
    """Return the largest piece of the region that a mesh covers, seen from above. Holes are filled.

    Args:
        plan: Horizontal positions of the vertices [m], shape (n, 2).
        faces: Triangles, shape (m, 3).
    """
    triangles = shapely.polygons(plan[faces])
    covered = shapely.union_all(triangles[shapely.area(triangles) > 1e-12], grid_size=1e-6)
    largest = max(shapely.get_parts(covered.buffer(0)), key=lambda part: float(part.area))
    return shapely.Polygon(largest.exterior)


def appendages(outline: shapely.Polygon) -> list[Appendage]:
    """Return the appendages of a garment's outline, which are the parts that stick out, such as sleeves.

    Appendages at the garment's left and right side come first, left before right. Appendages at its two ends follow.
    """
    radius = OPENING * float(shapely.maximum_inscribed_circle(outline, 1e-3).length)
    body = outline.buffer(-radius).buffer(radius)
    sliver = BRIDGE * radius
    apart = outline.difference(body).buffer(-sliver).buffer(sliver).intersection(outline)
    found = [
        _appendage(outline, body, part)
        for part in shapely.get_parts(apart)
        if isinstance(part, shapely.Polygon) and not part.is_empty and _depth(part, body) > LEAST_DEPTH * radius
    ]
    order = list(FACING)
    return sorted(found, key=lambda each: (order.index(each.facing), float(each.region.centroid.x)))


def _depth(part: shapely.Polygon, body: shapely.Geometry) -> float:
    """Return the largest distance between a part's border and the garment's body [m]."""
    corners = shapely.points(np.array(part.exterior.coords))
    return float(shapely.distance(corners, body).max())


def _appendage(outline: shapely.Polygon, body: shapely.Geometry, part: shapely.Polygon) -> Appendage:
    """Return a part that sticks out, such as a sleeve, as an `Appendage` with its direction and its fold line.

    Its `facing` is the direction that is most nearly perpendicular to the root of the part, where it meets the body.
    """
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
    """Return both ends of the border between a part, such as a sleeve, and the garment's body [m], shape (2, 2)."""
    corners = np.array(part.exterior.coords[:-1])
    distance = shapely.distance(shapely.points(corners), body)
    touching = corners[distance <= distance.min() + 0.25 * (np.median(distance) - distance.min()) + 1e-9]
    apart = np.linalg.norm(touching[:, None] - touching[None], axis=2)
    return np.asarray(touching[list(np.unravel_index(int(apart.argmax()), apart.shape))])


def _reflex(outline: shapely.Polygon) -> np.ndarray:
    """Return the k corners at which an outline turns inwards [m], shape (k, 2)."""
    coarse = shapely.orient_polygons(shapely.simplify(outline, COARSE))
    points = np.array(coarse.exterior.coords[:-1])
    before = points - np.roll(points, 1, axis=0)
    after = np.roll(points, -1, axis=0) - points
    turn = np.arctan2(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0], (before * after).sum(axis=1))
    return points[turn < -REFLEX]


def has_legs(outline: shapely.Polygon) -> bool:
    """Return whether a notch near the middle of the garment's lower end divides it into two legs."""
    low_x, low_y, high_x, high_y = outline.bounds
    middle = 0.5 * (low_y + high_y)
    aside = NOTCH_ASIDE * (high_y - low_y)
    strip = shapely.box(low_x, middle - aside, low_x + NOTCH * (high_x - low_x), middle + aside)
    ends = shapely.LineString([(low_x, middle - aside), (low_x, middle + aside)])
    free = strip.difference(outline)
    depth = [part.bounds[2] - low_x for part in shapely.get_parts(free) if part.distance(ends) < 1e-3]
    return max(depth, default=0.0) > (NOTCH - 0.02) * (high_x - low_x)
