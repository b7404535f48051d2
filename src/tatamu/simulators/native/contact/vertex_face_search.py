"""The nearest triangle on either side of a vertex, found with a grid; slots walk on from there."""

from __future__ import annotations

import numpy as np
from numba import njit

from tatamu.simulators.native.geometry import dot, grid_cell, grid_of, normal_of, point_triangle

CREASE = 0.5
"""Cloth whose normals have a cosine below this is folded: vertices are then kept from triangles next to them."""
TOUCHING, SAME_WAY = 1.1, 0.8
"""A triangle closer than this part of a thickness is in contact; directions with a larger cosine are the same."""
LEVEL = 0.7
"""Of a triangle more level with a vertex than this cosine, the plane tells on which side of the vertex it is."""


@njit(cache=True, error_model="numpy")
def normals(x, faces):  # type: ignore[no-untyped-def]
    """Unit normals of triangles (m, 3) and vertices (n, 3), centroids (m, 3), how far corners are from them (m,)."""
    n, m = x.shape[0], faces.shape[0]
    face_normal, vertex_normal, centroid = np.empty((m, 3)), np.zeros((n, 3)), np.empty((m, 3))
    radius = np.empty(m)
    for t in range(faces.shape[0]):
        a, b, c = faces[t, 0], faces[t, 1], faces[t, 2]
        nx, ny, nz = normal_of(x, a, b, c)
        scale = 1.0 / (np.sqrt(nx * nx + ny * ny + nz * nz) + 1e-30)
        face_normal[t, 0], face_normal[t, 1], face_normal[t, 2] = scale * nx, scale * ny, scale * nz
        mx = (x[a, 0] + x[b, 0] + x[c, 0]) / 3.0
        my = (x[a, 1] + x[b, 1] + x[c, 1]) / 3.0
        mz = (x[a, 2] + x[b, 2] + x[c, 2]) / 3.0
        centroid[t, 0], centroid[t, 1], centroid[t, 2] = mx, my, mz
        square = 0.0
        for v in (a, b, c):
            vertex_normal[v, 0] += nx
            vertex_normal[v, 1] += ny
            vertex_normal[v, 2] += nz
            square = max(square, (x[v, 0] - mx) ** 2 + (x[v, 1] - my) ** 2 + (x[v, 2] - mz) ** 2)
        radius[t] = np.sqrt(square)
    for v in range(vertex_normal.shape[0]):
        scale = 1.0 / (np.sqrt(dot(vertex_normal[v], vertex_normal[v])) + 1e-30)
        for k in range(3):
            vertex_normal[v, k] *= scale
    return face_normal, vertex_normal, centroid, radius


@njit(cache=True, error_model="numpy")
def _flat_there(t, v, is_near, face_normal, vertex_normal):  # type: ignore[no-untyped-def]
    """Whether triangle t is near v on the cloth and level with it, so that they cannot touch."""
    return is_near[t] == v and dot(face_normal[t], vertex_normal[v]) > CREASE


@njit(cache=True, error_model="numpy")
def _same_way(x, v, s, t, face_normal, centroid):  # type: ignore[no-untyped-def]
    """Whether v is kept from triangle s in much the same direction as from triangle t."""
    over_s, over_t = 0.0, 0.0
    for k in range(3):
        over_s += face_normal[s, k] * (x[v, k] - centroid[s, k])
        over_t += face_normal[t, k] * (x[v, k] - centroid[t, k])
    along = dot(face_normal[s], face_normal[t])
    return (along if over_s * over_t > 0.0 else -along) > SAME_WAY


@njit(cache=True, error_model="numpy")
def _third(x, v, faces, slots, sides, touching, below, above, face_normal, centroid, up):  # type: ignore[no-untyped-def]
    """Slot of the nearest of those triangles that v has touched until now and that are lost to it; -1 for none.

    In a crumple of three sheets the third would else be let go, and passed. One that lies the same way as another
    slot's is not lost: it is of the same sheet, or behind it.
    """
    nearest, kept = touching, -1
    for s in range(slots.shape[1]):
        t = slots[v, s]
        if t < 0 or t == below or t == above or sides[v, s] == 0:
            continue
        if below >= 0 and _same_way(x, v, below, t, face_normal, centroid):
            continue
        if above >= 0 and _same_way(x, v, above, t, face_normal, centroid):
            continue
        distance = point_triangle(x, v, faces[t, 0], faces[t, 1], faces[t, 2], up)[0]
        if distance < nearest:
            nearest, kept = distance, s
    return kept


@njit(cache=True, error_model="numpy")
def find(x, mesh, lists, face_normal, vertex_normal, centroid, radius):  # type: ignore[no-untyped-def]
    """Fill the slots of all vertices.

    Nearest in distance, not by its centroid: of two layers a thickness apart, the further one may well have the nearer
    centroid, and a slot never walks from one layer to another.
    """
    faces = mesh.faces
    around = mesh.reach[1] ** 2 + mesh.reach[2] ** 2  # a layer at the margin has a centroid within its root
    grid = grid_of(centroid, np.sqrt(around))
    sorted_centroid = centroid[grid.order]
    sure, touching = 0.3 * mesh.reach[0], TOUCHING * mesh.reach[0]
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
                    nx, ny, nz = face_normal[t, 0], face_normal[t, 1], face_normal[t, 2]
                    lean = nx * ux + ny * uy + nz * uz
                    if is_near[t] == v and lean > CREASE:
                        continue  # next to v on the cloth and level with it: they cannot touch
                    off = nx * dx + ny * dy + nz * dz
                    best = max(best_above, best_below)
                    if abs(lean) > LEVEL and abs(off) > sure:
                        best = best_above if off * lean > 0.0 else best_below
                    beside = best * best - off * off
                    if beside <= 0.0 or square - off * off > (radius[t] + np.sqrt(beside)) ** 2:
                        continue  # its plane, or its circle in that plane, is further than what is known
                    a, b, c = faces[t, 0], faces[t, 1], faces[t, 2]
                    if a == v or b == v or c == v:
                        continue
                    distance, up = point_triangle(x, v, a, b, c, vertex_normal[v])
                    if up and distance < best_above:
                        best_above, above = distance, t
                    elif not up and distance < best_below:
                        best_below, below = distance, t
        normal = vertex_normal[v]
        kept = _third(x, v, faces, lists.face, lists.side, touching, below, above, face_normal, centroid, normal)
        lists.face[v, 2], lists.side[v, 2] = (-1, 0) if kept < 0 else (lists.face[v, kept], lists.side[v, kept])
        lists.face[v, 0], lists.face[v, 1] = below, above
        lists.side[v, :2] = 0
        lists.wake[v, :] = 0.0
