"""The default spacing of a garment's mesh, and the limits of sizes and spacings."""

from __future__ import annotations

import numpy as np

from tatamu.errors import InputError
from tatamu.material import Material

CELLS_PER_BENDING_LENGTH = 2.0
"""Mesh spacing is half a bending length: folds are right up to 0.55 of it (docs/theory/bending.md)."""
PASSABLE = 0.65
"""Folds are passable up to this many bending lengths of spacing (docs/theory/bending.md)."""
COARSEST, FINEST = 0.02, 0.004
"""Spacing chosen from the bending length stays within these [m]."""
FINEST_GIVEN = 1e-3
"""No spacing is below this [m]."""
SMALLEST_SIDE, LARGEST_SIDE = 0.05, 5.0
MOST_VERTICES = 50_000
MOST_BY_DEFAULT = 3_000
"""Approximate largest number of vertices in two layers with a default spacing, so that a study takes minutes."""
CELL = np.sqrt(0.75)
"""Area per vertex of an equilateral mesh, in squares of the spacing."""


def spacing_for(material: Material) -> float:
    """Mesh spacing that resolves the folds of a material [m]."""
    return float(np.clip(material.bending_length / CELLS_PER_BENDING_LENGTH, FINEST, COARSEST))


def default_spacing(material: Material, area: float) -> float:
    """Spacing that resolves the folds of a material, coarser where `area` [m^2] would take too many vertices [m]."""
    return max(spacing_for(material), float(np.sqrt(area / CELL / MOST_BY_DEFAULT)))


def check_size(size: tuple[float, float]) -> None:
    """Refuse a width and length [m] that no garment has.

    Raises:
        InputError: One of them is out of range.
    """
    for name, side in zip(("width", "length"), size, strict=True):
        if not SMALLEST_SIDE <= side <= LARGEST_SIDE:
            raise InputError(f"size: {name} must be from {SMALLEST_SIDE:g} to {LARGEST_SIDE:g} m, given {side:g} m")


def check_spacing(spacing: float, size: tuple[float, float], area: float) -> None:
    """Refuse a spacing [m] that no mesh of this size [m] and area of all layers [m^2] can have.

    Raises:
        InputError: It is too large or too small.
    """
    if not FINEST_GIVEN <= spacing <= largest_spacing(size):
        raise InputError(
            f"spacing: must be from {FINEST_GIVEN:g} m to a quarter of the shorter side ({largest_spacing(size):g} m), "
            f"given {spacing:g} m"
        )
    if not spacing_is_possible(spacing, size, area):
        raise InputError(f"spacing: {spacing:g} m makes more than {MOST_VERTICES} vertices; give a larger one")


def largest_spacing(size: tuple[float, float]) -> float:
    """The coarsest mesh spacing of a garment of this width and length [m]."""
    return min(size) / 4.0


def spacing_is_possible(spacing: float, size: tuple[float, float], area: float) -> bool:
    """Whether a mesh of a garment of this size [m] and area of all layers [m^2] can have this spacing [m]."""
    return FINEST_GIVEN <= spacing <= largest_spacing(size) and area / spacing**2 <= 0.8 * MOST_VERTICES
