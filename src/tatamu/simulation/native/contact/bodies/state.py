"""Rigid bodies as arrays. `place` writes the poses of each round, and the module `near` writes the candidates."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from tatamu.simulation.body import Body
from tatamu.simulation.native.compiled import kernel
from tatamu.simulation.native.contact.projection import Positions
from tatamu.simulation.native.contact.state import ContactMesh
from tatamu.simulation.scene import Gripper

CORNERS = 8
"""Maximum number of corners of a body's core, a box, a segment or a point."""


class Pose(NamedTuple):
    """The poses of the b bodies at one instant."""

    rotation: np.ndarray
    """Rotation from the frame of each body to the world, shape (b, 3, 3)."""
    position: np.ndarray
    """Centre of each body [m], shape (b, 3)."""


class Candidates(NamedTuple):
    """Indices of vertices, edges and faces near each of the b bodies, shapes (b, n), (b, e) and (b, m)."""

    vertices: np.ndarray
    edges: np.ndarray
    faces: np.ndarray
    counts: np.ndarray
    """Counts of vertices, edges and faces that are in use in each row, shape (b, 3)."""


class Near(NamedTuple):
    """Candidates, and the positions of cloth and bodies at the search for them."""

    wide: Candidates
    """Elements within a margin around each body, kept over many rounds."""
    narrow: Candidates
    """Elements that may touch a body in the present round, chosen from `wide`."""
    searched_at: np.ndarray
    """Positions of the n vertices at the last search [m], shape (n, 3); not finite before the first search."""
    searched_pose: Pose
    positions: Positions
    """Positions in a membrane step, up to date only for vertices near a body."""
    local: np.ndarray
    """Temporary: positions in the frame of a body at the end of the round [m], shape (n, 3)."""
    local0: np.ndarray
    """Temporary: positions in the frame of a body at the start of the round [m], shape (n, 3)."""


class Bodies(NamedTuple):
    """All b bodies of a scene; b may be zero."""

    half: np.ndarray
    """Half sizes of the core of each body [m], shape (b, 3)."""
    radius: np.ndarray
    """Radius r of each body [m], shape (b,)."""
    friction: np.ndarray
    """Coulomb coefficient of cloth on the body [-], shape (b,)."""
    corners: np.ndarray
    """Corners of each core in the frame of the body [m], shape (b, CORNERS, 3)."""
    corner_count: np.ndarray
    """Number of corners of each core, shape (b,): 1 for a sphere, 2 for a capsule, 8 for a box."""
    positions: np.ndarray
    """Centre of each body at the beginning of each outer step [m], shape (b, steps + 1, 3)."""
    orientations: np.ndarray
    """Unit quaternion (w, x, y, z) of each body at the beginning of each outer step, shape (b, steps + 1, 4)."""
    held: np.ndarray
    """Whether the hand of each body holds each vertex at any time, shape (b, n).

    A body does not collide with triangles at vertices that its hand holds."""
    start: Pose
    """Poses at the start of the round."""
    end: Pose
    """Poses at the end of the round."""
    near: Near


def bodies_of(
    bodies: Sequence[Body], grippers: Sequence[Gripper], outer_step: float, steps: int, mesh: ContactMesh
) -> Bodies:
    """Return the bodies of a scene as arrays over `steps` outer steps, with memory for candidates."""
    count = len(bodies)
    times = np.arange(steps + 1) * outer_step
    positions = np.empty((count, steps + 1, 3))
    orientations = np.empty((count, steps + 1, 4))
    corners = np.zeros((count, CORNERS, 3))
    corner_count = np.ones(count, dtype=np.int64)
    vertices = len(mesh.inverse_mass)
    held = np.zeros((count, vertices), dtype=np.bool_)
    for number, body in enumerate(bodies):
        positions[number], orientations[number] = body.path(times)
        signs = [(-1.0, 1.0) if half > 0.0 else (0.0,) for half in body.core]
        own = np.array(list(product(*signs))) * body.core
        corners[number, : len(own)] = own
        corner_count[number] = len(own)
        for gripper in grippers:
            if body.hand is not None and gripper.hand == body.hand:
                held[number, gripper.vertices] = True
    return Bodies(
        half=np.array([body.core for body in bodies]).reshape(count, 3),
        radius=np.array([body.radius for body in bodies]).reshape(count),
        friction=np.array([body.friction for body in bodies]).reshape(count),
        corners=corners,
        corner_count=corner_count,
        positions=positions,
        orientations=orientations,
        held=held,
        start=_no_pose(count),
        end=_no_pose(count),
        near=Near(
            wide=_no_candidates(count, mesh),
            narrow=_no_candidates(count, mesh),
            searched_at=np.full((vertices, 3), np.inf),
            searched_pose=_no_pose(count),
            positions=Positions(np.zeros((vertices, 3)), np.zeros((vertices, 3)), np.zeros((vertices, 3))),
            local=np.zeros((vertices, 3)),
            local0=np.zeros((vertices, 3)),
        ),
    )


def _no_pose(count: int) -> Pose:
    return Pose(np.zeros((count, 3, 3)), np.zeros((count, 3)))


def _no_candidates(count: int, mesh: ContactMesh) -> Candidates:
    return Candidates(
        vertices=np.zeros((count, len(mesh.inverse_mass)), dtype=np.int64),
        edges=np.zeros((count, len(mesh.edges)), dtype=np.int64),
        faces=np.zeros((count, len(mesh.faces)), dtype=np.int64),
        counts=np.zeros((count, 3), dtype=np.int64),
    )


@kernel
def _set_pose(pose: Pose, b: int, position: np.ndarray, orientation: np.ndarray, number: int, fraction: float) -> None:
    """Set the pose of body b at a fraction of outer step `number`.

    Quaternions are interpolated linearly, because a body only turns by a small angle within a step.
    """
    later = min(number + 1, position.shape[0] - 1)
    for k in range(3):
        pose.position[b, k] = position[number, k] + fraction * (position[later, k] - position[number, k])
    q0 = orientation[number, 0] + fraction * (orientation[later, 0] - orientation[number, 0])
    q1 = orientation[number, 1] + fraction * (orientation[later, 1] - orientation[number, 1])
    q2 = orientation[number, 2] + fraction * (orientation[later, 2] - orientation[number, 2])
    q3 = orientation[number, 3] + fraction * (orientation[later, 3] - orientation[number, 3])
    scale = 1.0 / np.sqrt(q0 * q0 + q1 * q1 + q2 * q2 + q3 * q3)
    w, x, y, z = scale * q0, scale * q1, scale * q2, scale * q3
    rotation = pose.rotation[b]
    rotation[0, 0] = 1.0 - 2.0 * (y * y + z * z)
    rotation[0, 1] = 2.0 * (x * y - w * z)
    rotation[0, 2] = 2.0 * (x * z + w * y)
    rotation[1, 0] = 2.0 * (x * y + w * z)
    rotation[1, 1] = 1.0 - 2.0 * (x * x + z * z)
    rotation[1, 2] = 2.0 * (y * z - w * x)
    rotation[2, 0] = 2.0 * (x * z - w * y)
    rotation[2, 1] = 2.0 * (y * z + w * x)
    rotation[2, 2] = 1.0 - 2.0 * (x * x + y * y)


@kernel
def place(bodies: Bodies, number: int, begin: float, end: float) -> None:
    """Set the poses of all bodies at the start and at the end of a round of contact.

    The round begins at the fraction `begin` of outer step `number`, and ends at the fraction `end` of this step.
    """
    for b in range(bodies.radius.shape[0]):
        _set_pose(bodies.start, b, bodies.positions[b], bodies.orientations[b], number, begin)
        _set_pose(bodies.end, b, bodies.positions[b], bodies.orientations[b], number, end)
