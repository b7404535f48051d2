"""Computes the shape of a lying garment as seen from above: its outline, and corners with names."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
from scipy.spatial import cKDTree

from tatamu.garments import Garment

ARM = 0.02
"""Length of outline before a corner, and after it, over which the change of direction is measured [m]."""


@dataclass(frozen=True)
class Shape:
    """Outline and corners of a lying garment, seen from above, in the garment's frame."""

    name: str
    polygon: shapely.Polygon
    corners: dict[str, np.ndarray]
    """Positions of the garment's corners by name [m], shape (2,)."""
    height: float
    """Height of the middle of the garment's rim above the table [m]."""

    @cached_property
    def points(self) -> np.ndarray:
        """Points at equal distances along the garment's outline, in counter-clockwise order [m], shape (n, 2)."""
        ring = shapely.segmentize(shapely.orient_polygons(self.polygon).exterior, 0.002)
        return np.asarray(ring.coords)[:-1]

    @cached_property
    def normals(self) -> np.ndarray:
        """Unit vectors at the outline's `points` that point out of the outline, shape (n, 2)."""
        along = np.roll(self.points, -1, axis=0) - np.roll(self.points, 1, axis=0)
        normals = np.column_stack([along[:, 1], -along[:, 0]])
        return np.asarray(normals / np.linalg.norm(normals, axis=1, keepdims=True))

    @cached_property
    def tree(self) -> cKDTree:
        """Search tree of the outline's `points`, which finds the point nearest to a position."""
        return cKDTree(self.points)

    @property
    def size(self) -> np.ndarray:
        """Length (x) and width (y) of the garment [m], shape (2,)."""
        low_x, low_y, high_x, high_y = self.polygon.bounds
        return np.array([high_x - low_x, high_y - low_y])


def shape_of(garment: Garment, lying: np.ndarray | None = None) -> Shape:
    """Return the outline and the named corners of a garment, which is flat or lies at vertices [m], shape (n, 3)."""
    points = garment.vertices if lying is None else lying
    polygon = silhouette(points, garment.faces)
    height = 0.5 * (float(points[:, 2].max()) + 0.5 * garment.material.thickness)
    named = _named_corners(garment, points)
    kept = {name: place for name, place in named.items() if _is_corner(polygon, place)}
    return Shape(garment.name, polygon, kept, height)


def silhouette(points: np.ndarray, faces: np.ndarray) -> shapely.Polygon:
    """Return the largest region that the triangles of a mesh cover, seen from above, with holes filled."""
    triangles = shapely.polygons(points[faces][:, :, :2])
    whole = shapely.union_all(triangles[shapely.area(triangles) > 1e-12], grid_size=1e-6)
    parts = shapely.get_parts(whole)
    return shapely.Polygon(parts[int(np.argmax(shapely.area(parts)))].exterior)


def _named_corners(garment: Garment, points: np.ndarray) -> dict[str, np.ndarray]:
    """Return the ends of a garment's open edges by name; a vertex at which two edges end appears once."""
    named: dict[str, np.ndarray] = {}
    known: set[int] = set()
    ends = {edge: [int(garment.edges[edge][k]) for k in (0, -1)] for edge in garment.openings}
    extent = {edge: np.ptp(garment.vertices[pair], axis=0) for edge, pair in ends.items()}
    for edge in sorted(ends, key=lambda edge: (extent[edge][1] < extent[edge][0], len(edge))):
        axis, words = (0, ("lower", "upper")) if extent[edge][1] < extent[edge][0] else (1, ("right", "left"))
        pair = sorted(ends[edge], key=lambda end: float(garment.vertices[end, axis]))
        for word, end in zip(words, pair, strict=True):
            if end not in known:
                named[f"{edge}-{word}"] = points[end, :2]
                known.add(end)
    return named


def _is_corner(polygon: shapely.Polygon, place: np.ndarray) -> bool:
    ring = polygon.exterior
    if ring.distance(shapely.Point(place)) > 0.004:
        return False
    at, whole = ring.project(shapely.Point(place)), ring.length
    before, here, after = (np.array(ring.interpolate(d % whole).coords[0]) for d in (at - ARM, at, at + ARM))
    turn = np.arccos(np.clip((here - before) @ (after - here) / ARM**2, -1.0, 1.0))
    return bool(turn > np.radians(35.0))
