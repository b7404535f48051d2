"""A towel: one rectangular panel on a near-equilateral mesh."""

from __future__ import annotations

import numpy as np

from tatamu.garments.garment import Garment
from tatamu.garments.resolution import check_size, check_spacing, spacing_for
from tatamu.material import Material
from tatamu.meshing import staggered_rectangle
from tatamu.presets import load_preset

FABRIC = "terry"
"""A preset."""
SIZE = (0.34, 0.80)
"""Width and length of a face towel [m]."""


def towel(size: tuple[float, float] = SIZE, material: Material | None = None, spacing: float | None = None) -> Garment:
    """A towel of width (y) and length (x) [m], centred at the origin; mesh rows run across its length.

    Raises:
        InputError: If a size or a spacing that no towel has.
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
    x = vertices[:, 0]
    y = vertices[:, 1]
    bottom = np.flatnonzero(x == x.min())
    top = np.flatnonzero(x == x.max())
    right = np.flatnonzero(y == y.min())
    left = np.flatnonzero(y == y.max())
    return {"bottom": bottom[::-1], "right": right, "top": top, "left": left[::-1]}
