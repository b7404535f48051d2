"""Triangle meshes in the plane: staggered rows, on which cloth bends best (docs/theory/bending.md), and Delaunay."""

from __future__ import annotations

import numpy as np
from scipy.spatial import Delaunay

from tatamu.simulation.mesh.topology import twice_areas

ROW = np.sqrt(0.75)
"""Distance between the rows of an equilateral triangle mesh [edges]."""
SHEAR = 0.25
"""Shift of even rows to the left and of odd rows to the right [cells]. If only odd rows were shifted, half triangles at
the sides would slow down an explicit simulator."""
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


def delaunay(points: np.ndarray, joined: np.ndarray | None = None) -> np.ndarray:
    """Return the counter-clockwise Delaunay triangles of points, triangulated at the positions `joined` if given."""
    faces = Delaunay(points if joined is None else joined).simplices.astype(np.int64)
    clockwise = twice_areas(points, faces) < 0
    faces[clockwise] = faces[clockwise][:, ::-1]
    return faces
