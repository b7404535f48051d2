"""Cloth against cloth: vertices against triangles, and border or creased edges against edges.

Every vertex has two slots, one per side, for the nearest triangle that is not its own. A slot walks from triangle to
triangle as the cloth slides, and remembers on which side of the triangle the vertex is. Positions are corrected so that
layers stay a thickness apart; the tangential part of a correction is Coulomb friction:

    W   = w_v + sum b_k^2 w_k                       inverse mass seen by the contact, barycentric b
    l_n = (target - gap) / W,   l_t = min(|slip| / W, mu l_n)

Which side a pair is on is always read off the previous, legal positions, never off the moved ones.
Source: design.md section 5, facts/solver.md round two.
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
    point_triangle,
)

INSIDE = -0.02
"""A barycentric coordinate above this counts as inside the triangle."""
RECOVERY_SPEED = 0.1
"""Layers that start too close drift apart at this speed [m/s] instead of jumping."""
CREASE = 0.5
"""Edges whose triangles' normals have a cosine below this are guarded like borders."""
EDGE_GAP = 0.75
"""Edges keep this part of a thickness; vertices against triangles keep the whole."""
DEEP = 0.5
"""Pairs closer than this part of a thickness are swept again, at most `SWEEPS` times."""
SWEEPS = 6


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
    """Candidate pairs; rebuilt when the cloth has moved by half the margin."""

    face: np.ndarray  # (n, 2): triangle in each slot, -1 for none
    side: np.ndarray  # (n, 2): +1 or -1, 0 while not known
    wake: np.ndarray  # (n, 2): travelled distance at which the pair must be looked at again
    pairs: np.ndarray  # (p, 2): edge pairs
    pair_wake: np.ndarray  # (p,)
    count: np.ndarray  # (1,): edge pairs in use
    travelled: np.ndarray  # (1,): sum over steps of the largest motion of any vertex since the rebuild


@njit(cache=True, error_model="numpy")
def _normals(x, faces, face_normal, vertex_normal, centroid):  # type: ignore[no-untyped-def]
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


@njit(cache=True, error_model="numpy")
def rebuild(x, mesh, lists):  # type: ignore[no-untyped-def]
    """Find the nearest triangle on either side of every vertex, and the pairs of guarded edges, at legal x."""
    faces, n, m = mesh.faces, x.shape[0], mesh.faces.shape[0]
    face_normal, vertex_normal, centroid = np.empty((m, 3)), np.empty((n, 3)), np.empty((m, 3))
    _normals(x, faces, face_normal, vertex_normal, centroid)
    margin, radius = mesh.reach[1], mesh.reach[2]
    origin, cell, shape, start, order = grid_of(centroid, margin + radius)
    _fill_slots(x, mesh, lists, face_normal, vertex_normal, centroid, origin, cell, shape, start, order)
    _fill_pairs(x, mesh, lists, face_normal, centroid, origin, cell, shape, start, order)
    lists.travelled[0] = 0.0


@njit(cache=True, error_model="numpy")
def _fill_slots(x, mesh, lists, face_normal, vertex_normal, centroid, origin, cell, shape, start, order):  # type: ignore[no-untyped-def]
    faces, margin = mesh.faces, mesh.reach[1]
    around = (margin + mesh.reach[2]) ** 2
    is_near = np.full(faces.shape[0], -1)
    best = np.empty(2)
    for v in range(x.shape[0]):
        for i in range(mesh.near_start[v], mesh.near_start[v + 1]):
            is_near[mesh.near[i]] = v
        best[:] = margin
        lists.face[v, :] = -1
        i0, j0, k0 = grid_cell(x[v], origin, cell, shape)
        for i in range(max(i0 - 1, 0), min(i0 + 2, shape[0])):
            for j in range(max(j0 - 1, 0), min(j0 + 2, shape[1])):
                k_low, k_high = max(k0 - 1, 0), min(k0 + 2, shape[2])
                row = (i * shape[1] + j) * shape[2]
                for p in range(start[row + k_low], start[row + k_high]):
                    t = order[p]
                    dx, dy, dz = centroid[t, 0] - x[v, 0], centroid[t, 1] - x[v, 1], centroid[t, 2] - x[v, 2]
                    if dx * dx + dy * dy + dz * dz > around:
                        continue
                    a, b, c = faces[t, 0], faces[t, 1], faces[t, 2]
                    if v == a or v == b or v == c:
                        continue
                    if is_near[t] == v and dot(face_normal[t], vertex_normal[v]) > CREASE * np.sqrt(
                        dot(vertex_normal[v], vertex_normal[v])
                    ):
                        continue  # still flat beside its own neighbours
                    distance, above = point_triangle(x, v, a, b, c, vertex_normal[v])
                    if distance < best[above]:
                        best[above] = distance
                        lists.face[v, above] = t
        for s in range(2):
            lists.wake[v, s] = 0.0
            t = lists.face[v, s]
            if t >= 0:
                a = faces[t, 0]
                height = 0.0
                for k in range(3):
                    height += face_normal[t, k] * (x[v, k] - x[a, k])
                lists.side[v, s] = 1 if height >= 0.0 else -1


@njit(cache=True, error_model="numpy")
def _fill_pairs(x, mesh, lists, face_normal, centroid, origin, cell, shape, start, order):  # type: ignore[no-untyped-def]
    edges, margin = mesh.edges, mesh.reach[0] + 0.5 * (mesh.reach[1] - mesh.reach[0])
    seen = np.full(edges.shape[0], -1)
    guarded = np.zeros(edges.shape[0], dtype=np.bool_)
    for e in range(edges.shape[0]):
        f, g = mesh.edge_faces[e, 0], mesh.edge_faces[e, 1]
        guarded[e] = g < 0 or dot(face_normal[f], face_normal[g]) < CREASE
    count = 0
    middle = np.empty(3)
    for e in range(edges.shape[0]):
        if not guarded[e]:
            continue
        a, b = edges[e, 0], edges[e, 1]
        for k in range(3):
            middle[k] = 0.5 * (x[a, k] + x[b, k])
        i0, j0, k0 = grid_cell(middle, origin, cell, shape)
        for i in range(max(i0 - 1, 0), min(i0 + 2, shape[0])):
            for j in range(max(j0 - 1, 0), min(j0 + 2, shape[1])):
                row = (i * shape[1] + j) * shape[2]
                for p in range(start[row + max(k0 - 1, 0)], start[row + min(k0 + 2, shape[2])]):
                    for q in range(3):
                        o = mesh.face_edges[order[p], q]
                        if seen[o] == e or o == e or (guarded[o] and o < e):
                            continue
                        seen[o] = e
                        c, d = edges[o, 0], edges[o, 1]
                        if a == c or a == d or b == c or b == d:
                            continue
                        distance = closest_on_segments(x, a, b, c, d)[0]
                        if distance < margin and count < lists.pairs.shape[0]:
                            lists.pairs[count, 0], lists.pairs[count, 1] = e, o
                            lists.pair_wake[count] = 0.0
                            count += 1
    lists.count[0] = count


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
def _target(gap, gap_before, thickness, step):  # type: ignore[no-untyped-def]
    """Gap to restore: the thickness, or a little more than before where the pair began too close."""
    return max(gap, min(thickness, max(gap_before, 0.0) + RECOVERY_SPEED * step))


@njit(cache=True, error_model="numpy")
def _sweep_slots(x, before, mesh, lists, friction, step, deep):  # type: ignore[no-untyped-def]
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
                    lists.wake[v, s] = lists.travelled[0] + 0.4 * (gap - thickness)
                continue
            weight = inverse_mass[v] + ba * ba * inverse_mass[a] + bb * bb * inverse_mass[b] + bc * bc * inverse_mass[c]
            if weight == 0.0:
                continue
            target = _target(gap, side * _height(before, v, a, b, c), thickness, step)
            if target <= gap:
                continue
            smallest = min(smallest, gap)
            push = min(target - gap, thickness)
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
    return smallest


@njit(cache=True, error_model="numpy")
def _sweep_pairs(x, before, mesh, lists, step, deep):  # type: ignore[no-untyped-def]
    """One pass over the edge pairs, pushed apart along their closest points before the step."""
    edges, inverse_mass = mesh.edges, mesh.inverse_mass
    thickness = EDGE_GAP * mesh.reach[0]
    limit = DEEP * thickness if deep else thickness
    smallest = thickness
    for p in range(lists.count[0]):
        if lists.pair_wake[p] > lists.travelled[0]:
            continue
        a, b = edges[lists.pairs[p, 0], 0], edges[lists.pairs[p, 0], 1]
        c, d = edges[lists.pairs[p, 1], 0], edges[lists.pairs[p, 1], 1]
        distance, s, t = closest_on_segments(before, a, b, c, d)
        if not deep and distance > 1.5 * thickness:
            lists.pair_wake[p] = lists.travelled[0] + 0.45 * (distance - thickness)
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
        target = _target(gap, distance, thickness, step)
        if weight == 0.0 or target <= gap:
            continue
        smallest = min(smallest, gap)
        push = min(target - gap, thickness) / weight
        for o, w in ((a, wa), (b, wb), (c, wc), (d, wd)):
            f = w * inverse_mass[o] * push
            x[o, 0] += f * nx
            x[o, 1] += f * ny
            x[o, 2] += f * nz
    return smallest


@njit(cache=True, error_model="numpy")
def resolve(x, before, mesh, lists, friction, step):  # type: ignore[no-untyped-def]
    """Correct the moved positions x, shape (n, 3), given the legal ones before the step."""
    furthest = 0.0
    for v in range(x.shape[0]):
        dx, dy, dz = x[v, 0] - before[v, 0], x[v, 1] - before[v, 1], x[v, 2] - before[v, 2]
        furthest = max(furthest, dx * dx + dy * dy + dz * dz)
    lists.travelled[0] += np.sqrt(furthest)
    if 2.0 * lists.travelled[0] > mesh.reach[1] - 1.5 * mesh.reach[0]:
        rebuild(before, mesh, lists)
        lists.travelled[0] = np.sqrt(furthest)
    for sweep in range(SWEEPS):
        deep = sweep > 0
        pair_gap = _sweep_pairs(x, before, mesh, lists, step, deep)
        slot_gap = _sweep_slots(x, before, mesh, lists, friction, step, deep)
        if slot_gap >= DEEP * mesh.reach[0] and pair_gap >= DEEP * EDGE_GAP * mesh.reach[0]:
            break
