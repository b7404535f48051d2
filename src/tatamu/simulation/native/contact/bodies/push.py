"""Corrects one point of the cloth against one body in one round of contact, with Coulomb friction.

All vectors are in the frame of the body. Names with a 0 refer to the start of the round, other names to its end. In its
own frame, the body is at rest. Therefore the slip is computed in the same way whether the body moves, turns or neither.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tatamu.simulation.native.compiled import kernel
from tatamu.simulation.native.contact.bodies.rounded_box import distance
from tatamu.simulation.native.contact.projection import Positions
from tatamu.simulation.native.contact.state import Activity
from tatamu.simulation.native.geometry import TINY_LENGTH, Vector

LEVER = 2.0
"""Largest motion of a vertex by one push, as a multiple of the length of the push [-].

The limit matters if a point near a held vertex is pushed. Without the limit, the free vertices of the point's edge or
triangle would move much farther than the point."""


class Frame(NamedTuple):
    """One body in one round of contact, and the positions of the cloth in the frame of this body."""

    half: np.ndarray
    """Half sizes of the core of the body [m], shape (3,)."""
    radius: float
    rotation: np.ndarray
    """Rotation from the frame of the body to the world frame, at the end of the round, shape (3, 3)."""
    position: np.ndarray
    """Position of the body's centre at the end of the round [m], shape (3,)."""
    rotation0: np.ndarray
    """Rotation from the frame of the body to the world frame, at the start of the round, shape (3, 3)."""
    position0: np.ndarray
    """Position of the body's centre at the start of the round [m], shape (3,)."""
    local: np.ndarray
    """Positions of the n vertices in the frame of the body at the end of the round [m], shape (n, 3).

    Only the vertices near the body are up to date."""
    local0: np.ndarray
    """Positions of the n vertices in the frame of the body at the start of the round [m], shape (n, 3).

    Only the vertices near the body are up to date."""


class Rule(NamedTuple):
    """The rule by which points of the cloth are pushed out of a body in one sweep."""

    wanted: float
    """Gap between cloth and body that this sweep restores [m]."""
    clearing: float
    """Largest correction of a point in one round, if the point was too close at the start of the round [m]."""
    recovery: float
    """Largest increase of a point's gap in one round that also changes the velocity of the cloth [m].

    A point of the cloth that was too close to the body at the start of the round is pushed away from the body. The gap
    may increase by more than this length. Then the rest of the increase changes only the position of the point."""
    friction: float
    """Coulomb coefficient of cloth on the body [-]."""
    noticeable: float
    """Largest push that is negligible [m]. After a longer push, the next sweep tests the pushed vertices again."""
    hard: float
    """Largest push that counts as gentle [m].

    After a longer push, the pushed vertices are restless, which means that they are tested for passing through
    cloth."""
    sweep: int
    """Number of this Gauss-Seidel sweep of contact."""
    restless_until: int
    """Number of the last outer step in which vertices that are pushed hard now are restless."""
    passing: float
    """Largest possible depth of a point that has passed through the body [m]. It is 0 if no point can have passed.

    If a point can have passed, the value is the longest motion of a vertex relative to the body in this round."""


@kernel
def to_frame(rotation: np.ndarray, position: np.ndarray, x: np.ndarray, v: int, local: np.ndarray) -> None:
    """Write the position of vertex v, in the frame of a body, to `local` [m]."""
    dx = x[v, 0] - position[0]
    dy = x[v, 1] - position[1]
    dz = x[v, 2] - position[2]
    for k in range(3):
        local[v, k] = rotation[0, k] * dx + rotation[1, k] * dy + rotation[2, k] * dz


@kernel
def enter(frame: Frame, positions: Positions, near: np.ndarray) -> float:
    """Compute the positions of the vertices near a body in its frame, and return their longest motion [m]."""
    longest = 0.0
    for i in range(near.shape[0]):
        v = near[i]
        to_frame(frame.rotation, frame.position, positions.x, v, frame.local)
        to_frame(frame.rotation0, frame.position0, positions.start, v, frame.local0)
        square = 0.0
        for k in range(3):
            square += (frame.local[v, k] - frame.local0[v, k]) ** 2
        longest = max(longest, square)
    return np.sqrt(longest)


@kernel
def beyond_a_face(local: np.ndarray, a: int, b: int, c: int, half: np.ndarray, far: float) -> bool:
    """Return whether three vertices are all outside the same face of a body's core by at least `far` [m]."""
    for k in range(3):
        if min(local[a, k], local[b, k], local[c, k]) >= half[k] + far:
            return True
        if max(local[a, k], local[b, k], local[c, k]) <= -half[k] - far:
            return True
    return False


@kernel
def between(local: np.ndarray, corners: tuple[int, int, int], weights: Vector) -> Vector:
    """Return the position of a point of the cloth [m], from its barycentric coordinates `weights`."""
    a, b, c = corners
    wa, wb, wc = weights
    return (
        wa * local[a, 0] + wb * local[b, 0] + wc * local[c, 0],
        wa * local[a, 1] + wb * local[b, 1] + wc * local[c, 1],
        wa * local[a, 2] + wb * local[b, 2] + wc * local[c, 2],
    )


@kernel
def gap_of(frame: Frame, corners: tuple[int, int, int], weights: Vector) -> tuple[float, float, Vector]:
    """Return the gap between a point of the cloth and a body [m], the gap at the round's start [m], and the normal.

    A point counts as passed through the body under two conditions. Its path in the round is longer than the sum of its
    distances at both ends of the path, and the normals at both ends point in opposite directions. The gap of such a
    point is measured from the tangent plane of the body on the side from which the point came.
    """
    px, py, pz = between(frame.local, corners, weights)
    qx, qy, qz = between(frame.local0, corners, weights)
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
def correct(
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
        inverse_mass: Inverse masses of the vertices [1/kg].
        activity: Record of noticeable and hard pushes, which is updated.
        frame: The body, and the positions of vertices in its frame, which are updated.
        rule: Limits of the push.
        corners: Numbers of the three vertices between which the point lies.
        weights: Barycentric coordinates of the point.
        gap: Distance of the point from the body [m].
        gap_at_start: Distance of the point from the body at the start of the round [m].
        normal: Unit vector from the body to the cloth.

    Returns:
        The gap before the push [m], or `rule.wanted` if the point was not pushed.
    """
    push = min(rule.wanted, gap_at_start + rule.clearing) - gap
    a, b, c = corners
    wa, wb, wc = weights
    weight = wa * wa * inverse_mass[a] + wb * wb * inverse_mass[b] + wc * wc * inverse_mass[c]
    if push <= 0.0 or weight == 0.0:
        return rule.wanted
    position_only = push - max(min(rule.wanted, gap_at_start + rule.recovery) - gap, 0.0)
    nx, ny, nz = normal
    px, py, pz = between(frame.local, corners, weights)
    qx, qy, qz = between(frame.local0, corners, weights)
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
