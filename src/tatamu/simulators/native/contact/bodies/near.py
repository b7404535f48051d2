"""Broad phase of bodies: which vertices, edges and faces are near each of them.

Candidates are searched with a margin, and again once cloth and bodies together may have used it up. Faces are compared
with a body as boxes in the frame of the body; edges and vertices are those of the faces that are near.
"""

from __future__ import annotations

import numpy as np

from tatamu.simulators.native.compiled import kernel
from tatamu.simulators.native.contact.bodies.state import Bodies, Near, Pose
from tatamu.simulators.native.contact.projection import Positions
from tatamu.simulators.native.contact.state import ContactMesh

MARGIN = 0.01
"""Candidates are this much farther than those in contact, at most [m]."""
WEAR = 0.8
"""They are searched again once this part of the margin may be used up [-]."""


@kernel
def _longest_motion(x: np.ndarray, start: np.ndarray) -> float:
    """The longest way of a vertex between two sets of positions [m]."""
    square = 0.0
    for v in range(x.shape[0]):
        dx = x[v, 0] - start[v, 0]
        dy = x[v, 1] - start[v, 1]
        dz = x[v, 2] - start[v, 2]
        square = max(square, dx * dx + dy * dy + dz * dz)
    return np.sqrt(square)


@kernel
def _body_motion(bodies: Bodies, before: Pose, after: Pose) -> float:
    """A bound on the way of any point on or near a body between two poses [m]."""
    longest = 0.0
    for b in range(bodies.radius.shape[0]):
        half = bodies.half[b]
        away = bodies.radius[b] + 2.0 * MARGIN
        away += np.sqrt(half[0] * half[0] + half[1] * half[1] + half[2] * half[2])
        moved = 0.0
        turned = 0.0
        for k in range(3):
            moved += (after.position[b, k] - before.position[b, k]) ** 2
            for j in range(3):
                turned += (after.rotation[b, k, j] - before.rotation[b, k, j]) ** 2
        longest = max(longest, np.sqrt(moved) + away * np.sqrt(turned))
    return longest


@kernel
def refresh(positions: Positions, mesh: ContactMesh, bodies: Bodies) -> None:
    """Search candidates again, at the start of the round, if they are worn out."""
    near = bodies.near
    worn = _longest_motion(positions.x, near.searched_at) + _body_motion(bodies, near.searched_pose, bodies.end)
    if worn <= WEAR * MARGIN:
        return
    moves = _longest_motion(positions.x, positions.start) + _body_motion(bodies, bodies.start, bodies.end)
    near.searched_at[:] = positions.start
    near.searched_pose.position[:] = bodies.start.position
    near.searched_pose.rotation[:] = bodies.start.rotation
    marked = np.zeros(mesh.inverse_mass.shape[0], dtype=np.bool_)
    edge_marked = np.zeros(mesh.edges.shape[0], dtype=np.bool_)
    for b in range(bodies.radius.shape[0]):
        reach = bodies.radius[b] + 0.5 * mesh.thickness + MARGIN + moves
        _to_local(positions.start, bodies.start.rotation[b], bodies.start.position[b], near.local)
        _search(mesh, near, b, bodies.half[b], reach, marked, edge_marked)


@kernel
def _to_local(x: np.ndarray, rotation: np.ndarray, position: np.ndarray, local: np.ndarray) -> None:
    """All positions in the frame of a body."""
    for v in range(x.shape[0]):
        dx = x[v, 0] - position[0]
        dy = x[v, 1] - position[1]
        dz = x[v, 2] - position[2]
        for k in range(3):
            local[v, k] = rotation[0, k] * dx + rotation[1, k] * dy + rotation[2, k] * dz


@kernel
def _search(
    mesh: ContactMesh,
    near: Near,
    b: int,
    half: np.ndarray,
    reach: float,
    marked: np.ndarray,
    edge_marked: np.ndarray,
) -> None:
    """List the faces whose boxes in the frame of body b reach into its box, and their edges and vertices, in order."""
    local = near.local
    marked[:] = False
    edge_marked[:] = False
    count = 0
    for t in range(mesh.faces.shape[0]):
        i, j, m = mesh.faces[t, 0], mesh.faces[t, 1], mesh.faces[t, 2]
        apart = False
        for k in range(3):
            far = half[k] + reach
            low = min(local[i, k], local[j, k], local[m, k])
            high = max(local[i, k], local[j, k], local[m, k])
            apart |= low > far or high < -far
        if apart:
            continue
        near.faces[b, count] = t
        count += 1
        for k in range(3):
            marked[mesh.faces[t, k]] = True
            edge_marked[mesh.face_edges[t, k]] = True
    near.counts[b, 0] = _list(marked, near.vertices[b])
    near.counts[b, 1] = _list(edge_marked, near.edges[b])
    near.counts[b, 2] = count


@kernel
def _list(marked: np.ndarray, out: np.ndarray) -> int:
    """List what is marked; how much it is."""
    count = 0
    for i in range(marked.shape[0]):
        if marked[i]:
            out[count] = i
            count += 1
    return count
