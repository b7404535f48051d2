"""The ideal fold of a cloth: one side is mirrored over the fold line, on top of the side that stays.

A fold lays one stack of cloth on another. Both are treated as one stack of mean height H that is bent round the fold
line, whose mid-surface has the shape of minimum energy for a strip of thickness H (`simulation.heavy_strip.crease`). A
layer at height z before the fold is parallel to this mid-surface at the distance d = z - H/2, inside the loop if d > 0.
Far from the line, the stack is thus turned over: z becomes 2H - z. Near it, lengths change by 1 - d * curvature.

There are two simplifications. The loops at earlier folds are pressed: their height above the stack of flat layers is
multiplied by `KEPT`. The slope of H is at most 0.3, because cloth does not hang straight down from an edge.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tatamu.folding.layers import PIXEL, Surface
from tatamu.folding.layout import FoldLine, Layout
from tatamu.garments import Garment
from tatamu.simulation.heavy_strip import Crease, crease
from tatamu.simulation.mesh.topology import areas

KEPT = 0.5
"""Fraction of its height above flat layers that the loop at an earlier fold keeps when it is pressed."""


@dataclass(frozen=True)
class Stack:
    """Heights of a cloth before a fold, with earlier loops pressed, and of the stack that the fold makes."""

    middle: np.ndarray
    """Height of the mid-surface at each vertex before the fold [m], shape (n,)."""
    under: np.ndarray
    """Height of the upper surface at each vertex's mirror image [m], shape (n,); 0 on the bare table."""
    mean: np.ndarray
    """H: half the height of the stack that a vertex belongs to after the fold [m], shape (n,)."""
    creased: np.ndarray
    """How much the crease bends the cloth, shape (n,): 1 where cloth crosses the fold line beside the vertex, 0 far
    from such cloth, as between trouser legs."""


def stack(layout: Layout) -> Stack:
    """Return the heights of a garment before a fold, and of the stack that the fold makes."""
    garment, state, line = layout.garment, layout.state, layout.line
    thickness = garment.material.thickness
    reach = 0.5 * garment.spacing
    area = float(areas(garment.unstrained, garment.faces).sum())
    layers = np.ceil(area / Surface.of(state, garment.faces, thickness, reach).area)
    middle = pressed(state[:, 2], layers * thickness)
    surface = Surface.of(np.column_stack([state[:, :2], middle]), garment.faces, thickness, reach)

    def together(points: np.ndarray) -> np.ndarray:
        """Return the heights of both sides at points of the moving side, added [m]; 0 elsewhere."""
        own = surface.height(points)
        across = line.split(points)[0]
        return np.where((own > 0) & (across < PIXEL), own + surface.height(line.mirrored(points)), 0.0)

    mirrored = line.mirrored(state[:, :2])
    moving = (line.split(state)[0] < 0)[:, None]
    both = surface.mapped(together, 0.3).height(np.where(moving, state[:, :2], mirrored))
    creased = _creased(surface, line, state, 3.5 * garment.material.bending_length)
    return Stack(middle, surface.height(mirrored), 0.5 * both, creased)


def _creased(surface: Surface, line: FoldLine, state: np.ndarray, fade: float) -> np.ndarray:
    """Return `Stack.creased`, which depends on the coordinate along the fold line and falls to 0 over `fade` [m]."""
    along = line.split(state)[1]
    places = np.arange(along.min(), along.max() + PIXEL, PIXEL)
    crossing = places[surface.height(line.join(np.zeros(len(places)), places)) > 0]
    if not len(crossing):
        return np.zeros(len(state))
    after = np.clip(np.searchsorted(crossing, along), 1, max(len(crossing) - 1, 1))
    nearest = np.minimum(np.abs(along - crossing[after - 1]), np.abs(along - crossing[after % len(crossing)]))
    return 1.0 - np.clip((nearest - PIXEL) / fade, 0.0, 1.0)


def pressed(z: np.ndarray, flat: float) -> np.ndarray:
    """Return heights [m] whose part above `flat` [m] is multiplied by `KEPT`. Their order does not change."""
    return np.where(z <= flat, z, flat + KEPT * (z - flat))


def ideal_fold(layout: Layout, stacks: Stack) -> np.ndarray:
    """Return the target shape of a fold [m], shape (n, 3)."""
    garment, (across, along) = layout.garment, layout.split()
    x, z = _bent(garment, stacks.mean, across, stacks.middle - 0.5 * stacks.mean)
    flat_z = np.where(across < 0, 2.0 * stacks.mean - stacks.middle, stacks.middle)
    x = stacks.creased * x + (1.0 - stacks.creased) * np.abs(across)
    z = stacks.creased * z + (1.0 - stacks.creased) * flat_z
    target = np.column_stack([layout.line.join(x, along), z])
    alone = (across > crease_of(garment, garment.material.thickness).arc[-1]) & (stacks.under == 0)
    target[alone] = layout.state[alone]  # no other cloth presses the loops of these vertices
    return target


def crease_of(garment: Garment, height: float) -> Crease:
    """Return the shape of the crease of a stack of a height [m]."""
    return crease(garment.material.bending_length, height)


def _bent(garment: Garment, height: np.ndarray, u: np.ndarray, d: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return x and z [m], shapes (n,), of points at arc lengths u and distances d from bent stacks' mid-surfaces.

    They are interpolated between the creases of stacks of a few heights.
    """
    stacks = np.array([0.5, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 32.0, 48.0])
    grid = stacks * garment.material.thickness
    held = np.clip(height, grid[0], grid[-1])
    lower = np.clip(np.searchsorted(grid, held, side="right") - 1, 0, len(grid) - 2)
    share = (held - grid[lower]) / (grid[lower + 1] - grid[lower])
    x = np.zeros(len(u))
    z = np.zeros(len(u))
    for number, thickness in enumerate(grid):
        weight = np.where(lower == number, 1.0 - share, np.where(lower + 1 == number, share, 0.0))
        if weight.any():
            along_x, along_z = crease_of(garment, float(thickness)).place(u)
            across_x, across_z = crease_of(garment, float(thickness)).normals(u)
            x += weight * (along_x + d * across_x)
            z += weight * (along_z + d * across_z)
    return x, z + (height - held) * np.where(u < 0, 1.5, 0.5)
