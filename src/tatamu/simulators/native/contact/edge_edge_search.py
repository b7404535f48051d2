"""Which edges are guarded against edges, and what is near them.

Borders are, creased edges, and the edges of layers that are pressed together: between flatter ones that are not, an
edge cannot come through before a vertex does.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from tatamu.simulators.native.contact.vertex_face_search import CREASE
from tatamu.simulators.native.geometry import closest_on_segments, dot, grid_cell, grid_of

RIDGE = 0.94
"""Edges whose triangles' normals have a cosine below this are guarded like borders."""


@njit(cache=True, error_model="numpy")
def _guarded(mesh, lists, face_normal):  # type: ignore[no-untyped-def]
    """Which edges are guarded, shape (e,)."""
    edges = mesh.edges
    guarded = np.empty(edges.shape[0], dtype=np.bool_)
    for e in range(edges.shape[0]):
        f, g = mesh.edge_faces[e, 0], mesh.edge_faces[e, 1]
        guarded[e] = g < 0 or dot(face_normal[f], face_normal[g]) < RIDGE
        guarded[e] |= lists.pressed[edges[e, 0]] > 0 or lists.pressed[edges[e, 1]] > 0
    return guarded


@njit(cache=True, error_model="numpy")
def _mean_normal(mesh, e, face_normal):  # type: ignore[no-untyped-def]
    """Unit normal at an edge."""
    f, g = mesh.edge_faces[e, 0], mesh.edge_faces[e, 1]
    nx, ny, nz = face_normal[f, 0], face_normal[f, 1], face_normal[f, 2]
    if g >= 0:
        nx, ny, nz = nx + face_normal[g, 0], ny + face_normal[g, 1], nz + face_normal[g, 2]
    scale = 1.0 / (np.sqrt(nx * nx + ny * ny + nz * nz) + 1e-30)
    return scale * nx, scale * ny, scale * nz


@njit(cache=True, error_model="numpy")
def _mark_near(mesh, e, is_near):  # type: ignore[no-untyped-def]
    """Mark the triangles within two rings of an edge's ends with its number."""
    for v in (mesh.edges[e, 0], mesh.edges[e, 1]):
        for i in range(mesh.near_start[v], mesh.near_start[v + 1]):
            is_near[mesh.near[i]] = e


@njit(cache=True, error_model="numpy")
def find(x, mesh, lists, face_normal, centroid, radius):  # type: ignore[no-untyped-def]
    """Pair each guarded edge with the edges of triangles near it, but for what is level beside it on the cloth."""
    edges, count, guarded = mesh.edges, 0, _guarded(mesh, lists, face_normal)
    reach = mesh.reach[0] + 0.5 * (mesh.reach[1] - mesh.reach[0])
    around = reach + 1.87 * mesh.reach[2]  # half an edge, and from an edge to a centroid: parts of the largest radius
    grid = grid_of(centroid, 0.5 * around)
    sorted_centroid = centroid[grid.order]
    is_near, seen = np.full(mesh.faces.shape[0], -1), np.full(edges.shape[0], -1)
    middle = np.empty(3)
    for e in range(edges.shape[0]):
        if not guarded[e]:
            continue
        a, b = edges[e, 0], edges[e, 1]
        _mark_near(mesh, e, is_near)
        ux, uy, uz = _mean_normal(mesh, e, face_normal)
        mx, my, mz = 0.5 * (x[a, 0] + x[b, 0]), 0.5 * (x[a, 1] + x[b, 1]), 0.5 * (x[a, 2] + x[b, 2])
        middle[0], middle[1], middle[2] = mx, my, mz
        far = reach + 0.5 * np.sqrt((x[b, 0] - x[a, 0]) ** 2 + (x[b, 1] - x[a, 1]) ** 2 + (x[b, 2] - x[a, 2]) ** 2)
        i0, j0, k0 = grid_cell(middle, grid)
        for i in range(max(i0 - 2, 0), min(i0 + 3, grid.shape[0])):
            for j in range(max(j0 - 2, 0), min(j0 + 3, grid.shape[1])):
                row = (i * grid.shape[1] + j) * grid.shape[2]
                for p in range(grid.start[row + max(k0 - 2, 0)], grid.start[row + min(k0 + 3, grid.shape[2])]):
                    dx = sorted_centroid[p, 0] - mx
                    dy = sorted_centroid[p, 1] - my
                    dz = sorted_centroid[p, 2] - mz
                    square = dx * dx + dy * dy + dz * dz
                    if square > around * around:
                        continue
                    t = grid.order[p]
                    if square > (far + radius[t]) ** 2:
                        continue
                    if is_near[t] == e:
                        lean = ux * face_normal[t, 0] + uy * face_normal[t, 1] + uz * face_normal[t, 2]
                        if lean > CREASE:
                            continue
                    for q in range(3):
                        o = mesh.face_edges[t, q]
                        if seen[o] == e or (guarded[o] and o <= e):
                            continue
                        seen[o] = e
                        c, d = edges[o, 0], edges[o, 1]
                        if a == c or a == d or b == c or b == d:
                            continue
                        if count < lists.pairs.shape[0] and closest_on_segments(x, a, b, c, d)[0] < reach:
                            lists.pairs[count, 0], lists.pairs[count, 1] = a, b
                            lists.pairs[count, 2], lists.pairs[count, 3] = c, d
                            lists.pair_wake[count] = 0.0
                            count += 1
    lists.used[0] = count
