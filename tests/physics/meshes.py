"""Meshes of a rectangle for the checks: right triangles, staggered rows, irregular meshes and rotated meshes.

Every function returns the unstrained mesh of the rectangle 0..length x 0..width. The mesh consists of points of shape
(n, 2) [m] and of counter-clockwise faces of shape (m, 3).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from tatamu.simulation.mesh.meshing import SLIVER, delaunay
from tatamu.simulation.mesh.topology import twice_areas

Mesh = tuple[np.ndarray, np.ndarray]
Layout = Callable[[float, float, float], Mesh]
"""Function that makes a mesh of a rectangle from length, width and spacing [m]."""

JITTER = 0.2
"""Largest displacement of the inner vertices in an irregular mesh, divided by the mesh spacing."""
SHEAR = 0.02
"""Small shear that is applied to a square lattice of points before its triangulation [-]. Because of this shear,
Delaunay triangulation cuts all cells along the same diagonal."""


def right(length: float, width: float, spacing: float) -> Mesh:
    """Return a mesh of square cells that are all cut along the same diagonal."""
    nx = max(1, round(length / spacing))
    ny = max(1, round(width / spacing))
    x, y = np.meshgrid(np.linspace(0, length, nx + 1), np.linspace(0, width, ny + 1), indexing="ij")
    number = np.arange((nx + 1) * (ny + 1)).reshape(nx + 1, ny + 1)
    a, b, c, d = (q.ravel() for q in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
    return np.column_stack([x.ravel(), y.ravel()]), np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def staggered(length: float, width: float, spacing: float) -> Mesh:
    """Return a counter-clockwise mesh of 0..length x 0..width, equilateral but for half triangles at its sides."""
    rows = max(2, 2 * round(length / (np.sqrt(3) * spacing)))
    cells = max(1, round(width / spacing))
    even = np.linspace(0, width, cells + 1)
    odd = np.concatenate([[0.0], 0.5 * (even[1:] + even[:-1]), [width]])
    plans = [odd if row % 2 else even for row in range(rows + 1)]
    points = np.concatenate(
        [np.column_stack([np.full(len(y), x), y]) for x, y in zip(np.linspace(0, length, rows + 1), plans, strict=True)]
    )
    starts = np.cumsum([0] + [len(y) for y in plans])
    faces = [_between(starts[row], starts[row + 1], cells, bool(row % 2)) for row in range(rows)]
    return points, np.concatenate(faces)


def _between(low: int, high: int, cells: int, wide_first: bool) -> np.ndarray:
    """Return the counter-clockwise triangles between a row of cells + 1 points and a row of cells + 2 points."""
    narrow, wide = (high, low) if wide_first else (low, high)
    k = np.arange(cells)
    j = np.arange(cells + 1)
    up = np.stack([narrow + k, wide + k + 1, narrow + k + 1], 1)
    down = np.stack([wide + j, wide + j + 1, narrow + j], 1)
    out = np.concatenate([up, down])
    return out[:, ::-1] if wide_first else out


def staggered_across(length: float, width: float, spacing: float) -> Mesh:
    """Return a staggered mesh, in which every other row is shifted, with its rows along x."""
    points, faces = staggered(width, length, spacing)
    return points[:, ::-1].copy(), faces[:, ::-1].copy()


def irregular(length: float, width: float, spacing: float, seed: int = 1) -> Mesh:
    """Return an irregular mesh: Delaunay triangles between randomly shifted points.

    The shifted points are inside. The points on the border are evenly spaced.
    """
    lattice = _lattice(length, width, spacing * np.array([np.sqrt(3) / 2, 1.0]), 0.0, shifted=True)
    random = np.random.default_rng(seed)
    inner = _inside(lattice, length, width, 0.5 * spacing)
    inner = inner + JITTER * spacing * random.uniform(-1, 1, inner.shape)
    return _triangulated(inner, length, width, spacing, 0.0)


def turned(length: float, width: float, spacing: float, degrees: float) -> Mesh:
    """Return a mesh of right triangles in a rotated lattice. Points on the border are evenly spaced."""
    if degrees == 0:
        return right(length, width, spacing)
    angle = np.radians(degrees)
    lattice = _lattice(length, width, spacing * np.ones(2), angle, shifted=False)
    inner = _inside(lattice, length, width, 0.45 * spacing)
    return _triangulated(inner, length, width, spacing, angle)


def _lattice(length: float, width: float, cell: np.ndarray, angle: float, shifted: bool) -> np.ndarray:
    """Return k points of a rotated lattice around the middle of the rectangle, shape (k, 2)."""
    reach = int(np.hypot(length, width) / cell.min()) + 2
    i, j = (q.ravel() for q in np.meshgrid(np.arange(-reach, reach + 1), np.arange(-reach, reach + 1)))
    points = np.column_stack([i * cell[0], (j + 0.5 * (i % 2) * shifted) * cell[1]])
    cosine = np.cos(angle)
    sine = np.sin(angle)
    return points @ np.array([[cosine, sine], [-sine, cosine]]) + np.array([length, width]) / 2


def _inside(points: np.ndarray, length: float, width: float, margin: float) -> np.ndarray:
    low = (points >= margin - 1e-12).all(1)
    return points[low & (points[:, 0] <= length - margin + 1e-12) & (points[:, 1] <= width - margin + 1e-12)]


def _triangulated(inner: np.ndarray, length: float, width: float, spacing: float, angle: float) -> Mesh:
    nx = max(1, round(length / spacing))
    ny = max(1, round(width / spacing))
    x = np.linspace(0, length, nx + 1)
    y = np.linspace(0, width, ny + 1)[1:-1]
    sides = [(x, 0 * x), (x, 0 * x + width), (0 * y, y), (0 * y + length, y)]
    points = np.concatenate([np.column_stack(side) for side in sides] + [inner])
    cosine = np.cos(angle)
    sine = np.sin(angle)
    along = points @ np.array([[cosine, -sine], [sine, cosine]])
    faces = delaunay(points, along + SHEAR * np.column_stack([along[:, 1], 0 * along[:, 0]]))
    return points, faces[twice_areas(points, faces) > SLIVER * spacing**2]


def mirrored(mesh: Mesh) -> Mesh:
    """Return a mesh joined with its mirror image in x = 0. The result is a symmetric strip of twice the length."""
    points, faces = mesh
    on_line = np.abs(points[:, 0]) < 1e-12
    image = np.arange(len(points))
    image[~on_line] = len(points) + np.arange(int((~on_line).sum()))
    both = np.concatenate([points, points[~on_line] * [-1, 1]])
    return both, np.concatenate([faces, image[faces][:, ::-1]])


LAYOUTS: dict[str, Layout] = {
    "right triangles": right,
    "right triangles at 30 deg": partial(turned, degrees=30.0),
    "right triangles at 45 deg": partial(turned, degrees=45.0),
    "staggered": staggered,
    "staggered across": staggered_across,
    "irregular": irregular,
}
"""Mesh layouts by name. The angles in the names are between the rows of the mesh and the length of the strip."""
