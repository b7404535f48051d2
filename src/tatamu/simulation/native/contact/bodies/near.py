"""Broad phase of bodies: finds the vertices, edges and faces near each body.

*Wide* candidates lie within the contact distance plus a margin, and are searched again when cloth and bodies together
may have moved by most of this margin. *Narrow* candidates are those of them that may touch the body in one round. In
both steps, boxes around faces and edges are compared with the box around the body, in the frame of the body.
"""

from __future__ import annotations

import numpy as np

from tatamu.simulation.native.compiled import allocating, kernel
from tatamu.simulation.native.contact.bodies.push import to_frame
from tatamu.simulation.native.contact.bodies.state import Bodies, Candidates, Pose
from tatamu.simulation.native.contact.state import ContactMesh
from tatamu.simulation.native.geometry import copy, longest_displacement

MARGIN = 0.01
"""Margin of wide candidates beyond the contact distance [m]."""


@kernel
def _body_motion(bodies: Bodies, before: Pose, after: Pose) -> float:
    """Return an upper bound on the motion of any point on or near a body between two poses [m]."""
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


@allocating
def refresh(x: np.ndarray, longest_way: float, mesh: ContactMesh, bodies: Bodies) -> bool:
    """Find the candidates of a round, and return whether there are any.

    In the round, which starts at the positions x, a vertex moves by at most `longest_way` [m].
    """
    near = bodies.near
    moves = longest_way + _body_motion(bodies, bodies.start, bodies.end)
    worn = longest_displacement(x, near.searched_at) + _body_motion(bodies, near.searched_pose, bodies.start)
    search = worn + moves > 0.7 * MARGIN  # the rest allows for motion by contact
    if search:
        copy(x, near.searched_at)
        copy(bodies.start.position, near.searched_pose.position)
        for b in range(bodies.radius.shape[0]):
            copy(bodies.start.rotation[b], near.searched_pose.rotation[b])
    marked = np.zeros(mesh.inverse_mass.shape[0], dtype=np.bool_)
    if search:
        all_vertices = np.arange(mesh.inverse_mass.shape[0])
        all_edges = np.arange(mesh.edges.shape[0])
        all_faces = np.arange(mesh.faces.shape[0])
    else:
        all_vertices = all_edges = all_faces = np.empty(0, dtype=np.int64)
    found = False
    for b in range(bodies.radius.shape[0]):
        rotation = bodies.start.rotation[b]
        position = bodies.start.position[b]
        reach = bodies.radius[b] + 0.5 * mesh.thickness + moves
        wide = near.wide
        counts = wide.counts[b]
        if search:
            far = bodies.half[b] + (reach + MARGIN)
            _to_local(x, rotation, position, all_vertices, near.local)
            _filter(mesh, near.local, far, all_vertices, all_edges, all_faces, bodies.held[b], marked, b, wide)
        else:
            _to_local(x, rotation, position, wide.vertices[b, : counts[0]], near.local)
        far = bodies.half[b] + (reach + 5e-4)  # an allowance for motion beyond that by the velocities [m]
        _filter(
            mesh,
            near.local,
            far,
            wide.vertices[b, : counts[0]],
            wide.edges[b, : counts[1]],
            wide.faces[b, : counts[2]],
            bodies.held[b],
            marked,
            b,
            near.narrow,
        )
        found = found or near.narrow.counts[b, 2] > 0
    return found


@kernel
def _to_local(
    x: np.ndarray, rotation: np.ndarray, position: np.ndarray, vertices: np.ndarray, local: np.ndarray
) -> None:
    """Write the positions of vertices in the frame of a body to `local` [m]."""
    for i in range(vertices.shape[0]):
        to_frame(rotation, position, x, vertices[i], local)


@kernel
def _reaches(local: np.ndarray, a: int, b: int, c: int, far: np.ndarray) -> bool:
    """Return whether the box around three vertices overlaps the box around a body with the half sizes `far`."""
    for k in range(3):
        if min(local[a, k], local[b, k], local[c, k]) > far[k] or max(local[a, k], local[b, k], local[c, k]) < -far[k]:
            return False
    return True


@kernel
def _filter(
    mesh: ContactMesh,
    local: np.ndarray,
    far: np.ndarray,
    vertices: np.ndarray,
    edges: np.ndarray,
    faces: np.ndarray,
    held: np.ndarray,
    marked: np.ndarray,
    b: int,
    out: Candidates,
) -> None:
    """List the faces in the box around body b, with their edges and vertices, except faces at which its hand holds."""
    count = 0
    for i in range(faces.shape[0]):
        t = faces[i]
        p, q, r = mesh.faces[t, 0], mesh.faces[t, 1], mesh.faces[t, 2]
        if not (held[p] or held[q] or held[r]) and _reaches(local, p, q, r, far):
            out.faces[b, count] = t
            count += 1
            marked[p] = True
            marked[q] = True
            marked[r] = True
    out.counts[b, 2] = count
    count = 0
    for i in range(edges.shape[0]):
        p, q = mesh.edges[edges[i], 0], mesh.edges[edges[i], 1]
        if marked[p] and marked[q] and _reaches(local, p, q, q, far):
            out.edges[b, count] = edges[i]
            count += 1
    out.counts[b, 1] = count
    count = 0
    for i in range(vertices.shape[0]):
        if marked[vertices[i]]:
            marked[vertices[i]] = False
            out.vertices[b, count] = vertices[i]
            count += 1
    out.counts[b, 0] = count
