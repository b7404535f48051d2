"""Triangle meshes of rigid bodies and of tubes around paths, which pictures and the replay draw."""

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
    meshes = []
    for body in bodies:
        points, faces = solid(body)
        positions, orientations = body.path(times)
        turned = np.stack([points @ rotation(orientation).T for orientation in orientations])
        meshes.append((turned + positions[:, None], faces))
    return together(*meshes)


def together(*meshes: MovingMesh | None) -> MovingMesh | None:
    """Join several moving meshes to one; None if no mesh is given."""
    given = [mesh for mesh in meshes if mesh is not None]
    if not given:
        return None
    starts = np.cumsum([0] + [points.shape[1] for points, _ in given])
    faces = [faces + start for start, (_, faces) in zip(starts, given, strict=False)]
    return np.concatenate([points for points, _ in given], axis=1), np.concatenate(faces)


def tube(path: np.ndarray, radius: float, sides: int = 10) -> tuple[np.ndarray, np.ndarray]:
    """Return the points [m], shape (k, 3), and the triangles, shape (m, 3), of a tube around a path, shape (f, 3).

    A line in a picture needs a width and a light side.
    """
    path = _spaced(path, radius)
    along = np.gradient(path, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    # The direction must never be along the path. A hand stays near the vertical plane through the ends of its path,
    # so the direction is across this plane.
    span = path[-1] - path[0]
    side = np.cross(along, [-span[1], span[0], 0.0] if np.hypot(span[0], span[1]) > radius else [0.0, 1.0, 0.0])
    side /= np.maximum(np.linalg.norm(side, axis=1, keepdims=True), 1e-9)
    angles = 2 * np.pi * np.arange(sides) / sides
    ring = np.cos(angles)[:, None, None] * side + np.sin(angles)[:, None, None] * np.cross(side, along)
    points = (path + radius * ring).transpose(1, 0, 2).reshape(-1, 3)
    return points, _bands(len(path), sides)


def _spaced(path: np.ndarray, apart: float) -> np.ndarray:
    """Return those points of a path that are at least `apart` [m] away from the previously returned point."""
    kept = [path[0]]
    for place in path[1:]:
        if np.linalg.norm(place - kept[-1]) >= apart:
            kept.append(place)
    return np.array(kept if len(kept) > 1 else [path[0], path[0] + [apart, 0.0, 0.0]])


def _bands(count: int, sides: int) -> np.ndarray:
    """Return the triangles of a tube, which connect neighbouring rings of points around the path, and face outwards."""
    first = np.arange(sides)
    after = (first + 1) % sides
    band = np.vstack(
        [np.column_stack([first, after, first + sides]), np.column_stack([after, after + sides, first + sides])]
    )
    return np.vstack([band + ring * sides for ring in range(count - 1)])
