"""Converts rigid bodies to triangle meshes, which pictures and the replay draw."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tatamu.simulation.body import Body, rotation

MovingMesh = tuple[np.ndarray, np.ndarray]
"""A mesh that moves: positions of the vertices at each frame [m], shape (f, n, 3), and triangles, shape (m, 3)."""


def solid(body: Body) -> tuple[np.ndarray, np.ndarray]:
    """Return the surface of a rigid body in its frame, as points [m] and triangles that share no points."""
    import trimesh.creation

    if body.shape == "box":
        mesh = trimesh.creation.box(extents=2.0 * body.core)
    elif body.shape == "sphere":
        mesh = trimesh.creation.icosphere(subdivisions=3, radius=body.radius)
    else:
        mesh = trimesh.creation.capsule(height=2.0 * body.core[2], radius=body.radius, count=[24, 24])
        mesh.apply_translation(-mesh.bounds.mean(axis=0))
    corners = np.asarray(mesh.vertices)[mesh.faces]  # faces of a box share no points, because its edges must look sharp
    return corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3)


def moving(bodies: Sequence[Body], times: np.ndarray) -> MovingMesh | None:
    """Return all rigid bodies of a scene as one mesh, with a frame for each time [s]; None if there are none."""
    parts = []
    faces = []
    count = 0
    for body in bodies:
        points, own = solid(body)
        positions, orientations = body.path(times)
        turned = np.stack([points @ rotation(orientation).T for orientation in orientations])
        parts.append(turned + positions[:, None])
        faces.append(own + count)
        count += len(points)
    return (np.concatenate(parts, axis=1), np.concatenate(faces)) if parts else None


def together(*meshes: MovingMesh | None) -> MovingMesh | None:
    """Join several moving meshes to one; None if no mesh is given."""
    given = [mesh for mesh in meshes if mesh is not None]
    if not given:
        return None
    starts = np.cumsum([0] + [points.shape[1] for points, _ in given])
    faces = [faces + start for start, (_, faces) in zip(starts, given, strict=False)]
    return np.concatenate([points for points, _ in given], axis=1), np.concatenate(faces)
