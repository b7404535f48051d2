"""Triangle meshes in the plane: staggered rows, on which cloth bends best (docs/theory/bending.md), and Delaunay.

There are two ways to end staggered rows at a straight side, and both are needed:

- `staggered_rectangle`: all rows have the same number of points, and all inner rows are shifted by a quarter cell, to
  the left and to the right in turn. No triangle at the side is much smaller than the others, which would slow an
  explicit simulator down. It is used for garments and the strips of calibration.
- `staggered`: every other row is shifted by half a cell and has one point more. All inner triangles are equal, those at
  the side are halves. Validation uses it, because textbooks use this mesh.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import Delaunay

ROW = np.sqrt(0.75)
"""Distance between the rows of an equilateral lattice, in spacings."""
SHEAR = 0.25
"""Shift of even rows to the left and odd rows to the right, as a fraction of a cell, so that no triangle is very
small."""
SLIVER = 1e-3
"""Twice the area below which triangles are left out, over that of a square; Delaunay makes them at straight sides."""


def staggered_rectangle(width: float, length: float, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a near-equilateral mesh of a rectangle: rows along y, stacked along x.

    Returns:
        Vertices [m], shape (n, 3), z = 0, centred; triangles, shape (m, 3), normals up.
    """
    columns = max(3, round(width / spacing))
    rows = max(4, round(length / (width / columns * np.sqrt(0.75))))
    rows += rows % 2  # an even number, so that a row lies on the fold line of a half fold
    r, c = np.meshgrid(np.arange(rows + 1), np.arange(columns + 1), indexing="ij")
    shift = np.where((c > 0) & (c < columns), np.where(r % 2 == 0, -SHEAR, SHEAR), 0.0)
    x = (r / rows - 0.5) * length
    y = ((c + shift) / columns - 0.5) * width
    number = r * (columns + 1) + c
    a = number[:-1, :-1].ravel()
    b = number[1:, :-1].ravel()
    even = (r[:-1, :-1] % 2 == 0).ravel()[:, None]
    first = np.where(even, np.column_stack([a, b, a + 1]), np.column_stack([a, b, b + 1]))
    second = np.where(even, np.column_stack([b, b + 1, a + 1]), np.column_stack([a, b + 1, a + 1]))
    vertices = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    return vertices, np.stack([first, second], axis=1).reshape(-1, 3)


def staggered(length: float, width: float, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """Return an equilateral mesh of a rectangle, with halves at its sides.

    Rows run along y, every other one shifted by half a cell.

    Returns:
        Points over 0..length x 0..width [m], shape (n, 2); counter-clockwise triangles, shape (m, 3).
    """
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
    """Return triangles between a row of cells + 1 points and one of cells + 2, counter-clockwise seen from +z."""
    narrow, wide = (high, low) if wide_first else (low, high)
    k = np.arange(cells)
    j = np.arange(cells + 1)
    up = np.stack([narrow + k, wide + k + 1, narrow + k + 1], 1)
    down = np.stack([wide + j, wide + j + 1, narrow + j], 1)
    out = np.concatenate([up, down])
    return out[:, ::-1] if wide_first else out


def delaunay(points: np.ndarray, joined: np.ndarray | None = None) -> np.ndarray:
    """Return Delaunay triangles of points (n, 2), counter-clockwise, shape (m, 3).

    Args:
        points: Points of the mesh, shape (n, 2).
        joined: Places of the points for the triangulation, shape (n, 2); None for `points`.
    """
    faces = Delaunay(points if joined is None else joined).simplices.astype(np.int64)
    clockwise = twice_areas(points, faces) < 0
    faces[clockwise] = faces[clockwise][:, ::-1]
    return faces


def twice_areas(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return twice the area of each triangle, negative if clockwise, shape (m,)."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    return (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
