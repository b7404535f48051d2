"""Cloth against cloth: vertices against triangles, and border or creased edges against edges.

Every vertex has two slots, one per side, for the nearest triangle that is not its own. A slot walks from triangle to
triangle as the cloth slides, and remembers on which side of the triangle the vertex is. Positions are corrected so that
layers stay a thickness apart; the tangential part of a correction is Coulomb friction:

    W   = w_v + sum b_k^2 w_k                       inverse mass seen by the contact, barycentric b
    l_n = (target - gap) / W,   l_t = min(|slip| / W, mu l_n)

Which side a pair is on is always read off the previous, legal positions, never off the moved ones.
Derived in docs/native.md.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from tatamu.simulators.native.geometry import (
    closest_on_segments,
    cross,
    dot,
    grid_cell,
    grid_of,
    normal_of,
)

INSIDE = -0.02
"""A barycentric coordinate above this counts as inside the triangle."""
CLEARING_SPEED, RECOVERY_SPEED = 0.5, 0.1
"""Layers that begin a step too close come apart at the first of these speeds [m/s], but keep no more than the second:
what begins in a tangle does not explode."""
CREASE = 0.5
"""Edges whose triangles' normals have a cosine below this are guarded like borders."""
EDGE_GAP = 0.75
"""Edges keep this part of a thickness; vertices against triangles keep the whole."""
DEEP = 0.5
"""Pairs closer than this part of what they should keep are swept again."""


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
    travelled: np.ndarray  # (1,): bound on the motion of any vertex against any other since the rebuild


@njit(cache=True, error_model="numpy")
def _normals(x, faces, face_normal, vertex_normal, centroid):  # type: ignore[no-untyped-def]
    """Unit normals of triangles and vertices, and centroids."""
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
    for v in range(vertex_normal.shape[0]):
        vertex_normal[v] /= np.sqrt(dot(vertex_normal[v], vertex_normal[v])) + 1e-30


@njit(cache=True, error_model="numpy")
def rebuild(x, mesh, lists):  # type: ignore[no-untyped-def]
    """Find the nearest triangle on either side of every vertex, and the pairs of guarded edges, at legal x."""
    n, m = x.shape[0], mesh.faces.shape[0]
    face_normal, vertex_normal, centroid = np.empty((m, 3)), np.empty((n, 3)), np.empty((m, 3))
    _normals(x, mesh.faces, face_normal, vertex_normal, centroid)
    around = np.sqrt(mesh.reach[1] ** 2 + mesh.reach[2] ** 2)  # a layer at the margin has a centroid within this
    grid = grid_of(centroid, around)
    _fill_slots(x, mesh, lists, face_normal, vertex_normal, centroid, grid, around * around)
    _fill_pairs(x, mesh, lists, face_normal, grid)
    lists.travelled[0] = 0.0


@njit(cache=True, error_model="numpy")
def _fill_slots(x, mesh, lists, face_normal, vertex_normal, centroid, grid, around):  # type: ignore[no-untyped-def]
    """The triangle with the nearest centroid on either side of each vertex; slots walk on from there."""
    faces = mesh.faces
    sorted_centroid = centroid[grid.order]
    is_near = np.full(faces.shape[0], -1)
    for v in range(x.shape[0]):
        for i in range(mesh.near_start[v], mesh.near_start[v + 1]):
            is_near[mesh.near[i]] = v
        best_below, best_above, below, above = around, around, -1, -1
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
                    if square >= best_above and square >= best_below:
                        continue
                    t = grid.order[p]
                    up = dx * ux + dy * uy + dz * uz > 0.0
                    if square >= (best_above if up else best_below):
                        continue
                    if is_near[t] == v:
                        if faces[t, 0] == v or faces[t, 1] == v or faces[t, 2] == v:
                            continue
                        n = face_normal[t]
                        if n[0] * ux + n[1] * uy + n[2] * uz > CREASE:
                            continue  # the cloth is still flat there
                    if up:
                        best_above, above = square, t
                    else:
                        best_below, below = square, t
        lists.face[v, 0], lists.face[v, 1] = below, above
        lists.side[v, :] = 0
        lists.wake[v, :] = 0.0


@njit(cache=True, error_model="numpy")
def _fill_pairs(x, mesh, lists, face_normal, grid):  # type: ignore[no-untyped-def]
    """All edges within reach of border edges and of creased edges."""
    edges, count = mesh.edges, 0
    reach = mesh.reach[0] + 0.5 * (mesh.reach[1] - mesh.reach[0])
    seen = np.full(edges.shape[0], -1)
    guarded = np.zeros(edges.shape[0], dtype=np.bool_)
    for e in range(edges.shape[0]):
        f, g = mesh.edge_faces[e, 0], mesh.edge_faces[e, 1]
        guarded[e] = g < 0 or dot(face_normal[f], face_normal[g]) < CREASE
    middle = np.empty(3)
    for e in range(edges.shape[0]):
        if not guarded[e]:
            continue
        a, b = edges[e, 0], edges[e, 1]
        for k in range(3):
            middle[k] = 0.5 * (x[a, k] + x[b, k])
        i0, j0, k0 = grid_cell(middle, grid)
        for i in range(max(i0 - 2, 0), min(i0 + 3, grid.shape[0])):
            for j in range(max(j0 - 2, 0), min(j0 + 3, grid.shape[1])):
                row = (i * grid.shape[1] + j) * grid.shape[2]
                for p in range(grid.start[row + max(k0 - 2, 0)], grid.start[row + min(k0 + 3, grid.shape[2])]):
                    for q in range(3):
                        o = mesh.face_edges[grid.order[p], q]
                        if seen[o] == e or o == e or (guarded[o] and o < e):
                            continue
                        seen[o] = e
                        c, d = edges[o, 0], edges[o, 1]
                        if a == c or a == d or b == c or b == d or count == lists.pairs.shape[0]:
                            continue
                        if not _middles_within(x, c, d, middle, reach + 1.7 * mesh.reach[2]):
                            continue
                        if closest_on_segments(x, a, b, c, d)[0] < reach:
                            lists.pairs[count, 0], lists.pairs[count, 1] = e, o
                            lists.pair_wake[count] = 0.0
                            count += 1
    lists.used[0] = count


@njit(cache=True, error_model="numpy")
def _middles_within(x, c, d, middle, distance):  # type: ignore[no-untyped-def]
    square = 0.0
    for k in range(3):
        square += (0.5 * (x[c, k] + x[d, k]) - middle[k]) ** 2
    return square < distance * distance


@njit(cache=True, error_model="numpy")
def _barycentric(x, v, a, b, c):  # type: ignore[no-untyped-def]
    """Coordinates of v's projection on triangle (a, b, c), its unit normal, and v's height over it."""
    nx, ny, nz = normal_of(x, a, b, c)
    square = nx * nx + ny * ny + nz * nz + 1e-30
    px, py, pz = x[v, 0] - x[a, 0], x[v, 1] - x[a, 1], x[v, 2] - x[a, 2]
    ux, uy, uz = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
    wx, wy, wz = x[c, 0] - x[a, 0], x[c, 1] - x[a, 1], x[c, 2] - x[a, 2]
    qx, qy, qz = cross(px, py, pz, wx, wy, wz)
    rx, ry, rz = cross(ux, uy, uz, px, py, pz)
    bb = (qx * nx + qy * ny + qz * nz) / square
    bc = (rx * nx + ry * ny + rz * nz) / square
    length = np.sqrt(square)
    nx, ny, nz = nx / length, ny / length, nz / length
    return 1.0 - bb - bc, bb, bc, nx, ny, nz, nx * px + ny * py + nz * pz


@njit(cache=True, error_model="numpy")
def _height(x, v, a, b, c):  # type: ignore[no-untyped-def]
    nx, ny, nz = normal_of(x, a, b, c)
    length = np.sqrt(nx * nx + ny * ny + nz * nz) + 1e-30
    return (nx * (x[v, 0] - x[a, 0]) + ny * (x[v, 1] - x[a, 1]) + nz * (x[v, 2] - x[a, 2])) / length


@njit(cache=True, error_model="numpy")
def _pushes(gap, gap_before, thickness, step):  # type: ignore[no-untyped-def]
    """How far to push a pair apart, and the part of it that must not become velocity."""
    before = max(gap_before, 0.0)
    push = min(thickness, before + CLEARING_SPEED * step) - gap
    lasting = min(thickness, before + RECOVERY_SPEED * step) - gap
    return push, push - max(lasting, 0.0)


@njit(cache=True, error_model="numpy")
def _sweep_slots(x, before, moved, mesh, lists, friction, step, deep):  # type: ignore[no-untyped-def]
    """One pass over all slots; with `deep`, only over pairs closer than DEEP thickness. The smallest gap seen."""
    faces, thickness, inverse_mass = mesh.faces, mesh.reach[0], mesh.inverse_mass
    limit = DEEP * thickness if deep else thickness
    smallest = thickness
    for v in range(x.shape[0]):
        for s in range(2):
            t = lists.face[v, s]
            if t < 0 or lists.wake[v, s] > lists.travelled[0]:
                continue
            for _ in range(4):
                a, b, c = faces[t, 0], faces[t, 1], faces[t, 2]
                ba, bb, bc, nx, ny, nz, height = _barycentric(x, v, a, b, c)
                corner = 0 if ba <= bb and ba <= bc else (1 if bb <= bc else 2)
                lowest = min(ba, bb, bc)
                if lowest >= INSIDE:
                    break
                beyond = mesh.neighbours[t, corner]
                if beyond < 0:
                    break
                t = beyond
                if faces[t, 0] == v or faces[t, 1] == v or faces[t, 2] == v:
                    break
            if lowest < INSIDE:
                if faces[t, 0] == v or faces[t, 1] == v or faces[t, 2] == v:
                    continue
                lists.face[v, s] = t
                lists.side[v, s] = 0
                continue
            lists.face[v, s] = t
            if lists.side[v, s] == 0:
                lists.side[v, s] = 1 if _height(before, v, a, b, c) >= 0.0 else -1
            side = lists.side[v, s]
            gap = side * height
            if gap >= limit:
                if not deep and gap > 1.1 * thickness:
                    lists.wake[v, s] = lists.travelled[0] + 0.8 * (gap - thickness)
                continue
            weight = inverse_mass[v] + ba * ba * inverse_mass[a] + bb * bb * inverse_mass[b] + bc * bc * inverse_mass[c]
            if weight == 0.0:
                continue
            push, silent = _pushes(gap, side * _height(before, v, a, b, c), thickness, step)
            if push <= 0.0:
                continue
            smallest = min(smallest, gap)
            silent /= weight
            nx, ny, nz = side * nx, side * ny, side * nz
            sx = x[v, 0] - before[v, 0]
            sy = x[v, 1] - before[v, 1]
            sz = x[v, 2] - before[v, 2]
            for o, w in ((a, ba), (b, bb), (c, bc)):
                sx -= w * (x[o, 0] - before[o, 0])
                sy -= w * (x[o, 1] - before[o, 1])
                sz -= w * (x[o, 2] - before[o, 2])
            along = sx * nx + sy * ny + sz * nz
            sx, sy, sz = sx - along * nx, sy - along * ny, sz - along * nz
            slip = np.sqrt(sx * sx + sy * sy + sz * sz) + 1e-30
            held = min(1.0, friction * push / slip)
            px = (push * nx - held * sx) / weight
            py = (push * ny - held * sy) / weight
            pz = (push * nz - held * sz) / weight
            for o, w in ((v, 1.0), (a, -ba), (b, -bb), (c, -bc)):
                f = w * inverse_mass[o]
                x[o, 0] += f * px
                x[o, 1] += f * py
                x[o, 2] += f * pz
                if silent > 0.0:
                    moved[o, 0] += f * silent * nx
                    moved[o, 1] += f * silent * ny
                    moved[o, 2] += f * silent * nz
    return smallest


@njit(cache=True, error_model="numpy")
def _sweep_pairs(x, before, moved, mesh, lists, step, deep):  # type: ignore[no-untyped-def]
    """One pass over the edge pairs, pushed apart along their closest points before the step."""
    edges, inverse_mass = mesh.edges, mesh.inverse_mass
    thickness = EDGE_GAP * mesh.reach[0]
    limit = DEEP * thickness if deep else thickness
    smallest = thickness
    for p in range(lists.used[0]):
        if lists.pair_wake[p] > lists.travelled[0]:
            continue
        a, b = edges[lists.pairs[p, 0], 0], edges[lists.pairs[p, 0], 1]
        c, d = edges[lists.pairs[p, 1], 0], edges[lists.pairs[p, 1], 1]
        distance, s, t = closest_on_segments(before, a, b, c, d)
        if not deep and distance > 1.5 * thickness:
            lists.pair_wake[p] = lists.travelled[0] + 0.9 * (distance - thickness)
            if distance > 3.0 * thickness:
                continue
        if distance < 1e-9:
            continue
        wa, wb, wc, wd = 1.0 - s, s, -(1.0 - t), -t
        nx, ny, nz, gap = 0.0, 0.0, 0.0, 0.0
        nx = (wa * before[a, 0] + wb * before[b, 0] + wc * before[c, 0] + wd * before[d, 0]) / distance
        ny = (wa * before[a, 1] + wb * before[b, 1] + wc * before[c, 1] + wd * before[d, 1]) / distance
        nz = (wa * before[a, 2] + wb * before[b, 2] + wc * before[c, 2] + wd * before[d, 2]) / distance
        gap = (
            nx * (wa * x[a, 0] + wb * x[b, 0] + wc * x[c, 0] + wd * x[d, 0])
            + ny * (wa * x[a, 1] + wb * x[b, 1] + wc * x[c, 1] + wd * x[d, 1])
            + nz * (wa * x[a, 2] + wb * x[b, 2] + wc * x[c, 2] + wd * x[d, 2])
        )
        if gap >= limit:
            continue
        weight = (
            wa * wa * inverse_mass[a]
            + wb * wb * inverse_mass[b]
            + wc * wc * inverse_mass[c]
            + wd * wd * inverse_mass[d]
        )
        push, silent = _pushes(gap, distance, thickness, step)
        if weight == 0.0 or push <= 0.0:
            continue
        smallest = min(smallest, gap)
        for o, w in ((a, wa), (b, wb), (c, wc), (d, wd)):
            f = w * inverse_mass[o] / weight
            x[o, 0] += f * push * nx
            x[o, 1] += f * push * ny
            x[o, 2] += f * push * nz
            if silent > 0.0:
                moved[o, 0] += f * silent * nx
                moved[o, 1] += f * silent * ny
                moved[o, 2] += f * silent * nz
    return smallest


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
    """Count the motion from `before` to x; rebuild the lists at the legal positions `before` if they are worn out."""
    motion = _relative_motion(x, before)
    lists.travelled[0] += motion
    if lists.travelled[0] > mesh.reach[1] - 1.5 * mesh.reach[0]:
        rebuild(before, mesh, lists)
        lists.travelled[0] = motion


@njit(cache=True, error_model="numpy")
def sweep(x, before, moved, mesh, lists, friction, step, deep):  # type: ignore[no-untyped-def]
    """Push all pairs apart once, with `deep` only those that are closer than DEEP of what they should be.

    Args:
        x: Positions to correct [m], shape (n, 3).
        before: Legal positions at the start of the step [m], shape (n, 3).
        moved: Reference for the change of velocity [m], shape (n, 3); shifted by what shall not become velocity.
        mesh: The mesh.
        lists: Its candidate pairs.
        friction: Coulomb coefficient of cloth on cloth.
        step: Outer step [s].
        deep: Whether this is a second or later sweep.

    Returns:
        Whether another sweep is needed.
    """
    edge_gap = _sweep_pairs(x, before, moved, mesh, lists, step, deep)
    gap = _sweep_slots(x, before, moved, mesh, lists, friction, step, deep)
    return gap < DEEP * mesh.reach[0] or edge_gap < DEEP * EDGE_GAP * mesh.reach[0]
