"""A pinch: which vertices fingers hold under their pads, and how layers move that the fingers press together."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

BESIDE, FARTHER_OUT = 0.55, 0.1
"""Two limits that decide which vertices form a row across the edge of the cloth, in spacings of the mesh.

Two vertices of a layer form such a row under two conditions. Their distance along the edge is below the first limit.
Their distance across the edge is above the second limit. Of these two vertices, only the outer vertex is held.
"""
SAME_PLACE = 0.55
"""Largest horizontal distance of two vertices that count as one above the other, in edge lengths of the mesh."""
APART = 1.05
"""Distance between neighbouring layers that fingers press together, in thicknesses of the cloth."""
NOTICEABLE = 1.0
"""Smallest displacement of a vertex that closing fingers press down, in thicknesses of the cloth.

If the displacement would be smaller, the vertex does not move.
"""


def outermost(across: np.ndarray, along: np.ndarray, links: np.ndarray, spacing: float) -> np.ndarray:
    """Return which vertices under a finger pad are held. These are the outermost row of each layer.

    The cloth turns about the outermost row. On fine meshes, a pad covers a second row, too. If hands held both rows,
    they would also fix the slope of the cloth. Because hands do not turn, they would lay the moving side down with its
    hem turned up. This hem would jump when the hands open.

    Args:
        across: Distances of the k vertices from the fold line [m], shape (k,). Outer vertices have lower values.
        along: Coordinates of the vertices along the fold line [m], shape (k,).
        links: The e edges of the mesh between these vertices, shape (e, 2). Connected vertices form one layer.
        spacing: Distance between neighbouring vertices of the mesh [m].

    Returns:
        Whether each vertex is held, shape (k,).
    """
    count = len(across)
    graph = coo_array((np.ones(len(links)), (links[:, 0], links[:, 1])), shape=(count, count))
    _, layer = connected_components(graph, directed=False)
    behind = (layer[:, None] == layer[None, :]) & (np.abs(along[:, None] - along[None, :]) < BESIDE * spacing)
    behind &= across[None, :] < across[:, None] - FARTHER_OUT * spacing
    return np.asarray(~behind.any(axis=1))


def pressed(points: np.ndarray, thickness: float, spacing: float) -> np.ndarray:
    """Return the displacements of the cloth between closing fingers.

    Every vertex moves down onto the layers below it. For example, a vertex above two other vertices stops two
    thicknesses above the lowest vertex. Layers that already lie flat on each other do not move.

    Args:
        points: The k vertices under the finger pad [m], shape (k, 3).
        thickness: Thickness of the cloth [m].
        spacing: Distance between neighbouring vertices of the cloth's mesh [m].

    Returns:
        Upward displacement of each vertex [m], shape (k,). It is zero for the lowest vertex, and never positive.
    """
    height = points[:, 2]
    beside = np.linalg.norm(points[:, None, :2] - points[None, :, :2], axis=2) < SAME_PLACE * spacing
    under = (beside & (height[None, :] < height[:, None] - 0.5 * thickness)).sum(axis=1)
    moved = np.minimum(height.min() + APART * thickness * under - height, 0.0)
    return np.where(moved < -NOTICEABLE * thickness, moved, 0.0)
