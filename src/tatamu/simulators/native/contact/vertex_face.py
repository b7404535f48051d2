"""Narrow phase and correction of vertices against triangles, with Coulomb friction.

Every vertex has up to three partners, found by `vertex_face_search`. A partner is followed from triangle to triangle as
the cloth slides; on which side of it the vertex is, is remembered, and read off the positions at the start of the step,
which are legal, never off the predicted ones. Positions are corrected so that layers stay a thickness apart; the
tangential part of a correction is friction:

    W   = w_v + sum b_k^2 w_k                       inverse mass seen by the contact, barycentric b
    l_n = (target - gap) / W,   l_t = min(|slip| / W, mu l_n)

Slip is measured from the *friction anchor*, the point of the triangle where the vertex started to stick, not from the
start of the step. If the table or another layer undoes a correction, the next step corrects it again, so layers at rest
do not creep.

Pairs that a hand holds on both sides are left to the hand: near it a push has no lever, and would turn the pinch
into a clamp that bends the layers as one plate. Derived in docs/theory/contact.md.
"""

from __future__ import annotations

import numpy as np

from tatamu.simulators.native.compiled import kernel
from tatamu.simulators.native.contact.motion import of_vertex_and_face
from tatamu.simulators.native.contact.projection import Positions, correction, move
from tatamu.simulators.native.contact.state import PARTNERS, ContactMesh, ContactState
from tatamu.simulators.native.geometry import TINY_LENGTH, Vector, cross, difference, normal_of
from tatamu.simulators.native.options import ContactOptions

MOST_TRIANGLES = 4
"""Triangles that a partner may be followed over in one sweep."""
AWAKE = 1.1
"""Distance in thicknesses up to which a pair is tested in every sweep; others sleep."""
SLEEP = 0.8
"""Part of the distance beyond a thickness after which a sleeping pair is tested again."""


@kernel
def _barycentric(
    x: np.ndarray, v: int, a: int, b: int, c: int
) -> tuple[float, float, float, float, float, float, float]:
    """Coordinates of v's projection on triangle (a, b, c), its unit normal, and v's height over it [m]."""
    nx, ny, nz = normal_of(x, a, b, c)
    square = nx * nx + ny * ny + nz * nz + TINY_LENGTH
    px, py, pz = difference(x, v, a)
    ux, uy, uz = difference(x, b, a)
    wx, wy, wz = difference(x, c, a)
    qx, qy, qz = cross(px, py, pz, wx, wy, wz)
    rx, ry, rz = cross(ux, uy, uz, px, py, pz)
    bb = (qx * nx + qy * ny + qz * nz) / square
    bc = (rx * nx + ry * ny + rz * nz) / square
    length = np.sqrt(square)
    nx = nx / length
    ny = ny / length
    nz = nz / length
    return 1.0 - bb - bc, bb, bc, nx, ny, nz, nx * px + ny * py + nz * pz


@kernel
def _height(x: np.ndarray, v: int, a: int, b: int, c: int) -> float:
    """Height of v over the plane of triangle (a, b, c) [m]."""
    nx, ny, nz = normal_of(x, a, b, c)
    px, py, pz = difference(x, v, a)
    length = np.sqrt(nx * nx + ny * ny + nz * nz) + TINY_LENGTH
    return (nx * px + ny * py + nz * pz) / length


@kernel
def _slip(x: np.ndarray, v: int, a: int, b: int, c: int, at: Vector, nx: float, ny: float, nz: float) -> Vector:
    """Return the offset of v from the point `at` (barycentric) on triangle (a, b, c), in its plane [m]."""
    sx = x[v, 0] - at[0] * x[a, 0] - at[1] * x[b, 0] - at[2] * x[c, 0]
    sy = x[v, 1] - at[0] * x[a, 1] - at[1] * x[b, 1] - at[2] * x[c, 1]
    sz = x[v, 2] - at[0] * x[a, 2] - at[1] * x[b, 2] - at[2] * x[c, 2]
    along = sx * nx + sy * ny + sz * nz
    return sx - along * nx, sy - along * ny, sz - along * nz


@kernel
def _back_to_back(x: np.ndarray, faces: np.ndarray, s: int, t: int) -> bool:
    """Return whether two triangles lie back to back, as at a seam."""
    ax, ay, az = normal_of(x, faces[s, 0], faces[s, 1], faces[s, 2])
    bx, by, bz = normal_of(x, faces[t, 0], faces[t, 1], faces[t, 2])
    return ax * bx + ay * by + az * bz < 0.0


@kernel
def _list_awake(contact: ContactState, faces: np.ndarray) -> int:
    """List the pairs that may be too near, vertices from the highest down; how many they are."""
    triangle = contact.vertex_face.triangle
    order = contact.vertex_face.order
    wake = contact.vertex_face.wake
    meets = contact.vertex_face.meets
    awake = contact.vertex_face.awake
    path = contact.motion.path
    reach = contact.motion.reach
    longest_path = contact.counters.longest_path
    travelled = contact.counters.travelled
    count = 0
    for i in range(contact.counters.ordered):
        v = order[i]
        for k in range(PARTNERS):
            t = triangle[v, k]
            if t < 0 or wake[v, k] > travelled:
                continue
            a, b, c = faces[t, 0], faces[t, 1], faces[t, 2]
            if meets[v, k] <= of_vertex_and_face(reach, v, a, b, c):
                awake[count] = PARTNERS * v + k
                count += 1
            else:
                wake[v, k] = longest_path + meets[v, k] - of_vertex_and_face(path, v, a, b, c)
    return count


@kernel
def sweep(
    positions: Positions,
    mesh: ContactMesh,
    contact: ContactState,
    options: ContactOptions,
    step: float,
    restored: float,
) -> float:
    """One Gauss-Seidel sweep over all vertices with partners.

    Vertices are visited from the highest down, so that each layer of a stack passes all of its weight to the next. The
    function is long for speed: with narrow phase and friction as functions of arrays and numbers, a rollout took 1.08
    to 1.19 times as long, inlined or not; with functions of records, 1.8 times.

    Args:
        positions: Positions to correct, and those at the start.
        mesh: The mesh.
        contact: Partners are followed, anchors set; activity is written.
        options: How far positions are corrected.
        step: Time since the start of the step [s].
        restored: Part of the thickness that this sweep restores.

    Returns:
        Smallest gap found before it was corrected, at most a thickness [m].
    """
    x = positions.x
    start = positions.start
    predicted = positions.predicted
    faces = mesh.faces
    inverse_mass = mesh.inverse_mass
    triangle = contact.vertex_face.triangle
    side_of = contact.vertex_face.side
    wake = contact.vertex_face.wake
    meets = contact.vertex_face.meets
    path = contact.motion.path
    anchor_triangle = contact.vertex_face.anchor_triangle
    anchor = contact.vertex_face.anchor
    touched = contact.activity.touched
    restless = contact.activity.restless
    pressed = contact.activity.pressed
    counters = contact.counters

    thickness = mesh.thickness
    first = restored == 1.0
    wanted = restored * thickness
    smallest = thickness
    noticeable = options.noticeable * thickness
    hard = options.hard * thickness
    pressed_gap = options.pressed * thickness
    clearing = options.clearing_speed * step
    recovery = options.recovery_speed * step
    inside = -options.barycentric_tolerance
    restless_until = counters.outer_step + options.restless_steps
    this_sweep = counters.sweep
    last_sweep = this_sweep - 1

    if first:
        counters.partners_awake = _list_awake(contact, faces)
    awake = contact.vertex_face.awake
    for i in range(counters.partners_awake):
        v, k = awake[i] // PARTNERS, awake[i] % PARTNERS
        t = triangle[v, k]
        a, b, c = faces[t, 0], faces[t, 1], faces[t, 2]
        if not first and (
            touched[v] < last_sweep and touched[a] < last_sweep and touched[b] < last_sweep and touched[c] < last_sweep
        ):
            continue  # nothing has changed here since the last sweep

        # Narrow phase: follow the partner to the triangle that the vertex is over.
        for _ in range(MOST_TRIANGLES):
            a, b, c = faces[t, 0], faces[t, 1], faces[t, 2]
            ba, bb, bc, nx, ny, nz, height = _barycentric(x, v, a, b, c)
            corner = 0 if ba <= bb and ba <= bc else (1 if bb <= bc else 2)
            lowest = min(ba, bb, bc)
            if lowest >= inside:
                break
            beyond = mesh.neighbours[t, corner]
            if beyond < 0 or _back_to_back(x, faces, t, beyond):
                break
            if beyond == triangle[v, k - 1] or beyond == triangle[v, k - 2]:
                break  # another partner: within a crease a vertex is kept from both of its sides
            t = beyond
            if faces[t, 0] == v or faces[t, 1] == v or faces[t, 2] == v:
                break
        beside = lowest < inside
        if beside and (faces[t, 0] == v or faces[t, 1] == v or faces[t, 2] == v):
            continue
        if beside or triangle[v, k] != t:  # beyond a sharp crease the old side may be the wrong one
            triangle[v, k] = t
            side_of[v, k] = 0
            wake[v, k] = 0.0
            meets[v, k] = 0.0
        if beside:
            continue
        if side_of[v, k] == 0:
            side_of[v, k] = 1 if _height(start, v, a, b, c) >= 0.0 else -1
        side = side_of[v, k]
        gap = side * height
        if gap >= wanted:
            if first and gap > AWAKE * thickness:
                anchor_triangle[v, k] = -1
                far = SLEEP * (side * _height(start, v, a, b, c) - thickness)
                wake[v, k] = counters.longest_path + far
                meets[v, k] = of_vertex_and_face(path, v, a, b, c) + far
            continue

        # How far to push.
        if inverse_mass[v] == 0.0 and min(inverse_mass[a], inverse_mass[b], inverse_mass[c]) == 0.0:
            continue  # where both layers are held, the hand decides how far they are apart
        push, position_only = correction(gap, side * _height(start, v, a, b, c), wanted, clearing, recovery)
        if push <= 0.0:
            continue
        smallest = min(smallest, gap)
        if gap < pressed_gap and first:
            for o in (v, a, b, c):
                counters.newly_pressed |= pressed[o] == 0
                pressed[o] = options.pressed_searches
        if push > noticeable:
            touched[v] = this_sweep
            touched[a] = this_sweep
            touched[b] = this_sweep
            touched[c] = this_sweep
        if push > hard:
            restless[v] = restless_until
            restless[a] = restless_until
            restless[b] = restless_until
            restless[c] = restless_until
        nx = side * nx
        ny = side * ny
        nz = side * nz

        # Coulomb friction: towards the anchor, by no more than mu times the push.
        if anchor_triangle[v, k] != t:
            anchor_triangle[v, k] = t
            at_start = _barycentric(start, v, a, b, c)
            anchor[v, k, 0] = at_start[0]
            anchor[v, k, 1] = at_start[1]
            anchor[v, k, 2] = at_start[2]
        at = anchor[v, k, 0], anchor[v, k, 1], anchor[v, k, 2]
        sx, sy, sz = _slip(x, v, a, b, c, at, nx, ny, nz)
        slip = np.sqrt(sx * sx + sy * sy + sz * sz) + TINY_LENGTH
        held = min(1.0, mesh.friction * push / slip)
        lag = 2.0 * mesh.friction * push / slip
        if first and lag < 1.0:  # slides: drags the anchor along, as far behind as the next step can hold
            anchor[v, k, 0] = ba + lag * (at[0] - ba)
            anchor[v, k, 1] = bb + lag * (at[1] - bb)
            anchor[v, k, 2] = bc + lag * (at[2] - bc)

        # Correct, each vertex by its part of the inverse mass.
        weight = inverse_mass[v] + ba * ba * inverse_mass[a] + bb * bb * inverse_mass[b] + bc * bc * inverse_mass[c]
        px = (push * nx - held * sx) / weight
        py = (push * ny - held * sy) / weight
        pz = (push * nz - held * sz) / weight
        wv = inverse_mass[v]
        wa = -ba * inverse_mass[a]
        wb = -bb * inverse_mass[b]
        wc = -bc * inverse_mass[c]
        move(x, v, wv, px, py, pz)
        move(x, a, wa, px, py, pz)
        move(x, b, wb, px, py, pz)
        move(x, c, wc, px, py, pz)
        if position_only > 0.0:
            position_only /= weight
            move(predicted, v, wv * position_only, nx, ny, nz)
            move(predicted, a, wa * position_only, nx, ny, nz)
            move(predicted, b, wb * position_only, nx, ny, nz)
            move(predicted, c, wc * position_only, nx, ny, nz)
    return smallest
