"""Functions that build parts of the scenes for checks."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tatamu.simulation.mesh.topology import Topology, areas, lumped
from tatamu.simulation.scene import Cloth, Gripper
from tests.physics.meshes import Mesh


def held(vertices: np.ndarray | Sequence[int]) -> Gripper:
    """Return a hand that holds vertices without motion from the start to the end."""
    return Gripper(vertices=[int(v) for v in vertices], times=[0.0], displacements=[[0.0, 0.0, 0.0]])


def flat(mesh: Mesh, height: float = 0.0) -> Cloth:
    """Return a level cloth from a mesh. The cloth starts without strain."""
    return Cloth(vertices=raised(mesh[0], height), faces=mesh[1])


def hanging(plan: np.ndarray) -> np.ndarray:
    """Return n flat points, shape (n, 2), as points in the y-z plane [m], shape (n, 3).

    The x axis of the flat points becomes the direction straight down.
    """
    return np.column_stack([0 * plan[:, 0], plan[:, 1], -plan[:, 0]])


def raised(plan: np.ndarray, height: float = 0.0) -> np.ndarray:
    """Return n flat points, shape (n, 2), as points at one height [m], shape (n, 3)."""
    return np.column_stack([plan, np.full(len(plan), height)])


def upright(mesh: Mesh) -> Cloth:
    """Return a cloth in the x-z plane that starts without strain. Its width is vertical."""
    points, faces = mesh
    return Cloth(vertices=np.column_stack([points[:, 0], 0 * points[:, 0], points[:, 1]]), faces=faces)


def on_incline(plan: np.ndarray, distance: float, tilt: float) -> np.ndarray:
    """Return n flat points as points on a table that is tilted about y, shape (n, 3).

    The points are at `distance` above the table, along its normal.
    """
    down = np.array([np.cos(tilt), 0.0, -np.sin(tilt)])
    normal = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    return plan[:, :1] * down + plan[:, 1:] * [0.0, 1.0, 0.0] + distance * normal


def joined(parts: Sequence[tuple[np.ndarray, np.ndarray]]) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
    """Join meshes to one mesh. Return its vertices, its faces, and the vertices of each part."""
    starts = np.cumsum([0] + [len(vertices) for vertices, _ in parts])
    faces = np.concatenate([faces + start for start, (_, faces) in zip(starts, parts, strict=False)])
    members = [np.arange(starts[k], starts[k + 1]) for k in range(len(parts))]
    return np.concatenate([vertices for vertices, _ in parts]), faces, members


def sewn(mesh: Mesh, gap: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Make two layers of a mesh that are sewn together, like the body of a shirt.

    The layers have the distance `gap` [m], and are joined along both long sides.

    Returns:
        The n vertices [m], shape (n, 3), with the lower layer at z = 0; the m triangles, shape (m, 3); and the s edges
        at seams, shape (s, 2).
    """
    plan, faces = mesh
    side = (plan[:, 1] < 1e-9) | (plan[:, 1] > plan[:, 1].max() - 1e-9)
    upper = np.where(side, np.arange(len(plan)), len(plan) - 1 + np.cumsum(~side))
    vertices = np.concatenate([raised(plan, 0.0), raised(plan[~side], gap)])
    vertices[: len(plan)][side, 2] = 0.5 * gap
    border = Topology(faces).border
    return vertices, np.concatenate([faces[:, ::-1], upper[faces]]), border[side[border].all(axis=1)]


def vertex_areas(rest: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return a third of the unstrained area of the triangles around each vertex [m^2], shape (n,)."""
    return lumped(areas(rest, faces), faces, len(rest))
