"""The ideal fold of a cloth as it lies: what moves is mirrored over the line, on top of what stays.

The stack at a place and the stack that is laid upon it are one stack of height H on average, bent round the line: its
mid-surface is the crease of least energy of that thickness (see `crease`), and a layer at height z before the fold runs
beside it at the distance d = z - H/2, inside the loop where d > 0. Far from the line that is the stack turned over,
z -> 2H - z, and at the line no layer touches another; lengths there change by the factor 1 - d * curvature.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tatamu.folding.crease import Crease, crease
from tatamu.folding.layers import Surface
from tatamu.garments import Garment

STACKS = (0.5, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 32.0, 48.0)
"""Heights of stacks in thicknesses for which creases are computed; between them they are interpolated."""


@dataclass(frozen=True)
class Line:
    """A straight fold line on the table, and which side of it moves."""

    origin: np.ndarray
    """A point of the line [m], shape (2,)."""
    normal: np.ndarray
    """Unit vector across the line, from the moving side to the side that stays, shape (2,)."""

    @property
    def along(self) -> np.ndarray:
        """Unit vector along the line, to the left of `normal`: the left hand is farther this way."""
        return np.array([-self.normal[1], self.normal[0]])

    def split(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distance from the line, negative on the moving side, and place along it [m], shapes (n,)."""
        offset = points[:, :2] - self.origin
        return offset @ self.normal, offset @ self.along

    def join(self, across: np.ndarray, along: np.ndarray) -> np.ndarray:
        """Points of given distance from the line and place along it, shape (n, 2)."""
        return self.origin + across[:, None] * self.normal + along[:, None] * self.along


@dataclass(frozen=True)
class Stack:
    """How high a cloth lies at its own vertices and where they are mirrored to."""

    own: np.ndarray
    """Upper surface over each vertex [m], shape (n,)."""
    opposite: np.ndarray
    """Upper surface over each vertex's mirror image [m], shape (n,); 0 on the bare table."""

    @property
    def mean(self) -> np.ndarray:
        """H: half of what both make together [m], shape (n,)."""
        return 0.5 * (self.own + self.opposite)


def stack(garment: Garment, state: np.ndarray, line: Line) -> Stack:
    """The stacks of a garment as it lies, `state` of shape (n, 3)."""
    surface = Surface(state, garment.faces, garment.material.thickness, 0.5 * garment.spacing)
    across, along = line.split(state)
    return Stack(surface.height(state[:, :2]), surface.height(line.join(-across, along)))


def ideal_fold(garment: Garment, state: np.ndarray, line: Line, stacks: Stack) -> np.ndarray:
    """The wanted shape after a fold [m], shape (n, 3), of a garment that lies as `state`, shape (n, 3)."""
    across, along = line.split(state)
    height = stacks.mean
    x, z = _bent(garment, height, across, state[:, 2] - 0.5 * height)
    return np.column_stack([line.join(x, along), z])


def crease_of(garment: Garment, height: float) -> Crease:
    """The crease of a stack of that height [m]."""
    return crease(garment.material.bending_length, height)


def _bent(garment: Garment, height: np.ndarray, u: np.ndarray, d: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """X and z of points at arc lengths u and distances d from the middle of stacks of given heights, shapes (n,)."""
    grid = np.array(STACKS) * garment.material.thickness
    held = np.clip(height, grid[0], grid[-1])
    lower = np.clip(np.searchsorted(grid, held, side="right") - 1, 0, len(grid) - 2)
    share = (held - grid[lower]) / (grid[lower + 1] - grid[lower])
    x, z = np.zeros(len(u)), np.zeros(len(u))
    for number, thickness in enumerate(grid):
        weight = np.where(lower == number, 1.0 - share, np.where(lower + 1 == number, share, 0.0))
        if weight.any():
            along_x, along_z = crease_of(garment, float(thickness)).place(u)
            across_x, across_z = crease_of(garment, float(thickness)).normals(u)
            x += weight * (along_x + d * across_x)
            z += weight * (along_z + d * across_z)
    return x, z + (height - held) * np.where(u < 0, 1.5, 0.5)
