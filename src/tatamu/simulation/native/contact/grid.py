"""A uniform grid of points, with which the broad phase finds triangles that are near to each other."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tatamu.simulation.native.compiled import allocating, kernel

MAX_CELLS = 65536
"""Maximum number of cells, which then stay in the processor's cache; the cells of larger grids are enlarged."""


class Grid(NamedTuple):
    """Points sorted into cells. Cell (i, j, k) has the number (i * shape[1] + j) * shape[2] + k."""

    origin: np.ndarray
    """Corner with the smallest coordinates [m], shape (3,)."""
    cell: np.ndarray
    """Sides of a cell [m], shape (3,)."""
    shape: np.ndarray
    """Numbers of cells along x, y and z, shape (3,)."""
    start: np.ndarray
    """Index in `order` at which the points of each cell begin, shape (cells + 1,)."""
    order: np.ndarray
    """Indices of the points, sorted by cell, shape (points,)."""


@allocating
def grid_of(points: np.ndarray, size: float) -> Grid:
    """Sort points [m], shape (p, 3), into cells whose sides are at least `size` [m], by a counting sort."""
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
        shape[k] = min(int((high - low) / size), MAX_CELLS) + 1
    while shape[0] * shape[1] * shape[2] > MAX_CELLS:
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
    """Return the indices (i, j, k) of the cell of a point, or of the nearest cell for a point outside the grid."""
    i = min(max(int((point[0] - grid.origin[0]) / grid.cell[0]), 0), grid.shape[0] - 1)
    j = min(max(int((point[1] - grid.origin[1]) / grid.cell[1]), 0), grid.shape[1] - 1)
    k = min(max(int((point[2] - grid.origin[2]) / grid.cell[2]), 0), grid.shape[2] - 1)
    return i, j, k


@kernel
def cells_around(
    cell: tuple[int, int, int], rings: int, column: int, shape: np.ndarray, start: np.ndarray
) -> tuple[int, int]:
    """Return where one column of the block of cells around a cell starts and ends in `Grid.order`.

    Cells along z lie together there, so a block with 2 rings + 1 cells along each side has (2 rings + 1)^2 columns,
    counted by x, then by y. Start and end are equal outside the grid.
    """
    side = 2 * rings + 1
    i = cell[0] - rings + column // side
    j = cell[1] - rings + column % side
    if i < 0 or j < 0 or i >= shape[0] or j >= shape[1]:
        return 0, 0
    row = (i * shape[1] + j) * shape[2]
    return start[row + max(cell[2] - rings, 0)], start[row + min(cell[2] + rings + 1, shape[2])]
