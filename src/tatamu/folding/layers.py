"""Height of the upper surface of a cloth over every point of the table."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numba import njit
from scipy.ndimage import maximum_filter

from tatamu.simulation.mesh.zbuffer import z_buffer

PIXEL = 0.001
"""Width of a pixel in the map of heights [m]."""


class Surface:
    """A map of the heights of a surface over the table."""

    def __init__(self, low: np.ndarray, heights: np.ndarray) -> None:
        """Make a map from heights [m], shape (columns, rows), with the first pixel's corner [m], shape (2,)."""
        self._low = low
        self._heights = heights

    @classmethod
    def of(cls, points: np.ndarray, faces: np.ndarray, thickness: float, reach: float) -> Surface:
        """Return the upper surface of a cloth, half a thickness above its mid-surface `points` [m], shape (n, 3).

        A point beside the cloth counts as on it up to the distance `reach` [m].
        """
        low = points[:, :2].min(axis=0) - reach - 2 * PIXEL
        size = np.ceil((points[:, :2].max(axis=0) + reach + 2 * PIXEL - low) / PIXEL).astype(int)
        corners = np.column_stack([(points[:, :2] - low) / PIXEL, points[:, 2]])
        heights = z_buffer(corners, faces, (size[0], size[1]), 1e-9).heights  # with this slack there are no gaps
        beside = maximum_filter(heights, size=2 * round(reach / PIXEL) + 1)
        heights = np.where(np.isfinite(heights), heights, beside) + 0.5 * thickness
        # in whole nanometres, so that a flat layer has exactly equal heights
        return cls(low, np.where(np.isfinite(heights), heights.round(9), 0.0))

    @property
    def area(self) -> float:
        """Area of the table that the cloth covers [m^2]."""
        return float((self._heights > 0.0).sum()) * PIXEL**2

    def height(self, points: np.ndarray) -> np.ndarray:
        """Return the heights at k points, shape (k, 2), as shape (k,) [m]; 0 on the bare table."""
        column, row = np.floor((points - self._low) / PIXEL).astype(int).T
        inside = (column >= 0) & (row >= 0) & (column < self._heights.shape[0]) & (row < self._heights.shape[1])
        heights = np.zeros(len(points))
        heights[inside] = self._heights[column[inside], row[inside]]
        return heights

    def mapped(self, height: Callable[[np.ndarray], np.ndarray], slope: float) -> Surface:
        """Return a surface with the heights of a function, raised where it would be steeper than `slope`.

        The function takes the centres of k pixels, shape (k, 2), and returns their heights [m], shape (k,).
        """
        index = np.indices(self._heights.shape).reshape(2, -1).T
        heights = height(self._low + (index + 0.5) * PIXEL).reshape(self._heights.shape)
        return Surface(self._low, _gentle(np.ascontiguousarray(heights), slope * PIXEL))


@njit(cache=True)
def _gentle(heights, fall):  # type: ignore[no-untyped-def]
    """Raise pixels until none is lower than a neighbour by more than `fall`; two sweeps suffice, as for distances."""
    columns, rows = heights.shape
    for sweep in range(2):
        for a in range(columns):
            i = a if sweep == 0 else columns - 1 - a
            for b in range(rows):
                j = b if sweep == 0 else rows - 1 - b
                before = -1 if sweep == 0 else 1
                for di, dj in ((before, -1), (before, 0), (before, 1), (0, before)):
                    if 0 <= i + di < columns and 0 <= j + dj < rows:
                        distance = 1.4142135623730951 if di != 0 and dj != 0 else 1.0
                        heights[i, j] = max(heights[i, j], heights[i + di, j + dj] - distance * fall)
    return heights
