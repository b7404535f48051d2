"""Grasp candidates: the vertices that a hand may grasp.

They lie on the edge of the garment, on the side that the fold moves, and are ordered from the garment's corner inwards.
"""

from __future__ import annotations

import numpy as np

from tatamu.base.errors import InputError
from tatamu.folding.ideal import FoldLine
from tatamu.folding.plan import AUTO, Step
from tatamu.garments import Garment

HAND_CLEARANCE = 0.06
"""Least distance between the grasps of the two hands [m]. At this distance, the hands do not cross or touch."""
NEAREST = 0.5
"""Least distance between a grasp and the fold line.

The unit is the largest distance between the grasped edge and the fold line.
"""
SAME_PLACE = 0.4
"""Largest horizontal distance of two vertices that count as one above the other, in edge lengths of the mesh.

If vertices lie above each other, fingers hold all of them.
"""


def candidates(garment: Garment, state: np.ndarray, line: FoldLine, step: Step, hands: int) -> tuple[np.ndarray, ...]:
    """Return the vertices that the left hand and the right hand may grasp: M for each hand, shape (M,).

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
        names = [farthest_edge(garment, state, line) if name == AUTO else name for name in step.grasp]
        raise InputError(
            f"hands: two hands {clearance:g} m apart do not fit on {' and '.join(names)}; give hands = 1 in this step "
            "of a plan file, or --hands 1"
        )
    return left[:count], right[:count]


def distances(garment: Garment, state: np.ndarray, line: FoldLine) -> dict[str, float]:
    """Return the mean distance between each edge of the garment and the fold line [m], by the name of the edge.

    The edges are those on the side that the fold moves. Only the part of an edge that hands can grasp counts.
    """
    parts = {name: _moving(garment, state, line, name) for name in garment.edges}
    return {name: float(-line.split(state[part])[0].mean()) for name, part in parts.items() if len(part)}


def farthest_edge(garment: Garment, state: np.ndarray, line: FoldLine) -> str:
    """Return the name of the edge on the moving side whose mean distance from the fold line is largest.

    Raises:
        InputError: If no edge lies on the moving side.
    """
    far = distances(garment, state, line)
    if not far:
        raise InputError("fold: no edge of the garment lies on the moving side of the fold line")
    return max(far, key=lambda name: far[name])


def _edge(garment: Garment, state: np.ndarray, line: FoldLine, name: str) -> np.ndarray:
    """Return the vertices of a named edge of the garment on the moving side of the fold.

    Vertices below another vertex of the edge are omitted.
    """
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
    """Return the vertices of a garment's edge, from the corner inwards.

    The corner is the vertex that is farthest from the fold line and farthest to the side of the hand, left or right.
    """
    across, along = line.split(state[edge])
    return edge[np.argsort(across - side * along, kind="stable")]


def _apart(left: np.ndarray, right: np.ndarray, clearance: float) -> int:
    """Return the largest number of grasp candidates per hand with which both hands always keep a least distance.

    The least distance is `clearance` [m].
    """
    count = min(len(left), len(right))
    distance = np.linalg.norm(left[:count, None, :2] - right[None, :count, :2], axis=2)
    while count and distance[:count, :count].min() < clearance - 1e-9:
        count -= 1
    return count
