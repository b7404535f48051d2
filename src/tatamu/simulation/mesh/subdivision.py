"""Subdivision of a scene's mesh at the middles of its edges, with the vertices of the coarse mesh first."""

from __future__ import annotations

import numpy as np

from tatamu.simulation.mesh.topology import Topology
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Cloth, Gripper, Scene


def subdivided(scene: Scene, times: int = 1) -> Scene:
    """Return a scene with every edge halved `times` times; a hand that holds both ends of an edge holds its middle."""
    for _ in range(times):
        scene = _halved(scene)
    return scene


def on_coarse_mesh(rollout: Rollout, faces: np.ndarray) -> Rollout:
    """Return the rollout of a subdivided mesh at the vertices of its coarse mesh, whose triangles are `faces`."""
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
