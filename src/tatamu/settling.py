"""Air drag near critical damping: it brings cloth to rest soon, and does not change the shape at rest."""

from __future__ import annotations

from tatamu.material import Material

MOST_DRAG = 1e3
"""Largest air drag that a material may have [N s/m^3]."""


def settling(material: Material, rate: float) -> Material:
    """Return the material with the drag that damps motions of angular frequency `rate` [rad/s] critically."""
    return material.model_copy(update={"air_drag": min(2.0 * rate * material.areal_density, MOST_DRAG)})
