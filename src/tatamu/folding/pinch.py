"""A pinch: which vertices fingers hold under their pads, and how layers move that the fingers press together."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

BESIDE, FARTHER_OUT = 0.55, 0.1
"""Two vertices of a layer form a row across the edge of the cloth if their distance along the edge is below the first
and across it above the second limit, in spacings of the mesh."""
SAME_PLACE = 0.55
"""Maximum horizontal distance of vertices that lie one above the other, in edge lengths of the mesh."""
APART = 1.05
"""Distance between layers that fingers press together, in thicknesses of the cloth."""
NOTICEABLE = 1.0
"""Minimum displacement of a pressed vertex, in thicknesses of the cloth; with less it does not move."""


def outermost(across: np.ndarray, along: np.ndarray, links: np.ndarray, spacing: float) -> np.ndarray:
    """Return which of k vertices under a finger pad are held, shape (k,): the outermost row of each layer.

    The cloth turns about this row. On fine meshes a pad covers a second row, which would also fix the slope of the
    cloth: hands do not turn, so they would lay the moving side down with a hem turned up, which jumps when the hands
    open.

    `across` [m] is lower for outer vertices, and `links`, shape (e, 2), join the vertices of a layer.
    """
    count = len(across)
    graph = coo_array((np.ones(len(links)), (links[:, 0], links[:, 1])), shape=(count, count))
    _, layer = connected_components(graph, directed=False)
    behind = (layer[:, None] == layer[None, :]) & (np.abs(along[:, None] - along[None, :]) < BESIDE * spacing)
    behind &= across[None, :] < across[:, None] - FARTHER_OUT * spacing
    return np.asarray(~behind.any(axis=1))


def pressed(points: np.ndarray, thickness: float, spacing: float) -> np.ndarray:
    """Return the upward displacements of k vertices between closing fingers [m], shape (k,), never positive.

    Every vertex moves down onto the layers below it: one above two others stops two thicknesses above the lowest.
    Layers that already lie flat on each other do not move. The vertices are `points` [m], shape (k, 3).
    """
    height = points[:, 2]
    beside = np.linalg.norm(points[:, None, :2] - points[None, :, :2], axis=2) < SAME_PLACE * spacing
    under = (beside & (height[None, :] < height[:, None] - 0.5 * thickness)).sum(axis=1)
    moved = np.minimum(height.min() + APART * thickness * under - height, 0.0)
    return np.where(moved < -NOTICEABLE * thickness, moved, 0.0)
