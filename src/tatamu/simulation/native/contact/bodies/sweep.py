"""Narrow phase of cloth against bodies: vertices, edges and faces. The docstring of `bodies` explains the method."""

from __future__ import annotations

import numpy as np

from tatamu.simulation.native.compiled import kernel
from tatamu.simulation.native.contact.bodies.push import Frame, Rule, beyond_a_face, correct, enter, gap_of
from tatamu.simulation.native.contact.bodies.rounded_box import along_edge
from tatamu.simulation.native.contact.bodies.state import Bodies
from tatamu.simulation.native.contact.projection import Positions
from tatamu.simulation.native.contact.state import Activity, ContactMesh, ContactState
from tatamu.simulation.native.geometry import TINY_LENGTH, Vector, cross, difference, normal_of
from tatamu.simulation.native.options import ContactOptions

CONE = 0.1
"""Sine by which a triangle's normal may lie outside a corner's normal cone, so that several corners share a load."""
CLEAR = 0.98
"""Fraction of the gap beyond which edges and triangles outside a face of the core are not tested: vertices suffice."""


@kernel
def _vertices(
    positions: Positions, mesh: ContactMesh, activity: Activity, frame: Frame, rule: Rule, near: np.ndarray
) -> float:
    """Correct the vertices near a body, and return their smallest gap to the body [m]."""
    smallest = rule.wanted
    clear = rule.wanted + frame.radius + rule.passing
    weights = (1.0, 0.0, 0.0)
    for i in range(near.shape[0]):
        v = near[i]
        if beyond_a_face(frame.local, v, v, v, frame.half, clear):
            continue
        corners = (v, v, v)
        gap, gap_at_start, normal = gap_of(frame, corners, weights)
        if gap < rule.wanted:
            found = correct(
                positions, mesh.inverse_mass, activity, frame, rule, corners, weights, gap, gap_at_start, normal
            )
            smallest = min(smallest, found)
    return smallest


@kernel
def _edges(
    positions: Positions, mesh: ContactMesh, activity: Activity, frame: Frame, rule: Rule, near: np.ndarray
) -> float:
    """Correct the edges near a body whose nearest point is not an end, and return their smallest gap [m]."""
    smallest = rule.wanted
    clear = CLEAR * rule.wanted + frame.radius + rule.passing
    within = rule.wanted + rule.passing
    for i in range(near.shape[0]):
        a, b = mesh.edges[near[i], 0], mesh.edges[near[i], 1]
        if beyond_a_face(frame.local, a, b, b, frame.half, clear):
            continue
        s = along_edge(frame.half, frame.radius, frame.local[a], frame.local[b], within)
        if s < 0.0:
            continue
        corners = (a, b, b)
        weights = (1.0 - s, s, 0.0)
        gap, gap_at_start, normal = gap_of(frame, corners, weights)
        if gap < rule.wanted:
            found = correct(
                positions, mesh.inverse_mass, activity, frame, rule, corners, weights, gap, gap_at_start, normal
            )
            smallest = min(smallest, found)
    return smallest


@kernel
def _normal(local: np.ndarray, a: int, b: int, c: int) -> tuple[float, float, float, float]:
    """Return the unit normal of a triangle, and the height of the body's centre, the origin, over its plane [m]."""
    nx, ny, nz = normal_of(local, a, b, c)
    scale = 1.0 / (np.sqrt(nx * nx + ny * ny + nz * nz) + TINY_LENGTH)
    nx, ny, nz = nx * scale, ny * scale, nz * scale
    return nx, ny, nz, -(nx * local[a, 0] + ny * local[a, 1] + nz * local[a, 2])


@kernel
def _in_cone(corner: np.ndarray, nx: float, ny: float, nz: float) -> bool:
    """Return whether a corner of a body's core is the farthest corner in direction n, or nearly the farthest."""
    return (
        nx * corner[0] >= -CONE * abs(corner[0])
        and ny * corner[1] >= -CONE * abs(corner[1])
        and nz * corner[2] >= -CONE * abs(corner[2])
    )


@kernel
def _weights_at(local: np.ndarray, a: int, b: int, c: int, point: np.ndarray) -> Vector:
    """Return the barycentric coordinates of a point's projection on a triangle."""
    nx, ny, nz = normal_of(local, a, b, c)
    square = nx * nx + ny * ny + nz * nz + TINY_LENGTH
    px, py, pz = point[0] - local[a, 0], point[1] - local[a, 1], point[2] - local[a, 2]
    ux, uy, uz = difference(local, b, a)
    wx, wy, wz = difference(local, c, a)
    qx, qy, qz = cross(px, py, pz, wx, wy, wz)
    rx, ry, rz = cross(ux, uy, uz, px, py, pz)
    wb = (qx * nx + qy * ny + qz * nz) / square
    wc = (rx * nx + ry * ny + rz * nz) / square
    return 1.0 - wb - wc, wb, wc


@kernel
def _faces(
    positions: Positions,
    mesh: ContactMesh,
    activity: Activity,
    frame: Frame,
    rule: Rule,
    near: np.ndarray,
    points: np.ndarray,
) -> float:
    """Correct faces with a corner of the core (`points`) over their inside, and return their smallest gap [m]."""
    smallest = rule.wanted
    clear = CLEAR * rule.wanted + frame.radius + rule.passing
    local = frame.local
    half = frame.half
    for i in range(near.shape[0]):
        a, b, c = mesh.faces[near[i], 0], mesh.faces[near[i], 1], mesh.faces[near[i], 2]
        if beyond_a_face(local, a, b, c, half, clear):
            continue
        nx, ny, nz, height = _normal(local, a, b, c)
        wide = abs(nx) * half[0] + abs(ny) * half[1] + abs(nz) * half[2] + frame.radius
        if abs(height) - wide >= rule.wanted + rule.passing:
            continue
        mx, my, mz, height0 = _normal(frame.local0, a, b, c)
        for q in range(points.shape[0]):
            point = points[q]
            above = height0 + mx * point[0] + my * point[1] + mz * point[2]
            side = 1.0 if above >= 0.0 else -1.0  # the side of the corner, because the plane may cut the body
            if not _in_cone(point, -side * nx, -side * ny, -side * nz):
                continue
            gap = side * (height + nx * point[0] + ny * point[1] + nz * point[2]) - frame.radius
            if gap >= rule.wanted or gap < -2.0 * wide:
                continue
            weights = _weights_at(local, a, b, c, point)
            if min(weights[0], weights[1], weights[2]) < 0.0:
                continue
            gap_at_start = side * above - frame.radius
            normal = (-side * nx, -side * ny, -side * nz)
            found = correct(
                positions, mesh.inverse_mass, activity, frame, rule, (a, b, c), weights, gap, gap_at_start, normal
            )
            smallest = min(smallest, found)
            nx, ny, nz, height = _normal(local, a, b, c)
    return smallest


@kernel
def sweep(
    positions: Positions,
    mesh: ContactMesh,
    contact: ContactState,
    bodies: Bodies,
    options: ContactOptions,
    step: float,
    restored: float,
) -> float:
    """Sweep over vertices, edges and faces near each body, and return the minimum gap [m], at most half a thickness."""
    kept = 0.5 * mesh.thickness
    smallest = kept
    near = bodies.near.narrow
    activity = contact.activity
    for b in range(bodies.radius.shape[0]):
        if near.counts[b, 2] == 0:
            continue
        frame = Frame(
            bodies.half[b],
            bodies.radius[b],
            bodies.end.rotation[b],
            bodies.end.position[b],
            bodies.start.rotation[b],
            bodies.start.position[b],
            bodies.near.local,
            bodies.near.local0,
        )
        vertices = near.vertices[b, : near.counts[b, 0]]
        way = enter(frame, positions, vertices)
        thin = bodies.radius[b] + min(frame.half[0], frame.half[1], frame.half[2])
        rule = Rule(
            wanted=restored * kept,
            clearing=options.clearing_speed * step,
            recovery=options.recovery_speed * step,
            friction=bodies.friction[b],
            noticeable=options.noticeable * mesh.thickness,
            hard=options.hard * mesh.thickness,
            sweep=contact.counters.sweep,
            restless_until=contact.counters.outer_step + options.restless_steps,
            passing=way if way > thin else 0.0,
        )
        at_vertices = _vertices(positions, mesh, activity, frame, rule, vertices)
        at_edges = _edges(positions, mesh, activity, frame, rule, near.edges[b, : near.counts[b, 1]])
        points = bodies.corners[b, : bodies.corner_count[b]]
        at_faces = _faces(positions, mesh, activity, frame, rule, near.faces[b, : near.counts[b, 2]], points)
        smallest = min(smallest, at_vertices, at_edges, at_faces)
    return smallest
