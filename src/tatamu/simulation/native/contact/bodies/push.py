"""Correction of one point of the cloth against one body in one round of contact, with Coulomb friction.

Vectors are in the frame of the body, in which it is at rest whether it moves or turns. Names with a 0 refer to the
start of the round, and others to its end.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tatamu.simulation.native.compiled import kernel
from tatamu.simulation.native.contact.bodies.rounded_box import distance
from tatamu.simulation.native.contact.projection import Positions
from tatamu.simulation.native.contact.state import Activity
from tatamu.simulation.native.geometry import TINY_LENGTH, Vector


class Frame(NamedTuple):
    """One body in one round of contact, and the cloth in its frame."""

    half: np.ndarray
    """Half sizes of the core [m], shape (3,)."""
    radius: float
    rotation: np.ndarray
    """Rotation from the frame of the body to the world, shape (3, 3)."""
    position: np.ndarray
    """Centre of the body [m], shape (3,)."""
    rotation0: np.ndarray
    position0: np.ndarray
    local: np.ndarray
    """Positions of the vertices in the frame of the body [m], shape (n, 3), up to date only near the body."""
    local0: np.ndarray


class Rule(NamedTuple):
    """The limits by which points of the cloth are pushed out of a body in one sweep."""

    wanted: float
    """Gap between cloth and body that this sweep restores [m]."""
    clearing: float
    """Maximum correction of a point that was too close at the start of the round [m]."""
    recovery: float
    """Maximum increase of such a point's gap that becomes velocity [m]; the rest only changes its position."""
    friction: float
    """Coulomb coefficient of cloth on the body [-]."""
    noticeable: float
    """Push above which the next sweep tests the vertices again [m]."""
    hard: float
    """Push above which the vertices become restless [m]."""
    sweep: int
    """Index of this sweep."""
    restless_until: int
    """Last outer step in which vertices that are pushed hard now are restless."""
    passing: float
    """Maximum depth of a point that has passed through the body, its longest motion [m]; 0 if none can have passed."""


@kernel
def to_frame(rotation: np.ndarray, position: np.ndarray, x: np.ndarray, v: int, local: np.ndarray) -> None:
    """Write the position of vertex v in the frame of a body to `local` [m]."""
    dx = x[v, 0] - position[0]
    dy = x[v, 1] - position[1]
    dz = x[v, 2] - position[2]
    for k in range(3):
        local[v, k] = rotation[0, k] * dx + rotation[1, k] * dy + rotation[2, k] * dz


@kernel
def enter(frame: Frame, positions: Positions, near: np.ndarray) -> float:
    """Compute the positions of vertices near a body in its frame, and return their longest motion [m]."""
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
    """Return whether three vertices are all outside the same face of a core by at least `far` [m]."""
    for k in range(3):
        if min(local[a, k], local[b, k], local[c, k]) >= half[k] + far:
            return True
        if max(local[a, k], local[b, k], local[c, k]) <= -half[k] - far:
            return True
    return False


@kernel
def between(local: np.ndarray, corners: tuple[int, int, int], weights: Vector) -> Vector:
    """Return a point of the cloth [m] from its barycentric coordinates `weights`."""
    a, b, c = corners
    wa, wb, wc = weights
    return (
        wa * local[a, 0] + wb * local[b, 0] + wc * local[c, 0],
        wa * local[a, 1] + wb * local[b, 1] + wc * local[c, 1],
        wa * local[a, 2] + wb * local[b, 2] + wc * local[c, 2],
    )


@kernel
def gap_of(frame: Frame, corners: tuple[int, int, int], weights: Vector) -> tuple[float, float, Vector]:
    """Return the gap between a point and a body, its gap at the round's start [m], and the normal (see `bodies`)."""
    px, py, pz = between(frame.local, corners, weights)
    qx, qy, qz = between(frame.local0, corners, weights)
    d, nx, ny, nz = distance(frame.half, frame.radius, px, py, pz)
    d0, mx, my, mz = distance(frame.half, frame.radius, qx, qy, qz)
    if nx * mx + ny * my + nz * mz < 0.0:
        wx, wy, wz = px - qx, py - qy, pz - qz
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
    """Push a point of the cloth out of a body, hold it by friction, and return its gap before the push [m].

    The point lies between `corners` with the barycentric coordinates `weights`. If it is not pushed, `rule.wanted` is
    returned.
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
    sx, sy, sz = px - qx, py - qy, pz - qz
    along = sx * nx + sy * ny + sz * nz
    sx, sy, sz = sx - along * nx, sy - along * ny, sz - along * nz
    slip = np.sqrt(sx * sx + sy * sy + sz * sz) + TINY_LENGTH
    held = min(1.0, rule.friction * push / slip)
    lx, ly, lz = push * nx - held * sx, push * ny - held * sy, push * nz - held * sz
    lever = 1.0
    for v, w in ((a, wa), (b, wb), (c, wc)):
        # without a limit, a push near a held vertex would move the free ones much farther than the point
        lever = min(lever, 2.0 * weight / (w * inverse_mass[v] + TINY_LENGTH))
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
