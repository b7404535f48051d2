"""Broad phase of vertices against triangles: finds the nearest triangle on either side of a vertex, and one more.

Functions that are called for each vertex get single arrays, because numba copies a record at each call that is not
inlined, which once took half of the time of every search.
"""

from __future__ import annotations

import numpy as np

from tatamu.simulation.native.compiled import allocating, kernel
from tatamu.simulation.native.contact.grid import cells_around, grid_cell, grid_of
from tatamu.simulation.native.contact.shape import Shape, shape_of
from tatamu.simulation.native.contact.state import ABOVE, BELOW, EXTRA, ContactMesh, VertexFace
from tatamu.simulation.native.geometry import dot, point_triangle
from tatamu.simulation.native.options import ContactOptions


@allocating
def search(x: np.ndarray, mesh: ContactMesh, vertex_face: VertexFace, options: ContactOptions) -> None:
    """Find the partners of all vertices at legal positions x [m]; the present partners are tested first."""
    shape = shape_of(x, mesh.faces)
    nearest = _nearest_on_both_sides(x, mesh, vertex_face.triangle, shape, options)
    _keep_what_would_be_lost(x, mesh, vertex_face, nearest, shape, options)


@allocating
def _nearest_on_both_sides(
    x: np.ndarray, mesh: ContactMesh, partners: np.ndarray, shape: Shape, options: ContactOptions
) -> np.ndarray:
    """Return the nearest triangle below and above each vertex along its normal, shape (n, 2); -1 if none is near.

    The distance to the triangle counts and not that to its centroid, because the farther of two layers can have the
    nearer centroid, and a partner never moves from one layer to another.
    """
    faces = mesh.faces
    near = mesh.near
    face_normal = shape.face_normal
    vertex_normal = shape.vertex_normal
    radius = shape.radius
    # The centroid of a triangle at the search distance lies within the square root of this value.
    around = mesh.search_distance**2 + mesh.triangle_radius**2
    grid = grid_of(shape.centroid, np.sqrt(around))
    sorted_centroid = shape.centroid[grid.order]
    sure = 0.3 * mesh.thickness  # height at which a vertex is surely on this side
    crease = options.crease_cosine
    level = options.level_cosine
    is_near = np.full(faces.shape[0], -1)  # the last vertex that has this triangle next to it on the cloth
    nearest = np.empty((x.shape[0], 2), dtype=np.int64)
    for v in range(x.shape[0]):
        for i in range(mesh.near_start[v], mesh.near_start[v + 1]):
            is_near[near[i]] = v
        best_below = mesh.search_distance
        best_above = mesh.search_distance
        below = -1
        above = -1
        for k in range(2):  # the earlier nearest triangles first: then most others are dismissed by their planes
            t = partners[v, k]
            if t < 0 or (is_near[t] == v and dot(face_normal[t], vertex_normal[v]) > crease):
                continue
            distance, up = point_triangle(x, v, faces[t, 0], faces[t, 1], faces[t, 2], vertex_normal[v])
            if up and distance < best_above:
                best_above = distance
                above = t
            elif not up and distance < best_below:
                best_below = distance
                below = t
        vx, vy, vz = x[v, 0], x[v, 1], x[v, 2]
        ux, uy, uz = vertex_normal[v, 0], vertex_normal[v, 1], vertex_normal[v, 2]
        cell = grid_cell(x[v], grid)
        for column in range(9):
            begin, end = cells_around(cell, 1, column, grid.shape, grid.start)
            for p in range(begin, end):
                dx = sorted_centroid[p, 0] - vx
                dy = sorted_centroid[p, 1] - vy
                dz = sorted_centroid[p, 2] - vz
                square = dx * dx + dy * dy + dz * dz
                if square >= around:
                    continue
                t = grid.order[p]
                nx, ny, nz = face_normal[t, 0], face_normal[t, 1], face_normal[t, 2]
                lean = nx * ux + ny * uy + nz * uz
                if is_near[t] == v and lean > crease:
                    continue  # next to v on the cloth and level with it: they cannot touch
                off = nx * dx + ny * dy + nz * dz
                best = max(best_above, best_below)
                if abs(lean) > level and abs(off) > sure:
                    best = best_above if off * lean > 0.0 else best_below
                beside = best * best - off * off
                if beside <= 0.0 or square - off * off > (radius[t] + np.sqrt(beside)) ** 2:
                    continue  # its plane, or its circle in that plane, is farther away than the nearest triangle so far
                a, b, c = faces[t, 0], faces[t, 1], faces[t, 2]
                if a == v or b == v or c == v:
                    continue
                distance, up = point_triangle(x, v, a, b, c, vertex_normal[v])
                if up and distance < best_above:
                    best_above = distance
                    above = t
                elif not up and distance < best_below:
                    best_below = distance
                    below = t
        nearest[v, BELOW] = below
        nearest[v, ABOVE] = above
    return nearest


@kernel
def _keep_what_would_be_lost(
    x: np.ndarray,
    mesh: ContactMesh,
    vertex_face: VertexFace,
    nearest: np.ndarray,
    shape: Shape,
    options: ContactOptions,
) -> None:
    """Make the nearest triangles partners, and keep one earlier partner that the vertex touches, with its side.

    In a crumple of three sheets, the third would otherwise be forgotten, and could pass through the cloth. A partner in
    the same direction as a new one is not kept, because it belongs to the same sheet or lies behind it.
    """
    faces = mesh.faces
    partners = vertex_face.triangle
    sides = vertex_face.side
    face_normal = shape.face_normal
    vertex_normal = shape.vertex_normal
    centroid = shape.centroid
    same = options.same_direction_cosine
    for v in range(x.shape[0]):
        below = nearest[v, BELOW]
        above = nearest[v, ABOVE]
        best = options.touching * mesh.thickness
        kept = -1
        for k in range(partners.shape[1]):
            t = partners[v, k]
            if t < 0 or t == below or t == above or sides[v, k] == 0:
                continue
            if below >= 0 and _in_same_direction(x[v], below, t, face_normal, centroid, same):
                continue
            if above >= 0 and _in_same_direction(x[v], above, t, face_normal, centroid, same):
                continue
            distance = point_triangle(x, v, faces[t, 0], faces[t, 1], faces[t, 2], vertex_normal[v])[0]
            if distance < best:
                best = distance
                kept = k
        extra = partners[v, kept] if kept >= 0 else -1
        extra_side = sides[v, kept] if kept >= 0 else 0
        partners[v, BELOW] = below
        partners[v, ABOVE] = above
        partners[v, EXTRA] = extra
        sides[v, BELOW] = 0
        sides[v, ABOVE] = 0
        sides[v, EXTRA] = extra_side
        for k in range(partners.shape[1]):
            vertex_face.wake[v, k] = 0.0
            vertex_face.meets[v, k] = 0.0


@kernel
def _in_same_direction(
    point: np.ndarray, s: int, t: int, face_normal: np.ndarray, centroid: np.ndarray, same: float
) -> bool:
    """Return whether triangles s and t keep a point away in nearly the same direction."""
    over_s = 0.0
    over_t = 0.0
    for k in range(3):
        over_s += face_normal[s, k] * (point[k] - centroid[s, k])
        over_t += face_normal[t, k] * (point[k] - centroid[t, k])
    along = dot(face_normal[s], face_normal[t])
    return (along if over_s * over_t > 0.0 else -along) > same
