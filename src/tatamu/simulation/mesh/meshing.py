"""Triangle meshes in the plane: staggered rows, on which cloth bends best (docs/theory/bending.md), and Delaunay.

A scene's mesh is subdivided at the middles of its edges. The vertices that were there before come first.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import Delaunay

from tatamu.simulation.mesh.topology import Topology, twice_areas
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Cloth, Gripper, Scene

ROW = np.sqrt(0.75)
"""Distance between the rows of an equilateral triangle mesh [edges]."""
SHEAR = 0.25
"""Shift of even rows to the left and of odd rows to the right [cells]. If only odd rows were shifted, half triangles at
the sides would slow down an explicit simulator."""
SLIVER = 1e-3
"""Minimum ratio of twice a triangle's area to a square cell; Delaunay makes thinner triangles at straight sides."""


def staggered_rectangle(width: float, length: float, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a nearly equilateral mesh of a centred rectangle at z = 0, with rows along y and upward normals."""
    columns = max(3, round(width / spacing))
    rows = max(4, round(length / (width / columns * np.sqrt(0.75))))
    rows += rows % 2  # with an even number, a row lies on the line of a half fold
    r, c = np.meshgrid(np.arange(rows + 1), np.arange(columns + 1), indexing="ij")
    shift = np.where((c > 0) & (c < columns), np.where(r % 2 == 0, -SHEAR, SHEAR), 0.0)
    x = (r / rows - 0.5) * length
    y = ((c + shift) / columns - 0.5) * width
    number = r * (columns + 1) + c
    a = number[:-1, :-1].ravel()
    b = number[1:, :-1].ravel()
    even = (r[:-1, :-1] % 2 == 0).ravel()[:, None]
    first = np.where(even, np.column_stack([a, b, a + 1]), np.column_stack([a, b, b + 1]))
    second = np.where(even, np.column_stack([b, b + 1, a + 1]), np.column_stack([a, b + 1, a + 1]))
    vertices = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    return vertices, np.stack([first, second], axis=1).reshape(-1, 3)


def delaunay(points: np.ndarray, joined: np.ndarray | None = None) -> np.ndarray:
    """Return the counter-clockwise Delaunay triangles of points, triangulated at the positions `joined` if given."""
    faces = Delaunay(points if joined is None else joined).simplices.astype(np.int64)
    clockwise = twice_areas(points, faces) < 0
    faces[clockwise] = faces[clockwise][:, ::-1]
    return faces


def subdivided(scene: Scene, times: int = 1) -> Scene:
    """Return a scene with every edge halved `times` times; a hand that holds both ends of an edge holds its middle."""
    for _ in range(times):
        scene = _halved(scene)
    return scene


def before_subdivision(rollout: Rollout, faces: np.ndarray) -> Rollout:
    """Return the rollout of a subdivided mesh at the vertices of the original mesh, whose triangles are `faces`."""
    return Rollout(rollout.times, rollout.positions[:, : faces.max() + 1], faces, rollout.info)


def _halved(scene: Scene) -> Scene:
    cloth, count = scene.cloth, len(scene.cloth.vertices)
    edges = Topology(cloth.faces).edges
    a, b, c = cloth.faces.T
    ab, bc, ca = (_middles(cloth.faces[:, pair], edges, count) for pair in ([0, 1], [1, 2], [2, 0]))
    corners = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    seam = _middles(cloth.seams, edges, count)
    finer = Cloth(
        vertices=_with_middles(cloth.vertices, edges),
        faces=np.concatenate([np.column_stack(corner) for corner in corners]),
        rest_vertices=None if cloth.rest_vertices is None else _with_middles(cloth.rest_vertices, edges),
        seams=np.concatenate([np.column_stack([cloth.seams[:, 0], seam]), np.column_stack([seam, cloth.seams[:, 1]])]),
        fibre=cloth.fibre if cloth.fibre is None or len(cloth.fibre) == 1 else np.tile(cloth.fibre, (4, 1)),
    )
    grippers = [_gripper(gripper, edges, count) for gripper in scene.grippers]
    return scene.model_copy(update={"cloth": finer, "grippers": grippers})


def _with_middles(points: np.ndarray, edges: np.ndarray) -> np.ndarray:
    return np.concatenate([points, points[edges].mean(axis=1)])


def _middles(pairs: np.ndarray, edges: np.ndarray, count: int) -> np.ndarray:
    """Return the indices of the middles of edges, given as pairs of vertices, among all `edges` in lexical order."""
    key = np.array([count, 1])
    return count + np.searchsorted(edges @ key, np.sort(pairs, axis=1) @ key)


def _gripper(gripper: Gripper, edges: np.ndarray, count: int) -> Gripper:
    inside = np.isin(edges, gripper.vertices).all(axis=1)
    return gripper.model_copy(update={"vertices": [*gripper.vertices, *(count + np.flatnonzero(inside)).tolist()]})
