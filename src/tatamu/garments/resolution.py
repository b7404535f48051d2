"""Chooses the default edge length ("spacing") of a garment's mesh, and defines limits of sizes and spacings."""

from __future__ import annotations

import numpy as np

from tatamu.base.errors import InputError
from tatamu.simulation.material import Material

CELLS_PER_BENDING_LENGTH = 2.0
"""Ratio of a material's bending length to the default spacing.

Folds are accurate if the spacing is at most 0.55 bending lengths (docs/theory/bending.md).
"""
PASSABLE = 0.65
"""Largest mesh spacing (edge length) at which folds are still passable, in bending lengths of the material.

The source is docs/theory/bending.md.
"""
COARSEST, FINEST = 0.02, 0.004
"""Largest and smallest mesh spacing (edge length) that is chosen from the material's bending length [m]."""
FINEST_GIVEN = 1e-3
"""Smallest mesh spacing (edge length) that the user may give [m]."""
SMALLEST_SIDE, LARGEST_SIDE = 0.05, 5.0
MOST_VERTICES = 50_000
MOST_BY_DEFAULT = 3_000
"""Approximate largest number of vertices of a garment's mesh, in all layers, with the default spacing.

With more vertices, a study would take longer than minutes.
"""
CELL = np.sqrt(0.75)
"""Area per vertex of a mesh of equilateral triangles, divided by the square of the edge length."""


def spacing_for(material: Material) -> float:
    """Return the mesh spacing that resolves the folds of a material [m]."""
    return float(np.clip(material.bending_length / CELLS_PER_BENDING_LENGTH, FINEST, COARSEST))


def default_spacing(material: Material, area: float) -> float:
    """Return the default spacing of a garment's mesh [m].

    This spacing resolves the folds of the material. The spacing is larger if the mesh would otherwise have too many
    vertices. The number of vertices follows from the area of all layers, `area` [m^2].
    """
    return max(spacing_for(material), float(np.sqrt(area / CELL / MOST_BY_DEFAULT)))


def check_size(size: tuple[float, float]) -> None:
    """Refuse a width and length [m] that no garment has.

    Raises:
        InputError: If the width or the length is out of range.
    """
    for name, side in zip(("width", "length"), size, strict=True):
        if not SMALLEST_SIDE <= side <= LARGEST_SIDE:
            raise InputError(f"size: {name} must be from {SMALLEST_SIDE:g} to {LARGEST_SIDE:g} m, given {side:g} m")


def check_spacing(spacing: float, size: tuple[float, float], area: float) -> None:
    """Refuse a spacing [m] that is too large or too small for a garment's mesh.

    The limits depend on the size [m] and on the area of all layers [m^2].

    Raises:
        InputError: If the spacing is too large or too small.
    """
    if not FINEST_GIVEN <= spacing <= largest_spacing(size):
        raise InputError(
            f"spacing: must be from {FINEST_GIVEN:g} m to a quarter of the shorter side ({largest_spacing(size):g} m), "
            f"given {spacing:g} m"
        )
    if not spacing_is_possible(spacing, size, area):
        raise InputError(f"spacing: {spacing:g} m makes more than {MOST_VERTICES} vertices; give a larger one")


def largest_spacing(size: tuple[float, float]) -> float:
    """Return the largest possible mesh spacing of a garment of this width and length [m]."""
    return min(size) / 4.0


def spacing_is_possible(spacing: float, size: tuple[float, float], area: float) -> bool:
    """Return whether a garment's mesh can have this spacing [m].

    The answer depends on the garment's size [m] and on the area of all layers [m^2].
    """
    return FINEST_GIVEN <= spacing <= largest_spacing(size) and area / spacing**2 <= 0.8 * MOST_VERTICES
