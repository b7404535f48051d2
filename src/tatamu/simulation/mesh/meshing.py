"""Triangle meshes in the plane: staggered rows, on which cloth bends best (docs/theory/bending.md), and Delaunay.

Staggered rows end at a straight side in one of two ways. The quarter shifts of `staggered_rectangle` make no small
triangles, which would slow down an explicit simulator; garments and strips use it. `staggered`, with half triangles at
the sides, is the mesh of textbooks, with which results are validated.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import Delaunay

ROW = np.sqrt(0.75)
"""Distance between the rows of an equilateral triangle mesh [edges]."""
SHEAR = 0.25
"""Shift of even rows to the left and of odd rows to the right [cells], so that no triangle is very small."""
SLIVER = 1e-3
"""Minimum ratio of twice a triangle's area to a square cell; Delaunay makes thinner triangles at straight sides."""


def staggered_rectangle(width: float, length: float, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a nearly equilateral mesh of a centred rectangle at z = 0, with rows along y and upward normals."""
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


def delaunay(points: np.ndarray, joined: np.ndarray | None = None) -> np.ndarray:
    """Return the counter-clockwise Delaunay triangles of points, triangulated at the positions `joined` if given."""
    faces = Delaunay(points if joined is None else joined).simplices.astype(np.int64)
    clockwise = twice_areas(points, faces) < 0
    faces[clockwise] = faces[clockwise][:, ::-1]
    return faces


def twice_areas(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return twice the area of each triangle, shape (m,), negative if it is clockwise."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    return (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
