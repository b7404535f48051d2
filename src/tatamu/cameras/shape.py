"""Computes the shape of a lying garment as seen from above, its outline and named corners, and fits it to a photograph.

The parameters of the fit are x, y, yaw and the scales along and across the garment. It minimises the squared distances
of the found points from the outline; large distances, as of a corner that is folded under, count less.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
from scipy.optimize import least_squares
from scipy.spatial import cKDTree

from tatamu.cameras.edges import curve_normals
from tatamu.cameras.pose import Pose, wrapped
from tatamu.garments import Garment

MAX_SCALE = 1.5
"""Natural logarithm of the largest factor by which the fit may scale a garment."""


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
        return curve_normals(self.points)

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
    arm = 0.02  # length of outline before and after a corner over which it changes its direction [m]
    before, here, after = (np.array(ring.interpolate(d % whole).coords[0]) for d in (at - arm, at, at + arm))
    turn = np.arccos(np.clip((here - before) @ (after - here) / arm**2, -1.0, 1.0))
    return bool(turn > np.radians(35.0))


@dataclass(frozen=True)
class Fit:
    """The pose and the size of a garment, fitted to an outline."""

    shape: Shape
    parameters: np.ndarray
    """x, y [m], yaw [rad] and the logarithms of the scales along and across the garment, shape (5,)."""
    off: np.ndarray
    """Signed distance of each point from the fitted outline [m], shape (n,); positive outside."""
    covariance: np.ndarray
    """Covariance of the parameters that results from errors of the outline in the photograph, shape (5, 5)."""

    @property
    def pose(self) -> Pose:
        """Fitted pose of the garment's frame on the table."""
        x, y, yaw = self.parameters[:3].tolist()
        return Pose(x, y, wrapped(yaw))

    @property
    def scale(self) -> np.ndarray:
        """Factors by which the fit scales the garment: along the garment (x) and across it (y), shape (2,)."""
        return np.exp(self.parameters[3:])

    def place(self, points: np.ndarray) -> np.ndarray:
        """Convert points of the garment's frame to positions on the table, shape (n, 2) each."""
        return self.pose.place(points * self.scale)

    @property
    def rms(self) -> float:
        """Root mean square of the distances `off` from the fitted outline, without the largest tenth of them [m]."""
        best = np.sort(np.abs(self.off))[: max(1, int(0.9 * len(self.off)))]
        return float(np.sqrt(np.mean(best**2)))


def lay(shape: Shape, found: np.ndarray, given: Mapping[str, np.ndarray], outward: Pose | None = None) -> Fit:
    """Fit the outline of a garment to n found points, shape (n, 2), and to corners given by name [m], shape (2,).

    A rectangle fits in several poses, of which the one with the smallest absolute yaw is chosen, measured in the
    robot's frame if `outward` is given: the pose of the frame of `found` in the robot's frame.
    """
    box = np.array(shapely.Polygon(found).minimum_rotated_rectangle.exterior.coords)
    first, second = box[1] - box[0], box[2] - box[1]
    turn = float(np.arctan2(first[1], first[0]))
    middle = box[:4].mean(axis=0)
    low_x, low_y, high_x, high_y = shape.polygon.bounds
    fits = []
    for quarter in range(4):
        yaw = turn + 0.5 * np.pi * quarter
        sides = np.array([np.linalg.norm(first), np.linalg.norm(second)])
        scale = np.clip(np.log((sides if quarter % 2 == 0 else sides[::-1]) / shape.size), -MAX_SCALE, MAX_SCALE)
        centre = np.array([low_x + high_x, low_y + high_y]) / 2 * np.exp(scale)
        start = middle - Pose(yaw=yaw).place(centre[None])[0]
        fits.append(again(shape, found, given, np.array([*start, yaw, *scale])))
    best = min(map(_score, fits))
    base = 0.0 if outward is None else outward.yaw
    likely = [fit for fit in fits if _score(fit) < best + 0.001]  # within a millimetre, poses are equally good
    return min(likely, key=lambda fit: abs(wrapped(fit.pose.yaw + base)))


def _score(fit: Fit) -> float:
    # poses that keep the cloth's proportions are more probable
    return fit.rms + 0.02 * abs(float(fit.parameters[3] - fit.parameters[4]))


def again(shape: Shape, found: np.ndarray, given: Mapping[str, np.ndarray], start: np.ndarray) -> Fit:
    """Fit the outline of a garment from the parameters `start` on."""
    names = list(given)
    own = np.array([shape.corners[name] for name in names]).reshape(-1, 2)
    wanted = np.array([given[name] for name in names]).reshape(-1, 2)
    tolerance = 0.002  # largest error that counts with its square [m]

    def off(parameters: np.ndarray) -> np.ndarray:
        scale = np.exp(parameters[3:])
        flat = Pose(*parameters[:3].tolist()).seen_from(found) / scale
        _, nearest = shape.tree.query(flat)
        return np.asarray((((flat - shape.points[nearest]) * scale) * shape.normals[nearest]).sum(axis=1))

    def residuals(parameters: np.ndarray) -> np.ndarray:
        wrong = Pose(*parameters[:3].tolist()).place(own * np.exp(parameters[3:])) - wanted
        return np.concatenate([off(parameters) / tolerance, wrong.ravel() / 0.001])  # given to a millimetre

    bound = np.array([np.inf, np.inf, np.inf, MAX_SCALE + 0.1, MAX_SCALE + 0.1])
    solved = least_squares(residuals, start, loss="soft_l1", bounds=(-bound, bound), x_scale=0.01)
    away = off(solved.x)
    length = float(shapely.LinearRing(found).length)
    # errors of points within 50 mm along the outline are correlated, so they do not average out
    few = max(1.0, len(found) * 0.05 / length)
    scale = float(np.median(np.abs(away))) * 1.4826 / tolerance
    covariance = np.linalg.pinv(solved.jac.T @ solved.jac, hermitian=True) * max(scale, 0.1) ** 2 * few
    return Fit(shape, solved.x, away, covariance)
