"""Grasp candidates: vertices of the garment's edge on the moving side, ordered from the corner inwards."""

from __future__ import annotations

import numpy as np

from tatamu.errors import InputError
from tatamu.folding.ideal import FoldLine
from tatamu.folding.plan import AUTO, Step
from tatamu.garments import Garment

HAND_CLEARANCE = 0.06
"""Least distance between the grasps of the two hands [m]. At this distance, the hands do not cross or touch."""
NEAREST = 0.5
"""Least distance between a grasp and the fold line. The unit is the distance between the farthest vertex of the grasped
edge and the fold line."""
SAME_PLACE = 0.4
"""Largest horizontal distance between vertices that lie over each other, in spacings of the mesh.

Fingers hold all of these vertices.
"""


def candidates(garment: Garment, state: np.ndarray, line: FoldLine, step: Step, hands: int) -> tuple[np.ndarray, ...]:
    """Return the grasp candidates of the left hand and of the right hand: M vertices for each, shape (M,).

    The two arrays are equal if one hand folds.

    Raises:
        InputError: If the named edge is not on the moving side, or the hands do not fit on it.
    """
    edges = [_edge(garment, state, line, name) for name in step.grasp]
    _, along = line.split(state)
    if hands == 1:
        only = _ordered(state, line, edges[0], 1.0)
        return only, only
    clearance = max(HAND_CLEARANCE, 2.7 * garment.spacing)  # on coarse meshes, the two pinches must not share a vertex
    if len(edges) == 1:
        middle = 0.5 * (along[edges[0]].min() + along[edges[0]].max())
        place = along[edges[0]] - middle
        edges = [edges[0][place >= clearance / 2], edges[0][place <= -clearance / 2]]
    left, right = (_ordered(state, line, edge, side) for edge, side in zip(edges, (1.0, -1.0), strict=True))
    count = _apart(state[left], state[right], clearance)
    if not count:
        raise InputError(f"size: two hands {clearance:g} m apart do not fit on the edge {' and '.join(step.grasp)}")
    return left[:count], right[:count]


def distances(garment: Garment, state: np.ndarray, line: FoldLine) -> dict[str, float]:
    """Return the mean distance from the line of each edge on the moving side [m].

    Only the part of an edge that hands can grasp counts.
    """
    parts = {name: _moving(garment, state, line, name) for name in garment.edges}
    return {name: float(-line.split(state[part])[0].mean()) for name, part in parts.items() if len(part)}


def farthest_edge(garment: Garment, state: np.ndarray, line: FoldLine) -> str:
    """Return the edge on the moving side whose mean distance from the line is largest.

    Raises:
        InputError: If no edge lies on the moving side.
    """
    far = distances(garment, state, line)
    if not far:
        raise InputError("fold: no edge of the garment lies on the moving side of the fold line")
    return max(far, key=lambda name: far[name])


def _edge(garment: Garment, state: np.ndarray, line: FoldLine, name: str) -> np.ndarray:
    """Return the vertices of a named edge on the moving side. Vertices below another vertex of the edge are omitted."""
    if name == AUTO:
        return _moving(garment, state, line, farthest_edge(garment, state, line))
    if name not in garment.edges:
        raise InputError(f"grasp: must be one of {', '.join(garment.edges)} or {AUTO}, given {name!r}")
    moving = _moving(garment, state, line, name)
    if not len(moving):
        raise InputError(f"grasp: no part of the edge {name!r} lies on the moving side of the fold line")
    return moving


def _moving(garment: Garment, state: np.ndarray, line: FoldLine, name: str) -> np.ndarray:
    edge = np.unique(garment.edges[name])
    away = -line.split(state[edge])[0]
    if not (away > 0).any():
        return edge[:0]
    edge = edge[away >= NEAREST * away.max()]
    return _uppermost(state, edge, SAME_PLACE * garment.spacing)


def _uppermost(state: np.ndarray, vertices: np.ndarray, apart: float) -> np.ndarray:
    """Return the vertices in their given order, without vertices that lie below another of these vertices."""
    kept: list[int] = []
    for vertex in vertices[np.argsort(-state[vertices, 2], kind="stable")]:
        if not (np.linalg.norm(state[kept, :2] - state[vertex, :2], axis=1) < apart).any():
            kept.append(int(vertex))
    return np.sort(np.array(kept))


def _ordered(state: np.ndarray, line: FoldLine, edge: np.ndarray, side: float) -> np.ndarray:
    """Return the vertices of an edge, from the corner inwards.

    The corner is the vertex that is farthest from the line and farthest to the hand's own side.
    """
    across, along = line.split(state[edge])
    return edge[np.argsort(across - side * along, kind="stable")]


def _apart(left: np.ndarray, right: np.ndarray, clearance: float) -> int:
    """Return the largest number of candidates per hand for which the hands are always at least `clearance` apart."""
    count = min(len(left), len(right))
    distance = np.linalg.norm(left[:count, None, :2] - right[None, :count, :2], axis=2)
    while count and distance[:count, :count].min() < clearance - 1e-9:
        count -= 1
    return count
