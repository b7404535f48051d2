"""Air drag near critical damping, with which cloth soon comes to rest in the same final shape."""

from __future__ import annotations

from tatamu.simulation.material import Material

MAX_DRAG = 1e3
"""Maximum air drag of a material [N s/m^3]."""


def settling(material: Material, rate: float) -> Material:
    """Return the material with drag that critically damps motions of the angular frequency `rate` [rad/s]."""
    return material.model_copy(update={"air_drag": min(2.0 * rate * material.areal_density, MAX_DRAG)})
