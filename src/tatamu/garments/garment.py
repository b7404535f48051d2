"""A garment: a flat mesh on the table, of one fabric."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from tatamu.material import Material


@dataclass(frozen=True)
class Garment:
    """A garment laid flat, centred at the origin, its mid-surface half a thickness over z = 0."""

    name: str
    size: tuple[float, float]
    """Width (y) and length (x) [m]."""
    spacing: float
    """Typical edge length of the mesh [m]."""
    vertices: np.ndarray
    """Flat positions [m], shape (n, 3)."""
    faces: np.ndarray
    """Triangles, shape (m, 3)."""
    material: Material
    seams: np.ndarray = field(default_factory=lambda: np.empty((0, 2), dtype=np.int64))
    """Edges that hinge freely, shape (s, 2)."""
