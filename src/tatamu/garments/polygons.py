"""Cuts faces of a mesh that have more than three corners into triangles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from tatamu.simulation.mesh.topology import twice_areas

MAX_CORNERS = 2_000


def triangulate(corners: Sequence[int], vertices: np.ndarray) -> list[tuple[int, int, int]]:
    """Cut a face of a mesh into triangles that have the orientation of the face, as indices into `corners`.

    A convex face becomes a fan around its first corner. A concave face is projected onto the plane that fits it best
    (Newell's normal), and divided inside its outline. `vertices` are those of the whole mesh, shape (n, 3).

    Raises:
        ValueError: If the face has fewer than three corners or too many, or it touches or crosses itself.
    """
    count = len(corners)
    if not 3 <= count <= MAX_CORNERS:
        raise ValueError(f"a face must have from 3 to {MAX_CORNERS} corners, given {count}")
    fan = [(0, k, k + 1) for k in range(1, count - 1)]
    if count == 3:
        return fan
    flat = _in_plane(vertices[list(corners)])
    if (twice_areas(flat, np.array(fan)) >= 0.0).all() or not np.isfinite(flat).all():
        return fan
    return _divided(flat)


def _in_plane(points: np.ndarray) -> np.ndarray:
    """Return the points of a face in its plane, counter-clockwise about its normal, shape (k, 2)."""
    with np.errstate(all="ignore"):
        around = points - points.mean(axis=0)
        around /= max(float(np.abs(around).max()), 1e-300)
        normal = np.cross(around, np.roll(around, -1, axis=0)).sum(axis=0)
        across = np.eye(3)[int(np.abs(normal).argmin())]
        first = np.cross(across, normal)
        first /= max(float(np.linalg.norm(first)), 1e-300)
        second = np.cross(normal, first)
        second /= max(float(np.linalg.norm(second)), 1e-300)
    return np.column_stack([around @ first, around @ second])


def _divided(flat: np.ndarray) -> list[tuple[int, int, int]]:
    """Return triangles that fill a concave outline."""
    outline = shapely.Polygon(flat)
    place = {(float(x), float(y)): k for k, (x, y) in enumerate(flat)}
    if not outline.is_valid or len(place) < len(flat):
        raise ValueError(f"a face of {len(flat)} corners touches or crosses itself")
    found = []
    for triangle in shapely.get_parts(shapely.constrained_delaunay_triangles(outline)):
        a, b, c = (place[x, y] for x, y in triangle.normalize().exterior.coords[:3])
        found.append((a, c, b))  # normalised rings are clockwise
    return sorted(found)
