"""A pinch: the vertices that fingers hold under their pads, and how they press layers together as they close."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

BESIDE, FARTHER_OUT = 0.55, 0.1
"""Of two vertices of a layer that are less than the first part of a cell apart along the edge, only the outer one is
held, if it is farther out by more than the second."""
SAME_PLACE = 0.55
"""Vertices nearer than this many cells, seen from above, lie over or under one another."""
APART = 1.05
"""Pressed layers are this many thicknesses apart."""
NOTICEABLE = 1.0
"""A vertex that would be pressed down by less than this many thicknesses stays as it lies."""


def outermost(across: np.ndarray, along: np.ndarray, links: np.ndarray, spacing: float) -> np.ndarray:
    """Which vertices under a finger pad are held: of every layer its outermost row, about which the cloth turns.

    A second row, which only fine meshes have under a pad, would hold the slope of the cloth as well: hands do not turn,
    so the flap would be laid down with its hem turned up, and jump when they open.

    Args:
        across: Where the vertices are across the fold line [m], the less the farther out, shape (k,).
        along: Where they are along it [m], shape (k,).
        links: Edges of the mesh between them, shape (e, 2); what hangs together is one layer.
        spacing: Of the mesh [m].

    Returns:
        Shape (k,).
    """
    count = len(across)
    graph = coo_array((np.ones(len(links)), (links[:, 0], links[:, 1])), shape=(count, count))
    _, layer = connected_components(graph, directed=False)
    behind = (layer[:, None] == layer[None, :]) & (np.abs(along[:, None] - along[None, :]) < BESIDE * spacing)
    behind &= across[None, :] < across[:, None] - FARTHER_OUT * spacing
    return np.asarray(~behind.any(axis=1))


def pressed(points: np.ndarray, thickness: float, spacing: float) -> np.ndarray:
    """How far closing fingers move the cloth between them.

    A vertex comes to lie as many thicknesses over the lowest as there are vertices under it. Layers that lie flat on
    each other stay where they are.

    Args:
        points: The vertices under the finger pad [m], shape (k, 3).
        thickness: Of the cloth [m].
        spacing: Of its mesh [m].

    Returns:
        By how much each moves up [m], shape (k,); negative or zero, zero for the lowest.
    """
    height = points[:, 2]
    beside = np.linalg.norm(points[:, None, :2] - points[None, :, :2], axis=2) < SAME_PLACE * spacing
    under = (beside & (height[None, :] < height[:, None] - 0.5 * thickness)).sum(axis=1)
    moved = np.minimum(height.min() + APART * thickness * under - height, 0.0)
    return np.where(moved < -NOTICEABLE * thickness, moved, 0.0)
