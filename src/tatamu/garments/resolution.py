"""Chooses the default edge length ("spacing") of a garment's mesh, and limits sizes and spacings."""

from __future__ import annotations

import numpy as np

from tatamu.base.errors import InputError
from tatamu.simulation.material import Material

PASSABLE = 0.65
"""Maximum spacing with passable folds [bending lengths] (docs/theory/bending.md)."""
FINEST_GIVEN = 1e-3
"""Minimum spacing that the user may give [m]."""
MIN_SIDE, MAX_SIDE = 0.05, 5.0
MAX_VERTICES = 50_000
MAX_BY_DEFAULT = 3_000
"""Approximate maximum number of vertices with the default spacing; more would take longer than minutes."""
CELL = np.sqrt(0.75)
"""Area per vertex of a mesh of equilateral triangles, in squared edge lengths."""


def spacing_for(material: Material) -> float:
    """Return the mesh spacing that resolves the folds of a material [m]."""
    # folds are accurate up to a spacing of 0.55 bending lengths (docs/theory/bending.md)
    return float(np.clip(material.bending_length / 2.0, 0.004, 0.02))


def default_spacing(material: Material, area: float) -> float:
    """Return the default spacing [m] for an area of all layers [m^2]: fine enough for folds, but not too fine."""
    return max(spacing_for(material), float(np.sqrt(area / CELL / MAX_BY_DEFAULT)))


def check_size(size: tuple[float, float]) -> None:
    """Refuse a width and length [m] that no garment has."""
    for name, side in zip(("width", "length"), size, strict=True):
        if not MIN_SIDE <= side <= MAX_SIDE:
            raise InputError(f"size: {name} must be from {MIN_SIDE:g} to {MAX_SIDE:g} m, given {side:g} m")


def check_spacing(spacing: float, size: tuple[float, float], area: float) -> None:
    """Refuse a spacing [m] that does not suit a size [m] and an area of all layers [m^2]."""
    if not FINEST_GIVEN <= spacing <= largest_spacing(size):
        raise InputError(
            f"spacing: must be from {FINEST_GIVEN:g} m to a quarter of the shorter side ({largest_spacing(size):g} m), "
            f"given {spacing:g} m"
        )
    if not spacing_is_possible(spacing, size, area):
        raise InputError(f"spacing: {spacing:g} m makes more than {MAX_VERTICES} vertices; give a larger spacing")


def largest_spacing(size: tuple[float, float]) -> float:
    """Return the maximum spacing for a width and length [m]."""
    return min(size) / 4.0


def spacing_is_possible(spacing: float, size: tuple[float, float], area: float) -> bool:
    """Return whether a spacing [m] suits a size [m] and an area of all layers [m^2]."""
    return FINEST_GIVEN <= spacing <= largest_spacing(size) and area / spacing**2 <= 0.8 * MAX_VERTICES
