"""A uniform grid of points: the spatial index of the broad phase."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tatamu.simulators.native.compiled import kernel

MOST_CELLS = 65536
"""Cells become larger rather than more, so that the grid stays in the processor's cache."""


class Grid(NamedTuple):
    """Points sorted into cells; cell (i, j, k) is number (i * shape[1] + j) * shape[2] + k."""

    origin: np.ndarray
    """Lowest corner [m], shape (3,)."""
    cell: np.ndarray
    """Sides of a cell [m], shape (3,)."""
    shape: np.ndarray
    """Cells along x, y, z, shape (3,)."""
    start: np.ndarray
    """Start of each cell in `order`, shape (cells + 1,)."""
    order: np.ndarray
    """Points by cell, shape (points,)."""


@kernel
def grid_of(points: np.ndarray, size: float) -> Grid:
    """Sort points [m], shape (p, 3), into cells of at least `size` [m], by counting."""
    origin = np.empty(3)
    cell = np.empty(3)
    shape = np.empty(3, dtype=np.int64)
    for k in range(3):
        low = points[0, k]
        high = points[0, k]
        for p in range(points.shape[0]):
            low = min(low, points[p, k])
            high = max(high, points[p, k])
        origin[k] = low
        cell[k] = size
        shape[k] = min(int((high - low) / size), MOST_CELLS) + 1
    while shape[0] * shape[1] * shape[2] > MOST_CELLS:
        k = int(np.argmax(shape))
        cell[k] *= 2.0
        shape[k] = shape[k] // 2 + 1
    start = np.zeros(shape[0] * shape[1] * shape[2] + 1, dtype=np.int64)
    order = np.empty(points.shape[0], dtype=np.int64)
    cell_of_point = np.empty(points.shape[0], dtype=np.int64)
    grid = Grid(origin, cell, shape, start, order)
    for p in range(points.shape[0]):
        i, j, k = grid_cell(points[p], grid)
        number = (i * shape[1] + j) * shape[2] + k
        cell_of_point[p] = number
        start[number + 1] += 1
    for c in range(start.shape[0] - 1):
        start[c + 1] += start[c]
    filled = start.copy()
    for p in range(points.shape[0]):
        number = cell_of_point[p]
        order[filled[number]] = p
        filled[number] += 1
    return grid


@kernel
def grid_cell(point: np.ndarray, grid: Grid) -> tuple[int, int, int]:
    """Cell of a point, clamped to the grid."""
    i = min(max(int((point[0] - grid.origin[0]) / grid.cell[0]), 0), grid.shape[0] - 1)
    j = min(max(int((point[1] - grid.origin[1]) / grid.cell[1]), 0), grid.shape[1] - 1)
    k = min(max(int((point[2] - grid.origin[2]) / grid.cell[2]), 0), grid.shape[2] - 1)
    return i, j, k


@kernel
def cells_around(
    cell: tuple[int, int, int], rings: int, column: int, shape: np.ndarray, start: np.ndarray
) -> tuple[int, int]:
    """Return the start and end in `Grid.order` of one column of the cells around a cell.

    Cells that follow one another along z lie together, so a block of 2 rings + 1 cells a side is that number squared of
    runs.

    Args:
        cell: The cell in the middle.
        rings: How many cells to look to each side.
        column: Number of the run, from 0 to (2 rings + 1)^2 - 1, by x, then y.
        shape: Numbers of cells of the grid.
        start: Starts of the grid's cells.

    Returns:
        The first place and the one behind the last; the same where the column is outside the grid.
    """
    side = 2 * rings + 1
    i = cell[0] - rings + column // side
    j = cell[1] - rings + column % side
    if i < 0 or j < 0 or i >= shape[0] or j >= shape[1]:
        return 0, 0
    row = (i * shape[1] + j) * shape[2]
    return start[row + max(cell[2] - rings, 0)], start[row + min(cell[2] + rings + 1, shape[2])]
