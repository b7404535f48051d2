"""Triangle meshes in the plane: staggered rows, and Delaunay triangles.

Cloth bends best on staggered rows (docs/theory/bending.md).

There are two ways to end staggered rows at a straight side, and both are needed:

- `staggered_rectangle`: all rows have an equal number of points. All inner rows are shifted by a quarter cell, to the
  left and to the right in turn. With this shift, no triangle at the side is very small. Small triangles would slow down
  an explicit simulator. Garments and the strips of calibration use this mesh.
- `staggered`: every other row is shifted by half a cell and has one point more. All inner triangles are equal, and the
  triangles at the sides are halves. Validation uses this mesh, because textbooks use it.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import Delaunay

ROW = np.sqrt(0.75)
"""Distance between the rows of an equilateral triangle mesh, in lengths of an edge."""
SHEAR = 0.25
"""Shift of a mesh's even rows to the left, and of its odd rows to the right, as a fraction of a cell.

With this shift, no triangle is very small."""
SLIVER = 1e-3
"""Smallest allowed ratio of twice a triangle's area to the area of a square cell.

Triangles with smaller ratios are left out. Delaunay triangulation makes such triangles at straight sides.
"""


def staggered_rectangle(width: float, length: float, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a nearly equilateral mesh of a rectangle. Rows are along y and follow each other along x.

    Returns:
        The n vertices [m], shape (n, 3), centred and with z = 0, and the m triangles, shape (m, 3), with upward
        normals.
    """
    columns = max(3, round(width / spacing))
    rows = max(4, round(length / (width / columns * np.sqrt(0.75))))
    rows += rows % 2  # with an even number, a row lies on the line of a half fold
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
    """Return an equilateral mesh of a rectangle, with half triangles at its sides.

    Rows are along y. Every other row is shifted by half a cell.

    Returns:
        The n points of the rectangle 0..length x 0..width [m], shape (n, 2), and the m counter-clockwise triangles,
        shape (m, 3).
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
    """Return the triangles between a row of cells + 1 points and a row of cells + 2 points.

    The triangles are counter-clockwise, seen from +z.
    """
    narrow, wide = (high, low) if wide_first else (low, high)
    k = np.arange(cells)
    j = np.arange(cells + 1)
    up = np.stack([narrow + k, wide + k + 1, narrow + k + 1], 1)
    down = np.stack([wide + j, wide + j + 1, narrow + j], 1)
    out = np.concatenate([up, down])
    return out[:, ::-1] if wide_first else out


def delaunay(points: np.ndarray, joined: np.ndarray | None = None) -> np.ndarray:
    """Return the m counter-clockwise Delaunay triangles of n points, shape (m, 3).

    Args:
        points: Points of the mesh, shape (n, 2).
        joined: Positions of the points that are used for the triangulation, shape (n, 2); None for `points`.
    """
    faces = Delaunay(points if joined is None else joined).simplices.astype(np.int64)
    clockwise = twice_areas(points, faces) < 0
    faces[clockwise] = faces[clockwise][:, ::-1]
    return faces


def twice_areas(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return twice the area of each triangle, shape (m,). It is negative if the triangle is clockwise."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    return (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
