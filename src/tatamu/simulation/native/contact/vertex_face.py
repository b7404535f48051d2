"""Narrow phase and correction of vertices against triangles, with Coulomb friction (docs/theory/contact.md).

When the cloth slides over a partner of `vertex_face_search`, the neighbouring triangle becomes the partner. The side of
a vertex is determined at the start of the step, where it is correct, and never from predicted positions. With the
inverse masses w_v of the vertex and w_k of the corners, and barycentric coordinates b_k, the impulses are:

    W   = w_v + sum b_k^2 w_k                       inverse mass seen by the contact
    l_n = (target - gap) / W,   l_t = min(|slip| / W, mu l_n)

Slip is measured from the *friction anchor*, the point of the triangle where the vertex started to stick, and not from
the start of the step. If the table or another layer undoes a correction, the next step corrects it again, so layers at
rest do not creep.

If a hand holds the vertex and a corner of the triangle, the pair is not corrected, because contact so close to the hand
would act like a clamp that bends the layers as one plate.
"""

from __future__ import annotations

import numpy as np

from tatamu.simulation.native.compiled import kernel
from tatamu.simulation.native.contact.motion import of_vertex_and_face
from tatamu.simulation.native.contact.projection import Positions, correction, move
from tatamu.simulation.native.contact.state import PARTNERS, ContactMesh, ContactState
from tatamu.simulation.native.geometry import TINY_LENGTH, Vector, cross, difference, normal_of
from tatamu.simulation.native.options import ContactOptions


@kernel
def _barycentric(
    x: np.ndarray, v: int, a: int, b: int, c: int
) -> tuple[float, float, float, float, float, float, float]:
    """Return the projection of v on a triangle in barycentric coordinates, the unit normal, and the height of v [m]."""
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
    nx, ny, nz = nx / length, ny / length, nz / length
    return 1.0 - bb - bc, bb, bc, nx, ny, nz, nx * px + ny * py + nz * pz


@kernel
def _height(x: np.ndarray, v: int, a: int, b: int, c: int) -> float:
    """Return the height of vertex v over the plane of triangle (a, b, c) [m]."""
    nx, ny, nz = normal_of(x, a, b, c)
    px, py, pz = difference(x, v, a)
    length = np.sqrt(nx * nx + ny * ny + nz * nz) + TINY_LENGTH
    return (nx * px + ny * py + nz * pz) / length


@kernel
def _slip(x: np.ndarray, v: int, a: int, b: int, c: int, at: Vector, nx: float, ny: float, nz: float) -> Vector:
    """Return the vector to vertex v from the point `at` (barycentric) of a triangle [m], projected into its plane."""
    sx = x[v, 0] - at[0] * x[a, 0] - at[1] * x[b, 0] - at[2] * x[c, 0]
    sy = x[v, 1] - at[0] * x[a, 1] - at[1] * x[b, 1] - at[2] * x[c, 1]
    sz = x[v, 2] - at[0] * x[a, 2] - at[1] * x[b, 2] - at[2] * x[c, 2]
    along = sx * nx + sy * ny + sz * nz
    return sx - along * nx, sy - along * ny, sz - along * nz


@kernel
def _back_to_back(x: np.ndarray, faces: np.ndarray, s: int, t: int) -> bool:
    """Return whether two triangles lie back to back, like the two layers at a seam."""
    ax, ay, az = normal_of(x, faces[s, 0], faces[s, 1], faces[s, 2])
    bx, by, bz = normal_of(x, faces[t, 0], faces[t, 1], faces[t, 2])
    return ax * bx + ay * by + az * bz < 0.0


@kernel
def _list_awake(contact: ContactState, faces: np.ndarray) -> int:
    """List the pairs that may be too close, sorted by the height of their vertices, and return their count."""
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
    """Make one Gauss-Seidel sweep over all vertices with partners, and return the minimum gap [m], at most a thickness.

    Vertices are visited from the highest down, so that each layer of a stack passes all of its weight to the next
    layer. The function is long, because separate functions for narrow phase and friction made a rollout take 1.08 to
    1.19 times as long, or 1.8 times as long with records as arguments.
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
        for _ in range(4):  # moves to a neighbouring triangle in one sweep
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
                break  # the vertex has this triangle as another partner already, as in a crease
            t = beyond
            if faces[t, 0] == v or faces[t, 1] == v or faces[t, 2] == v:
                break
        beside = lowest < inside
        if beside and (faces[t, 0] == v or faces[t, 1] == v or faces[t, 2] == v):
            continue
        if beside or triangle[v, k] != t:  # after a move over a sharp crease, the remembered side may be wrong
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
            if first and gap > 1.1 * thickness:  # pairs that are farther apart sleep
                anchor_triangle[v, k] = -1
                # the way by which the pair may approach before it is tested again
                far = 0.8 * (side * _height(start, v, a, b, c) - thickness)
                wake[v, k] = counters.longest_path + far
                meets[v, k] = of_vertex_and_face(path, v, a, b, c) + far
            continue

        # Length of the push.
        if inverse_mass[v] == 0.0 and min(inverse_mass[a], inverse_mass[b], inverse_mass[c]) == 0.0:
            continue  # if both layers are held, the hand determines their distance
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
        nx, ny, nz = side * nx, side * ny, side * nz

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
        if first and lag < 1.0:  # the vertex slides and drags the anchor along; the next step can hold this lag
            anchor[v, k, 0] = ba + lag * (at[0] - ba)
            anchor[v, k, 1] = bb + lag * (at[1] - bb)
            anchor[v, k, 2] = bc + lag * (at[2] - bc)

        # Correct each vertex in proportion to its inverse mass.
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
