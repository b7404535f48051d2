"""Narrow phase and correction of cloth against bodies, with Coulomb friction; derived in the docstring of the package.

All vectors are in the frame of the body, at the end of the round or, with a 0, at its start. In that frame the body
rests, so that one slip holds for bodies that stand, move and turn.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tatamu.simulators.native.compiled import kernel
from tatamu.simulators.native.contact.bodies.rounded_box import along_edge, distance
from tatamu.simulators.native.contact.bodies.state import Bodies
from tatamu.simulators.native.contact.projection import Positions
from tatamu.simulators.native.contact.state import Activity, ContactMesh, ContactState
from tatamu.simulators.native.geometry import TINY_LENGTH, Vector, cross, difference, normal_of
from tatamu.simulators.native.options import ContactOptions

CONE = 0.1
"""A corner counts as the one nearest to a triangle if the normal leaves its normal cone by no more than this sine:
several corners of a face that is nearly level with the triangle then share the load."""
LEVER = 2.0
"""No vertex is moved by more than this times the push [-]: next to a held vertex, a push has a short lever."""
CLEAR = 0.98
"""Edges and faces beyond a face of the core by this part of the gap are left to their vertices."""


class Frame(NamedTuple):
    """One body in one round."""

    half: np.ndarray
    """Half sizes of the core [m], shape (3,)."""
    radius: float
    rotation: np.ndarray
    """To the world, at the end of the round, shape (3, 3)."""
    position: np.ndarray
    """Of the centre, at the end of the round [m], shape (3,)."""
    rotation0: np.ndarray
    """At the start of the round."""
    position0: np.ndarray
    """At the start of the round."""
    local: np.ndarray
    """Vertices near the body in its frame, at the end of the round [m], shape (n, 3)."""
    local0: np.ndarray
    """The same at its start."""


class Rule(NamedTuple):
    """How far pairs are pushed in a sweep, and what is noted of it."""

    wanted: float
    """Gap that this sweep restores [m]."""
    clearing: float
    """How far a pair may come apart that was too close at the start [m]."""
    recovery: float
    """How far of that as velocity [m]."""
    friction: float
    """Coulomb coefficient [-]."""
    noticeable: float
    """Pushes beyond this make the next sweep look again [m]."""
    hard: float
    """Pushes beyond this make vertices restless [m]."""
    sweep: int
    """Number of the sweep."""
    restless_until: int
    """Number of an outer step."""
    passing: float
    """How far beyond a gap a pair may be that has passed through the body in this round [m]; 0 if none can have."""


@kernel
def _to_frame(rotation: np.ndarray, position: np.ndarray, x: np.ndarray, v: int, local: np.ndarray) -> None:
    """Write vertex v in the frame of a body [m]."""
    dx = x[v, 0] - position[0]
    dy = x[v, 1] - position[1]
    dz = x[v, 2] - position[2]
    for k in range(3):
        local[v, k] = rotation[0, k] * dx + rotation[1, k] * dy + rotation[2, k] * dz


@kernel
def _enter(frame: Frame, positions: Positions, near: np.ndarray) -> float:
    """Write the vertices near a body in its frame; the longest way of one in it [m]."""
    longest = 0.0
    for i in range(near.shape[0]):
        v = near[i]
        _to_frame(frame.rotation, frame.position, positions.x, v, frame.local)
        _to_frame(frame.rotation0, frame.position0, positions.start, v, frame.local0)
        square = 0.0
        for k in range(3):
            square += (frame.local[v, k] - frame.local0[v, k]) ** 2
        longest = max(longest, square)
    return np.sqrt(longest)


@kernel
def _beyond_a_face(local: np.ndarray, a: int, b: int, c: int, half: np.ndarray, far: float) -> bool:
    """Whether three vertices are all beyond one face of the core by that much [m]."""
    for k in range(3):
        if min(local[a, k], local[b, k], local[c, k]) >= half[k] + far:
            return True
        if max(local[a, k], local[b, k], local[c, k]) <= -half[k] - far:
            return True
    return False


@kernel
def _between(local: np.ndarray, corners: tuple[int, int, int], weights: Vector) -> Vector:
    """A point of the cloth by its barycentric coordinates [m]."""
    a, b, c = corners
    wa, wb, wc = weights
    return (
        wa * local[a, 0] + wb * local[b, 0] + wc * local[c, 0],
        wa * local[a, 1] + wb * local[b, 1] + wc * local[c, 1],
        wa * local[a, 2] + wb * local[b, 2] + wc * local[c, 2],
    )


@kernel
def _gap(frame: Frame, corners: tuple[int, int, int], weights: Vector) -> tuple[float, float, Vector]:
    """Gap of a point of the cloth [m], its gap at the start [m], and the normal that both are measured along.

    A point that passed through the body is measured from the tangent plane of the side that it came from. It did if its
    way is longer than both of its distances, and the normals at both ends point against one another.
    """
    px, py, pz = _between(frame.local, corners, weights)
    qx, qy, qz = _between(frame.local0, corners, weights)
    d, nx, ny, nz = distance(frame.half, frame.radius, px, py, pz)
    d0, mx, my, mz = distance(frame.half, frame.radius, qx, qy, qz)
    if nx * mx + ny * my + nz * mz < 0.0:
        wx = px - qx
        wy = py - qy
        wz = pz - qz
        if d + d0 < np.sqrt(wx * wx + wy * wy + wz * wz):
            return d0 + wx * mx + wy * my + wz * mz, d0, (mx, my, mz)
    return d, d0, (nx, ny, nz)


@kernel
def _correct(
    positions: Positions,
    inverse_mass: np.ndarray,
    activity: Activity,
    frame: Frame,
    rule: Rule,
    corners: tuple[int, int, int],
    weights: Vector,
    gap: float,
    gap_at_start: float,
    normal: Vector,
) -> float:
    """Push a point of the cloth out of a body, and hold it by friction.

    Args:
        positions: Positions to correct.
        inverse_mass: Of the vertices [1/kg].
        activity: Written where the push is noticeable or hard.
        frame: The body; its positions of the vertices are kept up to date.
        rule: How far to push.
        corners: Vertices that the point lies between.
        weights: Its barycentric coordinates.
        gap: How far it is from the body [m].
        gap_at_start: How far it was at the start of the round [m].
        normal: From the body to the cloth.

    Returns:
        The gap before [m], `rule.wanted` if that was enough.
    """
    push = min(rule.wanted, gap_at_start + rule.clearing) - gap
    a, b, c = corners
    wa, wb, wc = weights
    weight = wa * wa * inverse_mass[a] + wb * wb * inverse_mass[b] + wc * wc * inverse_mass[c]
    if push <= 0.0 or weight == 0.0:
        return rule.wanted
    position_only = push - max(min(rule.wanted, gap_at_start + rule.recovery) - gap, 0.0)
    nx, ny, nz = normal
    px, py, pz = _between(frame.local, corners, weights)
    qx, qy, qz = _between(frame.local0, corners, weights)
    sx = px - qx
    sy = py - qy
    sz = pz - qz
    along = sx * nx + sy * ny + sz * nz
    sx -= along * nx
    sy -= along * ny
    sz -= along * nz
    slip = np.sqrt(sx * sx + sy * sy + sz * sz) + TINY_LENGTH
    held = min(1.0, rule.friction * push / slip)
    lx = push * nx - held * sx
    ly = push * ny - held * sy
    lz = push * nz - held * sz
    lever = 1.0
    for v, w in ((a, wa), (b, wb), (c, wc)):
        lever = min(lever, LEVER * weight / (w * inverse_mass[v] + TINY_LENGTH))
    for v, w in ((a, wa), (b, wb), (c, wc)):
        part = lever * w * inverse_mass[v] / weight
        if part == 0.0:
            continue
        if push > rule.noticeable:
            activity.touched[v] = rule.sweep
        if push > rule.hard:
            activity.restless[v] = rule.restless_until
        for k in range(3):
            r = frame.rotation[k]
            positions.x[v, k] += part * (r[0] * lx + r[1] * ly + r[2] * lz)
            if position_only > 0.0:
                positions.predicted[v, k] += part * position_only * (r[0] * nx + r[1] * ny + r[2] * nz)
        frame.local[v, 0] += part * lx
        frame.local[v, 1] += part * ly
        frame.local[v, 2] += part * lz
    return gap


@kernel
def _vertices(
    positions: Positions, mesh: ContactMesh, activity: Activity, frame: Frame, rule: Rule, near: np.ndarray
) -> float:
    """Correct the vertices near a body; the smallest gap [m]."""
    smallest = rule.wanted
    clear = rule.wanted + frame.radius + rule.passing
    weights = (1.0, 0.0, 0.0)
    for i in range(near.shape[0]):
        v = near[i]
        if _beyond_a_face(frame.local, v, v, v, frame.half, clear):
            continue
        corners = (v, v, v)
        gap, gap_at_start, normal = _gap(frame, corners, weights)
        if gap < rule.wanted:
            found = _correct(
                positions, mesh.inverse_mass, activity, frame, rule, corners, weights, gap, gap_at_start, normal
            )
            smallest = min(smallest, found)
    return smallest


@kernel
def _edges(
    positions: Positions, mesh: ContactMesh, activity: Activity, frame: Frame, rule: Rule, near: np.ndarray
) -> float:
    """Correct the insides of the edges near a body; the smallest gap [m]."""
    smallest = rule.wanted
    clear = CLEAR * rule.wanted + frame.radius + rule.passing
    within = rule.wanted + rule.passing
    for i in range(near.shape[0]):
        a, b = mesh.edges[near[i], 0], mesh.edges[near[i], 1]
        if _beyond_a_face(frame.local, a, b, b, frame.half, clear):
            continue
        s = along_edge(frame.half, frame.radius, frame.local[a], frame.local[b], within)
        if s < 0.0:
            continue
        corners = (a, b, b)
        weights = (1.0 - s, s, 0.0)
        gap, gap_at_start, normal = _gap(frame, corners, weights)
        if gap < rule.wanted:
            found = _correct(
                positions, mesh.inverse_mass, activity, frame, rule, corners, weights, gap, gap_at_start, normal
            )
            smallest = min(smallest, found)
    return smallest


@kernel
def _normal(local: np.ndarray, a: int, b: int, c: int) -> tuple[float, float, float, float]:
    """Unit normal of a triangle, and height of the origin, the centre of the body, over its plane [m]."""
    nx, ny, nz = normal_of(local, a, b, c)
    scale = 1.0 / (np.sqrt(nx * nx + ny * ny + nz * nz) + TINY_LENGTH)
    nx *= scale
    ny *= scale
    nz *= scale
    return nx, ny, nz, -(nx * local[a, 0] + ny * local[a, 1] + nz * local[a, 2])


@kernel
def _in_cone(corner: np.ndarray, nx: float, ny: float, nz: float) -> bool:
    """Whether a corner of the core is the one that is farthest in direction n, or nearly."""
    return (
        nx * corner[0] >= -CONE * abs(corner[0])
        and ny * corner[1] >= -CONE * abs(corner[1])
        and nz * corner[2] >= -CONE * abs(corner[2])
    )


@kernel
def _weights_at(local: np.ndarray, a: int, b: int, c: int, point: np.ndarray) -> Vector:
    """Barycentric coordinates of the projection of a point on a triangle."""
    nx, ny, nz = normal_of(local, a, b, c)
    square = nx * nx + ny * ny + nz * nz + TINY_LENGTH
    px = point[0] - local[a, 0]
    py = point[1] - local[a, 1]
    pz = point[2] - local[a, 2]
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
    """Correct the insides of the faces near a body, where a corner of its core is over them; the smallest gap [m]."""
    smallest = rule.wanted
    clear = CLEAR * rule.wanted + frame.radius + rule.passing
    local = frame.local
    half = frame.half
    for i in range(near.shape[0]):
        a, b, c = mesh.faces[near[i], 0], mesh.faces[near[i], 1], mesh.faces[near[i], 2]
        if _beyond_a_face(local, a, b, c, half, clear):
            continue
        nx, ny, nz, height = _normal(local, a, b, c)
        wide = abs(nx) * half[0] + abs(ny) * half[1] + abs(nz) * half[2] + frame.radius
        if abs(height) - wide >= rule.wanted + rule.passing:
            continue
        mx, my, mz, height0 = _normal(frame.local0, a, b, c)
        side = 1.0 if height0 >= 0.0 else -1.0
        for q in range(points.shape[0]):
            point = points[q]
            if not _in_cone(point, -side * nx, -side * ny, -side * nz):
                continue
            gap = side * (height + nx * point[0] + ny * point[1] + nz * point[2]) - frame.radius
            if gap >= rule.wanted or gap < -2.0 * wide:
                continue
            weights = _weights_at(local, a, b, c, point)
            if min(weights[0], weights[1], weights[2]) < 0.0:
                continue
            gap_at_start = side * (height0 + mx * point[0] + my * point[1] + mz * point[2]) - frame.radius
            normal = (-side * nx, -side * ny, -side * nz)
            found = _correct(
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
    """One Gauss-Seidel sweep over all bodies: vertices, then edges, then faces of the cloth near each.

    Args:
        positions: Positions to correct, and those that they came from.
        mesh: The mesh.
        contact: Activity is written.
        bodies: The bodies, with their poses of this round and candidates.
        options: How far positions are corrected.
        step: Time since the start of the round [s].
        restored: Part of the gap that this sweep restores.

    Returns:
        The smallest gap found before it was corrected, at most the one that is kept [m].
    """
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
        way = _enter(frame, positions, vertices)
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
