"""Making cloth come to rest soon: air drag near critical damping, which does not change where it rests."""

from __future__ import annotations

from tatamu.material import Material

MOST_DRAG = 1e3
"""Largest air drag that a material may have [N s/m^3]."""


def settling(material: Material, rate: float) -> Material:
    """The material with the drag that damps motions of angular frequency `rate` [rad/s] critically."""
    return material.model_copy(update={"air_drag": min(2.0 * rate * material.areal_density, MOST_DRAG)})
