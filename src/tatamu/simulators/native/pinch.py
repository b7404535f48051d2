"""Layers that changed places in a pinch, when it opens.

A hand keeps the arrangement of what it holds, while the cloth beside it may turn over, as a hem does when the garment
is folded: the layers then lie in one order in the pinch and in the other beside it. Real cloth leaves a tongue as deep
as the fingers and turns around it; on a mesh the pinch may be a single row of vertices, which has no depth. When the
hand opens, such layers change places, a way of about a thickness.
"""

from __future__ import annotations

import numpy as np

from tatamu.simulators.native import nearest

REACH = 3.0
"""Vertices farther apart than so many thicknesses are not layers of one pinch."""


def restore_order(x: np.ndarray, held: np.ndarray, faces: np.ndarray, edges: np.ndarray, thickness: float) -> bool:
    """Let vertices that a hand lets go change places where layers lie the other way round beside the pinch.

    Args:
        x: Positions [m], shape (n, 3); changed in place.
        held: The vertices, shape (k,).
        faces: Triangles, shape (m, 3).
        edges: Edges, shape (e, 2).
        thickness: Of the cloth [m].

    Returns:
        Whether any was moved.
    """
    beside, known = _beside(x, held, edges)
    vertices, beside = held[known], beside[known]
    if not len(vertices):
        return False
    normal = nearest.normals(x, faces)[1][vertices]
    pairs = _layers(x, vertices, edges, REACH * thickness)
    directions = _across(normal, pairs)
    moved = 0
    for _ in vertices:  # as in a bubble sort: each pass exchanges neighbours in the stack
        changed = sum(_exchange(x, vertices[p], beside[p], across) for p, across in zip(pairs, directions, strict=True))
        moved += changed
        if not changed:
            break
    return moved > 0


def _across(normal: np.ndarray, pairs: np.ndarray) -> np.ndarray:
    """Unit vectors across the layers of each pair, shape (p, 3), from normals of vertices, shape (k, 3).

    A vertex on a seam that is folded flat has a normal in the plane of the layers: there the hand's main normal counts.
    """
    hand = np.linalg.eigh(normal.T @ normal)[1][:, -1]
    one, other = normal[pairs[:, 0]], normal[pairs[:, 1]]
    across = one + other * np.copysign(1.0, (one * other).sum(axis=1))[:, None]
    across /= np.linalg.norm(across, axis=1)[:, None]
    across[np.abs(across @ hand) < 0.5] = hand
    return across


def _exchange(x: np.ndarray, pair: np.ndarray, beside: np.ndarray, across: np.ndarray) -> bool:
    """Exchange the heights of two vertices if the cloth beside them lies in the other order; whether it was done."""
    height, wanted = (x[pair[1]] - x[pair[0]]) @ across, (beside[1] - beside[0]) @ across
    if height * wanted >= 0.0:
        return False
    x[pair[0]] += height * across
    x[pair[1]] -= height * across
    return True


def _beside(x: np.ndarray, held: np.ndarray, edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean position of each vertex's neighbours that are not held, shape (k, 3); which have any, shape (k,)."""
    row = np.full(len(x), -1)
    row[held] = np.arange(len(held))
    total, count = np.zeros((len(held), 3)), np.zeros(len(held))
    for one, other in (edges.T, edges.T[::-1]):
        free = (row[one] >= 0) & (row[other] < 0)
        np.add.at(total, row[one[free]], x[other[free]])
        np.add.at(count, row[one[free]], 1.0)
    return total / np.maximum(count, 1.0)[:, None], count > 0


def _layers(x: np.ndarray, vertices: np.ndarray, edges: np.ndarray, reach: float) -> np.ndarray:
    """Pairs of vertices within reach of each other that share no edge, as indices into `vertices`, shape (p, 2)."""
    points = x[vertices]
    near = [np.flatnonzero(((points[i + 1 :] - point) ** 2).sum(axis=1) < reach**2) for i, point in enumerate(points)]
    pairs = np.array([(i, i + 1 + j) for i, others in enumerate(near) for j in others]).reshape(-1, 2).astype(int)
    ends = np.sort(vertices[pairs], axis=1)
    return pairs[~np.isin(ends @ [len(x), 1], edges @ [len(x), 1])]
