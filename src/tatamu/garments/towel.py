"""Makes a towel: one rectangular panel with nearly equilateral triangles."""

from __future__ import annotations

import numpy as np

from tatamu.garments.garment import Garment, check_size, check_spacing, spacing_for
from tatamu.simulation.material import Material
from tatamu.simulation.mesh.meshing import staggered_rectangle
from tatamu.simulation.presets import load_preset

SIZE = (0.34, 0.80)
"""Width and length of the default towel, a face towel [m]."""


def towel(size: tuple[float, float] = SIZE, material: Material | None = None, spacing: float | None = None) -> Garment:
    """Make a towel of a width (y) and length (x) [m], centred at the origin. The rows of the mesh run along y."""
    check_size(size)
    material = material or load_preset("terry").material
    chosen = spacing if spacing is not None else spacing_for(material)
    check_spacing(chosen, size, size[0] * size[1])
    vertices, faces = staggered_rectangle(*size, chosen)
    vertices[:, 2] = 0.5 * material.thickness
    x, y, _ = vertices.T
    edges = {
        "bottom": np.flatnonzero(x == x.min())[::-1],
        "right": np.flatnonzero(y == y.min()),
        "top": np.flatnonzero(x == x.max()),
        "left": np.flatnonzero(y == y.max())[::-1],
    }
    return Garment("towel", size, chosen, vertices, faces, material, edges=edges, openings=tuple(edges))
