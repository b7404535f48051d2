"""A towel: one rectangular panel on a near-equilateral mesh."""

from __future__ import annotations

import numpy as np

from tatamu.garments.garment import Garment
from tatamu.garments.resolution import check_size, check_spacing, spacing_for
from tatamu.material import Material
from tatamu.presets import load_preset

FABRIC = "terry"
"""A preset."""
SIZE = (0.34, 0.80)
"""Width and length of a face towel [m]."""
SHEAR = 0.25
"""Columns of even and odd rows are shifted by this part of a cell, one left, one right: interior triangles are then
equilateral, and those at the straight sides are not so small that they would slow the explicit steps down."""


def towel(size: tuple[float, float] = SIZE, material: Material | None = None, spacing: float | None = None) -> Garment:
    """A towel of width (y) and length (x) [m], centred at the origin; mesh rows run across its length.

    Raises:
        InputError: A size or a spacing that no towel has.
    """
    check_size(size)
    material = material or load_preset(FABRIC).material
    chosen = spacing if spacing is not None else spacing_for(material)
    check_spacing(chosen, size, size[0] * size[1])
    vertices, faces = staggered_rectangle(*size, chosen)
    vertices[:, 2] = 0.5 * material.thickness
    edges = _sides(vertices)
    return Garment("towel", size, chosen, vertices, faces, material, edges=edges, openings=tuple(edges))


def _sides(vertices: np.ndarray) -> dict[str, np.ndarray]:
    """The four sides as paths of vertices, counter-clockwise."""
    x, y = vertices[:, 0], vertices[:, 1]
    bottom, top = np.flatnonzero(x == x.min()), np.flatnonzero(x == x.max())
    right, left = np.flatnonzero(y == y.min()), np.flatnonzero(y == y.max())
    return {"bottom": bottom[::-1], "right": right, "top": top, "left": left[::-1]}


def staggered_rectangle(width: float, length: float, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """Near-equilateral mesh of a rectangle: rows along y, stacked along x.

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
    a, b = number[:-1, :-1].ravel(), number[1:, :-1].ravel()
    even = (r[:-1, :-1] % 2 == 0).ravel()[:, None]
    first = np.where(even, np.column_stack([a, b, a + 1]), np.column_stack([a, b, b + 1]))
    second = np.where(even, np.column_stack([b, b + 1, a + 1]), np.column_stack([a, b + 1, a + 1]))
    vertices = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    return vertices, np.stack([first, second], axis=1).reshape(-1, 3)
