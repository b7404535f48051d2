"""Which parts of the cloth may touch: candidate pairs, found with a grid and kept while they are sure to be complete.

Every vertex has two slots, one per side, for the nearest triangle that is not its own. Border and creased edges are
paired with all edges near them. The lists hold as long as no two parts of the cloth can have come closer by the margin.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from tatamu.simulators.native.geometry import closest_on_segments, dot, grid_cell, grid_of, normal_of, point_triangle

CREASE = 0.5
"""Cloth whose normals have a cosine below this is folded: vertices are then kept from triangles next to them."""
LEVEL = 0.7
"""Of a triangle more level with a vertex than this cosine, the plane tells on which side of the vertex it is."""
WORN = 0.8
"""Lists are rebuilt once this part of their margin may be used up."""
RIDGE = 0.94
"""Edges whose triangles' normals have a cosine below this are guarded like borders: between flatter ones an edge
cannot come through before a vertex does, unless layers are pressed together."""
PRESSED_FOR = 4
"""Rebuilds for which the edges at a pressed vertex stay guarded."""


class Mesh(NamedTuple):
    """What contact needs to know of the mesh; it never changes during a rollout."""

    faces: np.ndarray  # (m, 3)
    neighbours: np.ndarray  # (m, 3): triangle across the edge opposite each corner, -1 at a border
    near_start: np.ndarray  # (n + 1,): where a vertex's entries in `near` begin
    near: np.ndarray  # triangles within two rings of each vertex
    edges: np.ndarray  # (e, 2)
    edge_faces: np.ndarray  # (e, 2): the triangles of each edge, -1 for none
    face_edges: np.ndarray  # (m, 3)
    inverse_mass: np.ndarray  # (n,); 0 while held
    reach: np.ndarray  # (3,): thickness, margin of the lists, largest distance from centroid to corner


class Lists(NamedTuple):
    """Candidate pairs; rebuilt when parts of the cloth may have come closer by the margin."""

    face: np.ndarray  # (n, 2): triangle in each slot, -1 for none
    side: np.ndarray  # (n, 2): +1 or -1, 0 while not known
    wake: np.ndarray  # (n, 2): travelled distance at which the pair must be looked at again
    pairs: np.ndarray  # (p, 2): edge pairs
    pair_wake: np.ndarray  # (p,)
    used: np.ndarray  # (1,): edge pairs in use
    pressed: np.ndarray  # (n,): for how many rebuilds to come all edges at the vertex are guarded
    call: np.ndarray  # (1,): whether a vertex has been pressed whose edges are not yet guarded
    touched: np.ndarray  # (n,): number of the last sweep that moved the vertex noticeably
    sweeps: np.ndarray  # (1,): sweeps so far
    anchor_face: np.ndarray  # (n, 2): triangle that the vertex sticks to, -1 for none
    anchor: np.ndarray  # (n, 2, 3): where it sticks on it, barycentric
    travelled: np.ndarray  # (1,): bound on the way of any vertex against any other since the rebuild
    due: np.ndarray  # (1,): travelled distance at which the lists may be worn out
    built: np.ndarray  # (n, 3): positions that they were built at


@njit(cache=True, error_model="numpy")
def _normals(x, faces, face_normal, vertex_normal, centroid, radius):  # type: ignore[no-untyped-def]
    """Unit normals of triangles and vertices, centroids, and how far corners are from them."""
    vertex_normal[:] = 0.0
    for t in range(faces.shape[0]):
        a, b, c = faces[t, 0], faces[t, 1], faces[t, 2]
        nx, ny, nz = normal_of(x, a, b, c)
        length = np.sqrt(nx * nx + ny * ny + nz * nz) + 1e-30
        for k, value in enumerate((nx, ny, nz)):
            face_normal[t, k] = value / length
            centroid[t, k] = (x[a, k] + x[b, k] + x[c, k]) / 3.0
            for v in (a, b, c):
                vertex_normal[v, k] += value
        square = 0.0
        for v in (a, b, c):
            square = max(
                square,
                (x[v, 0] - centroid[t, 0]) ** 2 + (x[v, 1] - centroid[t, 1]) ** 2 + (x[v, 2] - centroid[t, 2]) ** 2,
            )
        radius[t] = np.sqrt(square)
    for v in range(vertex_normal.shape[0]):
        vertex_normal[v] /= np.sqrt(dot(vertex_normal[v], vertex_normal[v])) + 1e-30


@njit(cache=True, error_model="numpy")
def rebuild(x, mesh, lists):  # type: ignore[no-untyped-def]
    """Find the nearest triangle on either side of every vertex, and the pairs of guarded edges, at legal x."""
    n, m = x.shape[0], mesh.faces.shape[0]
    face_normal, vertex_normal, centroid = np.empty((m, 3)), np.empty((n, 3)), np.empty((m, 3))
    radius = np.empty(m)
    _normals(x, mesh.faces, face_normal, vertex_normal, centroid, radius)
    around = np.sqrt(mesh.reach[1] ** 2 + mesh.reach[2] ** 2)  # a layer at the margin has a centroid within this
    grid = grid_of(centroid, around)
    _fill_slots(x, mesh, lists, face_normal, vertex_normal, centroid, radius, grid, around * around)
    _fill_pairs(x, mesh, lists, face_normal)
    lists.travelled[0], lists.due[0], lists.call[0] = 0.0, 0.0, False
    lists.built[:] = x
    for v in range(n):
        lists.pressed[v] = max(lists.pressed[v] - 1, 0)


@njit(cache=True, error_model="numpy")
def _flat_there(t, v, is_near, face_normal, vertex_normal):  # type: ignore[no-untyped-def]
    """Whether triangle t is near v on the cloth and level with it, so that they cannot touch."""
    return is_near[t] == v and dot(face_normal[t], vertex_normal[v]) > CREASE


@njit(cache=True, error_model="numpy")
def _fill_slots(x, mesh, lists, face_normal, vertex_normal, centroid, radius, grid, around):  # type: ignore[no-untyped-def]
    """The nearest triangle on either side of each vertex; slots walk on from there.

    Nearest in distance, not by its centroid: of two layers a thickness apart, the further one may well have the nearer
    centroid, and a slot never walks from one layer to another.
    """
    faces = mesh.faces
    sorted_centroid = centroid[grid.order]
    sure = 0.3 * mesh.reach[0]
    is_near = np.full(faces.shape[0], -1)
    for v in range(x.shape[0]):
        for i in range(mesh.near_start[v], mesh.near_start[v + 1]):
            is_near[mesh.near[i]] = v
        best_below, best_above, below, above = mesh.reach[1], mesh.reach[1], -1, -1
        for s in range(2):  # what was nearest is most likely near: most others are then dismissed by their planes
            t = lists.face[v, s]
            if t >= 0:
                a, b, c = faces[t, 0], faces[t, 1], faces[t, 2]
                distance, up = point_triangle(x, v, a, b, c, vertex_normal[v])
                if up and distance < best_above and not _flat_there(t, v, is_near, face_normal, vertex_normal):
                    best_above, above = distance, t
                elif not up and distance < best_below and not _flat_there(t, v, is_near, face_normal, vertex_normal):
                    best_below, below = distance, t
        vx, vy, vz = x[v, 0], x[v, 1], x[v, 2]
        ux, uy, uz = vertex_normal[v, 0], vertex_normal[v, 1], vertex_normal[v, 2]
        i0, j0, k0 = grid_cell(x[v], grid)
        for i in range(max(i0 - 1, 0), min(i0 + 2, grid.shape[0])):
            for j in range(max(j0 - 1, 0), min(j0 + 2, grid.shape[1])):
                row = (i * grid.shape[1] + j) * grid.shape[2]
                for p in range(grid.start[row + max(k0 - 1, 0)], grid.start[row + min(k0 + 2, grid.shape[2])]):
                    dx = sorted_centroid[p, 0] - vx
                    dy = sorted_centroid[p, 1] - vy
                    dz = sorted_centroid[p, 2] - vz
                    square = dx * dx + dy * dy + dz * dz
                    if square >= around:
                        continue
                    t = grid.order[p]
                    n = face_normal[t]
                    off = n[0] * dx + n[1] * dy + n[2] * dz
                    lean = n[0] * ux + n[1] * uy + n[2] * uz
                    best = max(best_above, best_below)
                    if abs(lean) > LEVEL and abs(off) > sure:
                        best = best_above if off * lean > 0.0 else best_below
                    beside = best * best - off * off
                    if beside <= 0.0 or square - off * off > (radius[t] + np.sqrt(beside)) ** 2:
                        continue  # its plane, or its circle in that plane, is further than what is known
                    a, b, c = faces[t, 0], faces[t, 1], faces[t, 2]
                    if a == v or b == v or c == v or _flat_there(t, v, is_near, face_normal, vertex_normal):
                        continue
                    distance, up = point_triangle(x, v, a, b, c, vertex_normal[v])
                    if up and distance < best_above:
                        best_above, above = distance, t
                    elif not up and distance < best_below:
                        best_below, below = distance, t
        lists.face[v, 0], lists.face[v, 1] = below, above
        lists.side[v, :] = 0
        lists.wake[v, :] = 0.0


@njit(cache=True, error_model="numpy")
def _fill_pairs(x, mesh, lists, face_normal):  # type: ignore[no-untyped-def]
    """All edges within reach of border edges and of ridges."""
    edges, count = mesh.edges, 0
    reach = mesh.reach[0] + 0.5 * (mesh.reach[1] - mesh.reach[0])
    guarded, middle = np.zeros(edges.shape[0], dtype=np.bool_), np.empty((edges.shape[0], 3))
    for e in range(edges.shape[0]):
        f, g = mesh.edge_faces[e, 0], mesh.edge_faces[e, 1]
        guarded[e] = g < 0 or dot(face_normal[f], face_normal[g]) < RIDGE
        guarded[e] |= lists.pressed[edges[e, 0]] > 0 or lists.pressed[edges[e, 1]] > 0
        for k in range(3):
            middle[e, k] = 0.5 * (x[edges[e, 0], k] + x[edges[e, 1], k])
    around = reach + 1.74 * mesh.reach[2]  # two half edges: the longest edge is this part of the largest radius
    grid = grid_of(middle, 0.5 * around)
    sorted_middle = middle[grid.order]
    for e in range(edges.shape[0]):
        if not guarded[e]:
            continue
        a, b = edges[e, 0], edges[e, 1]
        mx, my, mz = middle[e, 0], middle[e, 1], middle[e, 2]
        i0, j0, k0 = grid_cell(middle[e], grid)
        for i in range(max(i0 - 2, 0), min(i0 + 3, grid.shape[0])):
            for j in range(max(j0 - 2, 0), min(j0 + 3, grid.shape[1])):
                row = (i * grid.shape[1] + j) * grid.shape[2]
                for p in range(grid.start[row + max(k0 - 2, 0)], grid.start[row + min(k0 + 3, grid.shape[2])]):
                    dx = sorted_middle[p, 0] - mx
                    dy = sorted_middle[p, 1] - my
                    dz = sorted_middle[p, 2] - mz
                    if dx * dx + dy * dy + dz * dz > around * around:
                        continue
                    o = grid.order[p]
                    c, d = edges[o, 0], edges[o, 1]
                    if (guarded[o] and o <= e) or a == c or a == d or b == c or b == d:
                        continue
                    if count < lists.pairs.shape[0] and closest_on_segments(x, a, b, c, d)[0] < reach:
                        lists.pairs[count, 0], lists.pairs[count, 1] = e, o
                        lists.pair_wake[count] = 0.0
                        count += 1
    lists.used[0] = count


@njit(cache=True, error_model="numpy")
def _relative_motion(x, before):  # type: ignore[no-untyped-def]
    """A bound on how far any two vertices moved against each other: the diagonal of the box of all displacements."""
    square = 0.0
    for k in range(3):
        low, high = np.inf, -np.inf
        for v in range(x.shape[0]):
            d = x[v, k] - before[v, k]
            low, high = min(low, d), max(high, d)
        square += (high - low) ** 2
    return np.sqrt(square)


@njit(cache=True, error_model="numpy")
def refresh(x, before, mesh, lists):  # type: ignore[no-untyped-def]
    """Count the motion from `before` to x; rebuild the lists at the legal positions `before` if they are worn out.

    They are when two vertices may have come closer by the margin since they were built: what swings to and fro counts
    as travelled, but does not wear them out.
    """
    motion, limit = _relative_motion(x, before), mesh.reach[1] - 1.5 * mesh.reach[0]
    lists.travelled[0] += motion
    if not lists.call[0]:
        if lists.travelled[0] <= lists.due[0]:
            return
        away = _relative_motion(x, lists.built)
        if away < WORN * limit:
            lists.due[0] = lists.travelled[0] + limit - away
            return
    rebuild(before, mesh, lists)
    lists.travelled[0] = motion
    lists.due[0] = limit
