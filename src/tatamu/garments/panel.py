"""Meshes a flat panel of cloth with nearly equilateral triangles.

Points are placed along the outline. Inside, they form a staggered lattice with rows along y, one at x = 0, on which
bending is most accurate (docs/theory/bending.md). Lattice points too close to the outline are dropped, and those next
to it are moved to the middle of their neighbours. Delaunay triangulation joins all points.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely
from scipy import sparse

from tatamu.base.errors import InputError
from tatamu.garments.garment import MAX_VERTICES
from tatamu.garments.outline import Outline, resampled
from tatamu.simulation.mesh.meshing import ROW, SLIVER, delaunay
from tatamu.simulation.mesh.topology import Topology, edge_lengths, twice_areas

RELAXED = 1.7
"""Maximum distance from the outline at which lattice points are moved [spacings]."""


@dataclass(frozen=True)
class Panel:
    """A triangle mesh in the plane, with the vertices in rows of rising x."""

    points: np.ndarray
    """Positions of the vertices [m], shape (n, 2)."""
    faces: np.ndarray
    """Counter-clockwise triangles, shape (m, 3)."""
    paths: dict[str, np.ndarray]
    """Vertices along each side, line and hole of the outline, in order."""


def panel(outline: Outline, spacing: float) -> Panel:
    """Mesh the inside of an outline with triangles whose sides are about `spacing` [m] long.

    Raises:
        InputError: If two parts of the outline are too close to each other for this spacing.
    """
    curves = {**outline.sides, **outline.lines, **{f"hole {k + 1}": hole for k, hole in enumerate(outline.holes)}}
    curves = {name: resampled(curve, spacing) for name, curve in curves.items()}
    _check_possible(curves, spacing)
    for _ in range(4):
        made = [_filled(outline, curves, spacing, dropped) for dropped in (0.56, 0.62, 0.68, 0.74)]
        best = max(made, key=lambda mesh: _quality(mesh, spacing))
        faulty = _faulty(best, 0.15 * spacing)
        if not faulty:
            return best
        curves = {name: _split(curve, best.paths[name], faulty) for name, curve in curves.items()}
    raise _too_near(best.points[list(faulty[0])].mean(axis=0), spacing)


def _check_possible(curves: dict[str, np.ndarray], spacing: float) -> None:
    """Refuse an outline that cannot be meshed, before attempts to mesh it take time."""
    count = sum(len(curve) for curve in curves.values())
    if count > MAX_VERTICES // 2:
        raise InputError(
            f"outline: must have at most {MAX_VERTICES // 2} points on its border, given {count}; simplify the drawing"
        )
    border = shapely.unary_union([shapely.LineString(curve) for curve in curves.values()])
    if shapely.minimum_clearance(border) < 0.01 * spacing:  # edges would be too short
        start, end = shapely.get_coordinates(shapely.minimum_clearance_line(border))
        raise _too_near(0.5 * (start + end), spacing)


def _too_near(place: np.ndarray, spacing: float) -> InputError:
    return InputError(
        f"outline: is too narrow at x {place[0]:.4f}, y {place[1]:.4f} m for a spacing of {spacing:g} m; give a "
        "smaller spacing or a simpler outline"
    )


def _quality(mesh: Panel, spacing: float) -> float:
    """Return the minimum of smallest angle over 30 degrees and of 1.7 spacings over the longest edge; 1 is good."""
    longest = float(edge_lengths(mesh.points, Topology(mesh.faces).edges).max())
    return min(float(np.degrees(angles(mesh.points, mesh.faces).min())) / 30.0, 1.7 * spacing / longest)


def angles(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the angle at each corner of triangles [rad], shape (m, 3), in the plane or in space."""
    out = np.empty(faces.shape)
    for k in range(3):
        a, b = (points[faces[:, (k + j) % 3]] - points[faces[:, k]] for j in (1, 2))
        lengths = np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1)
        out[:, k] = np.arccos(np.clip((a * b).sum(axis=1) / lengths, -1.0, 1.0))
    return out


def _filled(outline: Outline, curves: dict[str, np.ndarray], spacing: float, dropped: float) -> Panel:
    """Return a mesh inside an outline, without lattice points closer than `dropped` spacings to a curve."""
    fixed, paths = _welded(curves, 1e-3 * spacing)
    border = shapely.MultiLineString([fixed[path] for path in paths.values()])
    region = shapely.Polygon(
        np.concatenate([fixed[paths[name]][:-1] for name in outline.sides]),
        [fixed[path][:-1] for name, path in paths.items() if name.startswith("hole ")],
    )
    shapely.prepare([border, region])
    lattice = _lattice(fixed, spacing)
    away = shapely.distance(shapely.points(lattice), border)
    inner = lattice[shapely.contains_xy(region, *lattice.T) & (away > dropped * spacing)]
    points = _relaxed(fixed, inner, region, border, spacing)
    order = np.lexsort([points[:, 1], np.round(points[:, 0] / (ROW * spacing))])
    place = np.empty(len(order), dtype=np.int64)
    place[order] = np.arange(len(order))
    points = points[order]
    return Panel(points, _triangles(points, region), {name: place[path] for name, path in paths.items()})


def _welded(curves: dict[str, np.ndarray], near: float) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Return all distinct points of several curves, and each curve as indices of these points."""
    everything = np.concatenate(list(curves.values()))
    _, first, number = np.unique(np.round(everything / near), axis=0, return_index=True, return_inverse=True)
    ends = np.cumsum([len(curve) for curve in curves.values()])[:-1]
    return everything[first], dict(zip(curves, np.split(number.ravel(), ends), strict=True))


def _lattice(around: np.ndarray, spacing: float) -> np.ndarray:
    """Return a staggered lattice that covers the points `around`, symmetric in y with a row at x = 0, shape (n, 2)."""
    low = np.floor(around.min(axis=0) / spacing / [ROW, 1]).astype(int) - 1
    high = np.ceil(around.max(axis=0) / spacing / [ROW, 1]).astype(int) + 1
    r, c = np.meshgrid(np.arange(low[0], high[0] + 1), np.arange(low[1], high[1] + 1), indexing="ij")
    return np.column_stack([(r * ROW * spacing).ravel(), ((c + 0.5 * (r % 2)) * spacing).ravel()])


def _triangles(points: np.ndarray, region: shapely.Polygon) -> np.ndarray:
    """Return the counter-clockwise Delaunay triangles inside the region, shape (m, 3)."""
    faces = delaunay(points)
    longest = np.max([((points[faces[:, k]] - points[faces[:, k - 1]]) ** 2).sum(axis=1) for k in range(3)], axis=0)
    solid = twice_areas(points, faces) > SLIVER * longest
    return faces[solid & shapely.contains_xy(region, *points[faces].mean(axis=1).T)]


def _relaxed(
    fixed: np.ndarray, inner: np.ndarray, region: shapely.Polygon, border: shapely.MultiLineString, spacing: float
) -> np.ndarray:
    """Return all points; inner ones next to the border are moved to the middle of their neighbours."""
    points = np.concatenate([fixed, inner])
    loose = len(fixed) + np.flatnonzero(shapely.distance(shapely.points(inner), border) < RELAXED * spacing)
    for _ in range(12 if len(loose) else 0):
        pairs = Topology(_triangles(points, region)).edges
        both = np.concatenate([pairs, pairs[:, ::-1]])
        joined = sparse.csr_array((np.ones(len(both)), both.T), shape=(len(points), len(points)))[loose]
        count = np.asarray(joined.sum(axis=1)).ravel()
        middle = (joined @ points) / np.maximum(count, 1)[:, None]
        fits = shapely.contains_xy(region, *middle.T) & (count > 0)
        # more than half a spacing, because Delaunay triangulation then keeps the edges of the outline
        fits &= shapely.distance(shapely.points(middle), border) > 0.52 * spacing
        points[loose[fits]] = middle[fits]
    return points


def _faulty(mesh: Panel, least: float) -> list[tuple[int, ...]]:
    """Return the edges of the outline that the mesh lacks, or else those so short that they need short time steps."""
    edges = Topology(mesh.faces).edges
    wanted = {tuple(sorted(pair)) for path in mesh.paths.values() for pair in pairwise(path.tolist())}
    short = edges[edge_lengths(mesh.points, edges) < least]
    return sorted(wanted - {tuple(edge) for edge in edges.tolist()}) or [tuple(edge) for edge in short.tolist()]


def _split(curve: np.ndarray, path: np.ndarray, faulty: list[tuple[int, ...]]) -> np.ndarray:
    """Return a curve with an additional point in the middle of each faulty edge."""
    here = [k + 1 for k in range(len(path) - 1) if tuple(sorted(path[k : k + 2].tolist())) in faulty]
    return np.insert(curve, here, [0.5 * (curve[k - 1] + curve[k]) for k in here], axis=0) if here else curve


def without_chords(mesh: Panel, sewn: np.ndarray) -> Panel:
    """Return a mesh without inner edges between two `sewn` vertices, which both layers would share.

    Each of these edges is flipped, so it joins two other vertices, or gets a vertex in its middle if flipping would
    make triangles too sharp.
    """
    points = mesh.points
    faces = mesh.faces.copy()
    while len(chords := _chords(faces, sewn)):
        a, b, c, d = chords[0]
        both = np.array([[c, a, d], [d, b, c]])
        faces = faces[~(np.isin(faces, [a, b]).sum(axis=1) == 2)]
        sharp = angles(points, both).min() < np.radians(20.0) or (twice_areas(points, both) <= 0).any()
        if sharp or np.isin([c, d], sewn).all():
            both = np.array([[a, len(points), c], [len(points), b, c], [b, len(points), d], [len(points), a, d]])
            points = np.vstack([points, 0.5 * (points[a] + points[b])])
        faces = np.concatenate([faces, both])
    return Panel(points, faces, mesh.paths)


def _chords(faces: np.ndarray, sewn: np.ndarray) -> np.ndarray:
    """Return the inner edges a-b between two sewn vertices, with c to their left and d to their right, shape (k, 4)."""
    hinges = Topology(faces).hinges
    return hinges[np.isin(hinges[:, :2], sewn).all(axis=1)]
