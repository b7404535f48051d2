"""Where hands may grasp the moving edge, which vertices their fingers hold there, and how these press layers together.

Grasp candidates are the vertices that a hand may grasp, from the garment's corner inwards.
"""

from __future__ import annotations

import numpy as np

from tatamu.base.errors import InputError
from tatamu.folding.layout import Layout
from tatamu.folding.plan import AUTO
from tatamu.simulation.mesh.topology import connected

APART = 1.05
"""Distance between layers that fingers press together, in thicknesses of the cloth."""
MIN_DISTANCE = 0.5
"""Minimum distance between a grasp and the fold line, as a fraction of the grasped edge's maximum distance."""


def candidates(layout: Layout, grasp: tuple[str, ...], hands: int) -> tuple[np.ndarray, ...]:
    """Return the M vertices that the left and the right hand may grasp, shape (M,) each; equal ones for one hand.

    `grasp` names the edge for both hands, or the edges of the left and of the right hand.

    Raises:
        InputError: If the named edge is not on the moving side, or the hands do not fit on it.
    """
    edges = [_edge(layout, name) for name in grasp]
    state, (_, along) = layout.state, layout.split()
    if hands == 1:
        only = _ordered(layout, edges[0], 1.0)
        return only, only
    # at which hands neither cross nor touch, and two pinches do not share a vertex
    clearance = max(0.06, 2.7 * layout.garment.spacing)
    if len(edges) == 1:
        middle = 0.5 * (along[edges[0]].min() + along[edges[0]].max())
        place = along[edges[0]] - middle
        edges = [edges[0][place >= clearance / 2], edges[0][place <= -clearance / 2]]
    left, right = (_ordered(layout, edge, side) for edge, side in zip(edges, (1.0, -1.0), strict=True))
    count = _apart(state[left], state[right], clearance)
    if not count:
        names = [farthest_edge(layout) if name == AUTO else name for name in grasp]
        raise InputError(
            f"hands: two hands cannot grasp {' and '.join(names)}, because they must be at least {clearance:g} m "
            "apart; give --hands 1"
        )
    return left[:count], right[:count]


def distances(layout: Layout) -> dict[str, float]:
    """Return the mean distance from the fold line of the part of each edge that hands can grasp [m], by its name."""
    parts = {name: _moving(layout, name) for name in layout.garment.edges}
    return {name: float(-layout.split(part)[0].mean()) for name, part in parts.items() if len(part)}


def farthest_edge(layout: Layout) -> str:
    """Return the name of the edge on the moving side whose mean distance from the fold line is largest."""
    far = distances(layout)
    if not far:
        raise InputError("fold: the moving side must have a named edge that the hands can grasp, given none")
    return max(far, key=lambda name: far[name])


def _edge(layout: Layout, name: str) -> np.ndarray:
    if name == AUTO:
        return _moving(layout, farthest_edge(layout))
    if name not in layout.garment.edges:
        raise InputError(f"grasp: must be one of {', '.join(layout.garment.edges)} or {AUTO}, given {name!r}")
    moving = _moving(layout, name)
    if not len(moving):
        raise InputError(f"grasp: must name an edge on the moving side of the fold line, given {name!r}")
    return moving


def _moving(layout: Layout, name: str) -> np.ndarray:
    edge = np.unique(layout.garment.edges[name])
    away = -layout.split(edge)[0]
    if not (away > 0).any():
        return edge[:0]
    edge = edge[away >= MIN_DISTANCE * away.max()]
    return _uppermost(layout.state, edge, 0.4 * layout.garment.spacing)  # so near, vertices lie one above the other


def _uppermost(state: np.ndarray, vertices: np.ndarray, apart: float) -> np.ndarray:
    """Return the vertices, in their order, without those that lie below another one."""
    kept: list[int] = []
    for vertex in vertices[np.argsort(-state[vertices, 2], kind="stable")]:
        if not (np.linalg.norm(state[kept, :2] - state[vertex, :2], axis=1) < apart).any():
            kept.append(int(vertex))
    return np.sort(np.array(kept))


def _ordered(layout: Layout, edge: np.ndarray, side: float) -> np.ndarray:
    """Return the vertices of an edge from the corner inwards, on the side of the left (1) or the right hand (-1)."""
    across, along = layout.split(edge)
    return edge[np.argsort(across - side * along, kind="stable")]


def _apart(left: np.ndarray, right: np.ndarray, clearance: float) -> int:
    """Return how many candidates per hand keep the hands apart by `clearance` [m] in every pair."""
    count = min(len(left), len(right))
    distance = np.linalg.norm(left[:count, None, :2] - right[None, :count, :2], axis=2)
    while count and distance[:count, :count].min() < clearance - 1e-9:
        count -= 1
    return count


def links_within(edges: np.ndarray, vertices: np.ndarray, count: int) -> np.ndarray:
    """Return the edges between two of the given vertices, of a mesh with `count`, as indices into `vertices`."""
    place = np.full(count, -1)
    place[vertices] = np.arange(len(vertices))
    links = place[edges]
    return np.asarray(links[(links >= 0).all(axis=1)])


def outermost(across: np.ndarray, along: np.ndarray, links: np.ndarray, spacing: float) -> np.ndarray:
    """Return which of k vertices under a finger pad are held, shape (k,): the outermost row of each layer.

    The cloth turns about this row. On fine meshes a pad covers a second row, which would also fix the slope of the
    cloth: hands do not turn, so they would lay the moving side down with a hem turned up, which jumps when the hands
    open.

    `across` [m] is lower for outer vertices, and `links`, shape (e, 2), join the vertices of a layer.
    """
    layer = connected(links, len(across))
    # two vertices of a layer form a row across the edge of the cloth
    behind = (layer[:, None] == layer[None, :]) & (np.abs(along[:, None] - along[None, :]) < 0.55 * spacing)
    behind &= across[None, :] < across[:, None] - 0.1 * spacing
    return np.asarray(~behind.any(axis=1))


def pressed(points: np.ndarray, thickness: float, spacing: float) -> np.ndarray:
    """Return the upward displacements of k vertices between closing fingers [m], shape (k,), never positive.

    Every vertex moves down onto the layers below it: one above two others stops two thicknesses above the lowest.
    Layers that already lie flat on each other do not move. The vertices are `points` [m], shape (k, 3).
    """
    height = points[:, 2]
    beside = np.linalg.norm(points[:, None, :2] - points[None, :, :2], axis=2) < 0.55 * spacing
    under = (beside & (height[None, :] < height[:, None] - 0.5 * thickness)).sum(axis=1)
    moved = np.minimum(height.min() + APART * thickness * under - height, 0.0)
    return np.where(moved < -thickness, moved, 0.0)  # smaller motions do not count
