"""Broad phase of edges against edges: finds the edges near each guarded edge.

Guarded are borders, creased edges, and edges of layers that are pressed together. Other cloth is nearly flat and not
pressed, so an edge cannot pass through it before a vertex does.
"""

from __future__ import annotations

import numpy as np

from tatamu.simulation.native.compiled import allocating, kernel
from tatamu.simulation.native.contact.grid import cells_around, grid_cell, grid_of
from tatamu.simulation.native.contact.shape import shape_of
from tatamu.simulation.native.contact.state import ContactMesh, ContactState
from tatamu.simulation.native.geometry import Vector, closest_on_segments, dot, unit
from tatamu.simulation.native.options import ContactOptions


@allocating
def _newly_guarded(
    mesh: ContactMesh, guarded: np.ndarray, pressed: np.ndarray, face_normal: np.ndarray, ridge: float
) -> np.ndarray:
    """Return which edges need to be guarded and are not guarded yet, shape (e,)."""
    edges = mesh.edges
    newly = np.zeros(edges.shape[0], dtype=np.bool_)
    for e in range(edges.shape[0]):
        if guarded[e]:
            continue
        f, g = mesh.edge_faces[e, 0], mesh.edge_faces[e, 1]
        newly[e] = g < 0 or dot(face_normal[f], face_normal[g]) < ridge
        newly[e] |= pressed[edges[e, 0]] > 0 or pressed[edges[e, 1]] > 0
    return newly


@kernel
def _mean_normal(f: int, g: int, face_normal: np.ndarray) -> Vector:
    """Return the mean unit normal of triangles f and g at an edge; g is -1 at a border."""
    nx, ny, nz = face_normal[f, 0], face_normal[f, 1], face_normal[f, 2]
    if g >= 0:
        nx += face_normal[g, 0]
        ny += face_normal[g, 1]
        nz += face_normal[g, 2]
    return unit(nx, ny, nz)


@kernel
def _mark_near(edge: np.ndarray, e: int, near_start: np.ndarray, near: np.ndarray, is_near: np.ndarray) -> None:
    """Mark the triangles within two rings around the ends of edge e by writing e to `is_near`."""
    for v in (edge[0], edge[1]):
        for i in range(near_start[v], near_start[v + 1]):
            is_near[near[i]] = e


@allocating
def search(x: np.ndarray, mesh: ContactMesh, contact: ContactState, options: ContactOptions) -> None:
    """Pair each newly guarded edge with the edges near it, except its neighbours in the same flat cloth."""
    shape = shape_of(x, mesh.faces)
    edge_edge = contact.edge_edge
    count = contact.counters.pairs
    edges = mesh.edges
    face_edges = mesh.face_edges
    face_normal = shape.face_normal
    radius = shape.radius
    pairs = edge_edge.pairs
    wake = edge_edge.wake
    meets = edge_edge.meets
    crease = options.crease_cosine
    guarded = edge_edge.guarded
    newly = _newly_guarded(mesh, guarded, contact.activity.pressed, face_normal, options.ridge_cosine)
    reach = mesh.thickness + 0.5 * (mesh.search_distance - mesh.thickness)  # half of the margin
    # an upper bound on half of an edge plus the distance of another edge from its triangle's centroid
    around = reach + 1.87 * mesh.triangle_radius
    grid = grid_of(shape.centroid, 0.5 * around)
    sorted_centroid = shape.centroid[grid.order]
    is_near = np.full(mesh.faces.shape[0], -1)  # the last guarded edge that has this triangle next to it on the cloth
    seen = np.full(edges.shape[0], -1)  # the last guarded edge with which each edge was compared
    middle = np.empty(3)
    for e in range(edges.shape[0]):
        if not newly[e]:
            continue
        guarded[e] = True
        a, b = edges[e, 0], edges[e, 1]
        _mark_near(edges[e], e, mesh.near_start, mesh.near, is_near)
        ux, uy, uz = _mean_normal(mesh.edge_faces[e, 0], mesh.edge_faces[e, 1], face_normal)
        for k in range(3):
            middle[k] = 0.5 * (x[a, k] + x[b, k])
        mx, my, mz = middle[0], middle[1], middle[2]
        far = reach + 0.5 * np.sqrt((x[b, 0] - x[a, 0]) ** 2 + (x[b, 1] - x[a, 1]) ** 2 + (x[b, 2] - x[a, 2]) ** 2)
        cell = grid_cell(middle, grid)
        for column in range(25):
            begin, end = cells_around(cell, 2, column, grid.shape, grid.start)
            for p in range(begin, end):
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
                    if lean > crease:
                        continue
                for q in range(3):
                    o = face_edges[t, q]
                    if seen[o] == e or guarded[o]:
                        continue
                    seen[o] = e
                    c, d = edges[o, 0], edges[o, 1]
                    if a == c or a == d or b == c or b == d:
                        continue
                    if count < pairs.shape[0] and closest_on_segments(x, a, b, c, d)[0] < reach:
                        pairs[count, 0] = a
                        pairs[count, 1] = b
                        pairs[count, 2] = c
                        pairs[count, 3] = d
                        wake[count] = 0.0
                        meets[count] = 0.0
                        edge_edge.apart[count] = 0.0
                        count += 1
    contact.counters.pairs = count
    contact.counters.newly_pressed = False
