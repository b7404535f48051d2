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
    edges = Topology(scene.cloth.faces).edges
    return scene.model_copy(
        update={
            "cloth": _cloth(scene.cloth, edges),
            "grippers": [_gripper(gripper, edges, len(scene.cloth.vertices)) for gripper in scene.grippers],
        }
    )


def _cloth(cloth: Cloth, edges: np.ndarray) -> Cloth:
    rest = cloth.rest_vertices
    return Cloth(
        vertices=_with_middles(cloth.vertices, edges),
        faces=_quartered(cloth.faces, edges, len(cloth.vertices)),
        rest_vertices=None if rest is None else _with_middles(rest, edges),
        seams=_seams(cloth.seams, edges, len(cloth.vertices)),
        fibre=cloth.fibre if cloth.fibre is None or len(cloth.fibre) == 1 else np.tile(cloth.fibre, (4, 1)),
    )


def _with_middles(points: np.ndarray, edges: np.ndarray) -> np.ndarray:
    return np.concatenate([points, points[edges].mean(axis=1)])


def _middles(pairs: np.ndarray, edges: np.ndarray, count: int) -> np.ndarray:
    """Return the indices of the middles of edges, given as pairs of vertices, among all `edges` in lexical order."""
    key = np.array([count, 1])
    return count + np.searchsorted(edges @ key, np.sort(pairs, axis=1) @ key)


def _quartered(faces: np.ndarray, edges: np.ndarray, count: int) -> np.ndarray:
    a, b, c = faces.T
    ab, bc, ca = (_middles(faces[:, pair], edges, count) for pair in ([0, 1], [1, 2], [2, 0]))
    corners = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.concatenate([np.column_stack(corner) for corner in corners])


def _seams(seams: np.ndarray, edges: np.ndarray, count: int) -> np.ndarray:
    middle = _middles(seams, edges, count)
    return np.concatenate([np.column_stack([seams[:, 0], middle]), np.column_stack([middle, seams[:, 1]])])


def _gripper(gripper: Gripper, edges: np.ndarray, count: int) -> Gripper:
    inside = np.isin(edges, gripper.vertices).all(axis=1)
    return gripper.model_copy(update={"vertices": [*gripper.vertices, *(count + np.flatnonzero(inside)).tolist()]})
