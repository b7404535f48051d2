"""The last resort of contact: rigid impact zones (Provot 1997, Bridson et al. 2002).

If hands crush many layers, one correction undoes another, and a pair may end a step on the wrong side. Its four
vertices then form a *zone*, together with other such pairs that share a vertex. The zone is set back to the start of
the step, where all layers are on their correct sides, and moved by its mean motion, which keeps its momentum and every
distance within it. (Bridson et al. also rotate a zone.)

Zones are the sets of a union-find forest: `zone[v]` is the parent of vertex v, v itself for a root, or -1 for no zone.
"""

from __future__ import annotations

import numpy as np

from tatamu.simulation.native.compiled import allocating, kernel
from tatamu.simulation.native.contact.motion import of_edges, of_vertex_and_face
from tatamu.simulation.native.contact.projection import Positions
from tatamu.simulation.native.contact.state import ContactMesh, ContactState
from tatamu.simulation.native.geometry import Vector, closest_on_segments, difference, normal_of
from tatamu.simulation.native.options import ContactOptions


@kernel
def _root(zone: np.ndarray, v: int) -> int:
    """Return the root of vertex v, and halve the path from v to the root."""
    while zone[v] != v:
        zone[v] = zone[zone[v]]
        v = zone[v]
    return v


@kernel
def _join(zone: np.ndarray, a: int, b: int) -> None:
    """Put two vertices into one zone."""
    for v in (a, b):
        if zone[v] < 0:
            zone[v] = v
    zone[_root(zone, a)] = _root(zone, b)


@kernel
def _join_four(zone: np.ndarray, a: int, b: int, c: int, d: int) -> bool:
    """Put four vertices into one zone, and return whether this changed any zone."""
    if zone[a] >= 0 and zone[b] >= 0 and zone[c] >= 0 and zone[d] >= 0:
        root = _root(zone, a)
        if _root(zone, b) == root and _root(zone, c) == root and _root(zone, d) == root:
            return False
    _join(zone, a, b)
    _join(zone, b, c)
    _join(zone, c, d)
    return True


@kernel
def _between_edges(x: np.ndarray, a: int, b: int, c: int, d: int) -> Vector:
    """Return the shortest vector from segment (c, d) to segment (a, b) [m]."""
    _, s, t = closest_on_segments(x, a, b, c, d)
    rx = (1 - s) * x[a, 0] + s * x[b, 0] - (1 - t) * x[c, 0] - t * x[d, 0]
    ry = (1 - s) * x[a, 1] + s * x[b, 1] - (1 - t) * x[c, 1] - t * x[d, 1]
    rz = (1 - s) * x[a, 2] + s * x[b, 2] - (1 - t) * x[c, 2] - t * x[d, 2]
    return rx, ry, rz


@kernel
def _approach(x: np.ndarray, start: np.ndarray, a: int, b: int, c: int, d: int) -> float:
    """Return a bound on the square of the approach of edges (a, b) and (c, d) since the start of the step [m^2]."""
    farthest = 0.0
    for o in (a, b):
        ox, oy, oz = x[o, 0] - start[o, 0], x[o, 1] - start[o, 1], x[o, 2] - start[o, 2]
        for q in (c, d):
            qx, qy, qz = x[q, 0] - start[q, 0], x[q, 1] - start[q, 1], x[q, 2] - start[q, 2]
            farthest = max(farthest, (ox - qx) ** 2 + (oy - qy) ** 2 + (oz - qz) ** 2)
    return farthest


@kernel
def _edges_passed(x: np.ndarray, start: np.ndarray, a: int, b: int, c: int, d: int) -> bool:
    """Return whether the shortest vector between two edges has reversed since the start of the step."""
    px, py, pz = _between_edges(start, a, b, c, d)
    qx, qy, qz = _between_edges(x, a, b, c, d)
    return px * qx + py * qy + pz * qz <= 0.0


@kernel
def _vertex_passed(x: np.ndarray, v: int, a: int, b: int, c: int, side: int, tolerance: float) -> bool:
    """Return whether vertex v is over the inside of triangle (a, b, c), but not on the given side of the triangle.

    A vertex counts as inside if all its barycentric coordinates are at least minus the tolerance.
    """
    nx, ny, nz = normal_of(x, a, b, c)
    px, py, pz = difference(x, v, a)
    if side * (nx * px + ny * py + nz * pz) > 0.0:
        return False
    least = -tolerance * (nx * nx + ny * ny + nz * nz)
    for p, q in ((a, b), (b, c), (c, a)):
        ex, ey, ez = difference(x, q, p)
        rx, ry, rz = difference(x, v, p)
        if nx * (ey * rz - ez * ry) + ny * (ez * rx - ex * rz) + nz * (ex * ry - ey * rx) < least:
            return False
    return True


@allocating
def _near_pairs(mesh: ContactMesh, contact: ContactState) -> np.ndarray:
    """Return the pairs of edges that may have passed through each other."""
    inverse_mass = mesh.inverse_mass
    pairs = contact.edge_edge.pairs
    wake = contact.edge_edge.wake
    meets = contact.edge_edge.meets
    reach = contact.motion.reach
    travelled = contact.counters.travelled
    near = np.empty(contact.counters.pairs, np.int64)
    count = 0
    for p in range(contact.counters.pairs):
        if wake[p] > travelled:
            continue
        a, b, c, d = pairs[p, 0], pairs[p, 1], pairs[p, 2], pairs[p, 3]
        if meets[p] > of_edges(reach, a, b, c, d):
            continue
        if min(inverse_mass[a], inverse_mass[b]) > 0.0 or min(inverse_mass[c], inverse_mass[d]) > 0.0:
            near[count] = p  # otherwise hands hold both edges
            count += 1
    return near[:count]


@kernel
def _join_passed_edges(positions: Positions, contact: ContactState, near: np.ndarray, zone: np.ndarray) -> bool:
    """Put edges that have passed through each other into one zone, and return whether any zone grew."""
    grew = False
    pairs = contact.edge_edge.pairs
    apart = contact.edge_edge.apart
    restless = contact.activity.restless
    now = contact.counters.outer_step
    for p in near:
        a, b, c, d = pairs[p, 0], pairs[p, 1], pairs[p, 2], pairs[p, 3]
        if restless[a] < now and restless[b] < now and restless[c] < now and restless[d] < now:
            continue
        if _approach(positions.x, positions.start, a, b, c, d) < apart[p] * apart[p]:
            continue
        if _edges_passed(positions.x, positions.start, a, b, c, d):
            grew |= _join_four(zone, a, b, c, d)
    return grew


@kernel
def _join_passed_vertices(
    x: np.ndarray, mesh: ContactMesh, contact: ContactState, zone: np.ndarray, tolerance: float
) -> bool:
    """Put each vertex and the triangle that it has passed through into one zone, and return whether any zone grew."""
    grew = False
    faces = mesh.faces
    inverse_mass = mesh.inverse_mass
    triangle = contact.vertex_face.triangle
    side = contact.vertex_face.side
    wake = contact.vertex_face.wake
    meets = contact.vertex_face.meets
    reach = contact.motion.reach
    restless = contact.activity.restless
    now = contact.counters.outer_step
    travelled = contact.counters.travelled
    for v in range(x.shape[0]):
        for k in range(triangle.shape[1]):
            t = triangle[v, k]
            if t < 0 or side[v, k] == 0 or wake[v, k] > travelled:
                continue
            a, b, c = faces[t, 0], faces[t, 1], faces[t, 2]
            if restless[v] < now and restless[a] < now and restless[b] < now and restless[c] < now:
                continue
            if meets[v, k] > of_vertex_and_face(reach, v, a, b, c):
                continue
            if inverse_mass[v] == 0.0 and min(inverse_mass[a], inverse_mass[b], inverse_mass[c]) == 0.0:
                continue  # hands hold the vertex and the triangle
            if _vertex_passed(x, v, a, b, c, side[v, k], tolerance):
                grew |= _join_four(zone, v, a, b, c)
    return grew


@allocating
def _move_as_one(positions: Positions, inverse_mass: np.ndarray, zone: np.ndarray) -> None:
    """Move every zone from the start of the step by its mean motion, or by that of vertices that a hand holds."""
    x = positions.x
    start = positions.start
    n = x.shape[0]
    mean = np.zeros((n, 3))
    weight = np.zeros(n)
    held = np.zeros(n, dtype=np.bool_)
    for v in range(n):
        if zone[v] >= 0 and inverse_mass[v] == 0.0:
            held[_root(zone, v)] = True
    for v in range(n):
        if zone[v] < 0:
            continue
        root = _root(zone, v)
        if held[root] and inverse_mass[v] > 0.0:
            continue
        mass = 1.0 if held[root] else 1.0 / inverse_mass[v]
        weight[root] += mass
        for k in range(3):
            mean[root, k] += mass * (x[v, k] - start[v, k])
    for v in range(n):
        if zone[v] >= 0:
            root = _root(zone, v)
            for k in range(3):
                x[v, k] = start[v, k] + mean[root, k] / weight[root]


@allocating
def hold(positions: Positions, mesh: ContactMesh, contact: ContactState, options: ContactOptions) -> int:
    """Undo the motion of cloth that passed through cloth, and return the number of passes in which zones grew.

    Only restless vertices are tested: those that contact has recently pushed hard, and those of zones.
    """
    zone = np.full(positions.x.shape[0], -1)
    near = _near_pairs(mesh, contact)
    restless = contact.activity.restless
    restless_until = contact.counters.outer_step + options.restless_steps
    for passes in range(options.zone_passes):
        grew = _join_passed_edges(positions, contact, near, zone)
        grew |= _join_passed_vertices(positions.x, mesh, contact, zone, options.barycentric_tolerance)
        if not grew:
            return passes
        _move_as_one(positions, mesh.inverse_mass, zone)
        for v in range(zone.shape[0]):
            if zone[v] >= 0:
                restless[v] = restless_until
    return options.zone_passes
