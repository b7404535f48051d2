"""How high a cloth lies: its upper surface over every point of the table."""

from __future__ import annotations

import numpy as np
from numba import njit
from scipy.ndimage import maximum_filter

PIXEL = 0.001
"""Resolution of the map [m]."""
NANOMETRES = 9
"""Heights are told to so many decimals of a metre, so that a flat layer is flat to the last bit."""


class Surface:
    """The upper surface of a cloth as a map of heights."""

    def __init__(self, points: np.ndarray, faces: np.ndarray, thickness: float, reach: float) -> None:
        """Map a cloth.

        Args:
            points: Positions of its mid-surface [m], shape (n, 3).
            faces: Triangles, shape (m, 3).
            thickness: Of the cloth [m]; its surface lies half of it above the mid-surface.
            reach: A point beside the cloth counts as on it when this near [m].
        """
        self._low = points[:, :2].min(axis=0) - reach - 2 * PIXEL
        self._shape = np.ceil((points[:, :2].max(axis=0) + reach + 2 * PIXEL - self._low) / PIXEL).astype(int)
        corners = np.column_stack([(points[:, :2] - self._low) / PIXEL, points[:, 2]])
        heights = _highest(np.ascontiguousarray(corners), faces, self._shape[0], self._shape[1])
        beside = maximum_filter(heights, size=2 * round(reach / PIXEL) + 1)
        self._heights = np.where(np.isfinite(heights), heights, beside) + 0.5 * thickness

    def height(self, points: np.ndarray) -> np.ndarray:
        """Height of the surface at points of shape (k, 2) [m], shape (k,); 0 where there is only the table."""
        column, row = np.floor((points - self._low) / PIXEL).astype(int).T
        inside = (column >= 0) & (row >= 0) & (column < self._shape[0]) & (row < self._shape[1])
        heights = np.full(len(points), -np.inf)
        heights[inside] = self._heights[column[inside], row[inside]]
        return np.where(np.isfinite(heights), heights.round(NANOMETRES), 0.0)


@njit(cache=True)
def _highest(points, faces, columns, rows):  # type: ignore[no-untyped-def]
    """Largest z of all triangles over the centre of each pixel, -inf where there is none."""
    heights = np.full((columns, rows), -np.inf)
    for t in range(faces.shape[0]):
        a, b, c = faces[t, 0], faces[t, 1], faces[t, 2]
        ax, ay, bx, by, cx, cy = points[a, 0], points[a, 1], points[b, 0], points[b, 1], points[c, 0], points[c, 1]
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if abs(area) < 1e-9:
            continue
        for i in range(int(min(ax, bx, cx)), int(max(ax, bx, cx)) + 1):
            for j in range(int(min(ay, by, cy)), int(max(ay, by, cy)) + 1):
                v = ((i + 0.5 - ax) * (cy - ay) - (j + 0.5 - ay) * (cx - ax)) / area
                w = ((bx - ax) * (j + 0.5 - ay) - (by - ay) * (i + 0.5 - ax)) / area
                if v >= -1e-9 and w >= -1e-9 and v + w <= 1.0 + 1e-9:
                    z = points[a, 2] + v * (points[b, 2] - points[a, 2]) + w * (points[c, 2] - points[a, 2])
                    heights[i, j] = max(heights[i, j], z)
    return heights
