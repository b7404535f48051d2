"""Cloth against cloth: vertices against triangles; edges against edges are in `pairs`.

Every vertex has two slots, one per side, for the nearest triangle that is not its own, and a third one (`nearest`). A
slot walks from triangle to triangle as the cloth slides, and remembers on which side of the triangle the vertex is.
Positions are corrected so that layers stay a thickness apart; the tangential part of a correction is Coulomb
friction:

    W   = w_v + sum b_k^2 w_k                       inverse mass seen by the contact, barycentric b
    l_n = (target - gap) / W,   l_t = min(|slip| / W, mu l_n)

Pairs that a hand holds on both sides are left to the hand: near it a push has no lever, and would turn the pinch
into a clamp that bends the layers as one plate.

slip is measured from where the vertex began to stick, not from the last step: what the table or another layer undoes
of a correction is then corrected in the next step, so that layers at rest do not creep.

Which side a pair is on is always read off the previous, legal positions, never off the moved ones.
Derived in docs/theory/contact.md.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from tatamu.simulators.native.contact import edge_edge as pairs
from tatamu.simulators.native.contact.broad_phase import PRESSED_FOR
from tatamu.simulators.native.contact.projection import HARD, NOTICEABLE, RESTLESS_FOR, pushes, shift
from tatamu.simulators.native.geometry import cross, normal_of

INSIDE = -0.02
"""A barycentric coordinate above this counts as inside the triangle."""
PRESSED = 0.6
"""Layers closer than this part of a thickness are pressed: their edges are guarded as well."""
KEEP = (1.0, 0.5, 0.5, 0.3, 0.3, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2)
"""Part of a thickness that each sweep restores. The first wants all of it; later ones, made only while some pair is
still closer, want less: layers that a hand crushes have no room for all, but always for not passing through."""


@njit(cache=True, error_model="numpy")
def _barycentric(x, v, a, b, c):  # type: ignore[no-untyped-def]
    """Coordinates of v's projection on triangle (a, b, c), its unit normal, and v's height over it."""
    nx, ny, nz = normal_of(x, a, b, c)
    square = nx * nx + ny * ny + nz * nz + 1e-30
    px, py, pz = x[v, 0] - x[a, 0], x[v, 1] - x[a, 1], x[v, 2] - x[a, 2]
    ux, uy, uz = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
    wx, wy, wz = x[c, 0] - x[a, 0], x[c, 1] - x[a, 1], x[c, 2] - x[a, 2]
    qx, qy, qz = cross(px, py, pz, wx, wy, wz)
    rx, ry, rz = cross(ux, uy, uz, px, py, pz)
    bb = (qx * nx + qy * ny + qz * nz) / square
    bc = (rx * nx + ry * ny + rz * nz) / square
    length = np.sqrt(square)
    nx, ny, nz = nx / length, ny / length, nz / length
    return 1.0 - bb - bc, bb, bc, nx, ny, nz, nx * px + ny * py + nz * pz


@njit(cache=True, error_model="numpy")
def _height(x, v, a, b, c):  # type: ignore[no-untyped-def]
    nx, ny, nz = normal_of(x, a, b, c)
    length = np.sqrt(nx * nx + ny * ny + nz * nz) + 1e-30
    return (nx * (x[v, 0] - x[a, 0]) + ny * (x[v, 1] - x[a, 1]) + nz * (x[v, 2] - x[a, 2])) / length


@njit(cache=True, error_model="numpy")
def _slip(x, v, a, b, c, pa, pb, pc, nx, ny, nz):  # type: ignore[no-untyped-def]
    """How far v is from its anchor (pa, pb, pc) on the triangle (a, b, c), along the triangle."""
    sx = x[v, 0] - pa * x[a, 0] - pb * x[b, 0] - pc * x[c, 0]
    sy = x[v, 1] - pa * x[a, 1] - pb * x[b, 1] - pc * x[c, 1]
    sz = x[v, 2] - pa * x[a, 2] - pb * x[b, 2] - pc * x[c, 2]
    along = sx * nx + sy * ny + sz * nz
    return sx - along * nx, sy - along * ny, sz - along * nz


@njit(cache=True, error_model="numpy")
def _turned_over(x, faces, t, beyond):  # type: ignore[no-untyped-def]
    """Whether two triangles lie back to back, as at a seam: what is above one is not above the other."""
    ax, ay, az = normal_of(x, faces[t, 0], faces[t, 1], faces[t, 2])
    bx, by, bz = normal_of(x, faces[beyond, 0], faces[beyond, 1], faces[beyond, 2])
    return ax * bx + ay * by + az * bz < 0.0


@njit(cache=True, error_model="numpy")
def _sweep_slots(x, before, moved, mesh, lists, friction, step, keep):  # type: ignore[no-untyped-def]
    """One pass over all slots that restores `keep` of the thickness; the smallest gap seen before.

    From the highest vertex down, so that each layer of a stack hands all of its weight to the next.
    In one piece, long as it is: cut into functions that hand the records on, a rollout took 1.8 times as long.
    """
    faces, thickness, inverse_mass = mesh.faces, mesh.reach[0], mesh.inverse_mass
    wanted, smallest = keep * thickness, thickness
    touched, last, noticeable = lists.touched, lists.sweeps[0] - 1, NOTICEABLE * thickness
    restless, until, hard = lists.restless, lists.number[0] + RESTLESS_FOR, HARD * thickness
    anchor = lists.anchor
    for v in lists.order[: lists.ordered[0]]:
        for s in range(lists.face.shape[1]):
            t = lists.face[v, s]
            if t < 0 or lists.wake[v, s] > lists.travelled[0]:
                continue
            a, b, c = faces[t, 0], faces[t, 1], faces[t, 2]
            if keep < 1.0 and touched[v] < last and touched[a] < last and touched[b] < last and touched[c] < last:
                continue  # nothing has changed here since the last sweep
            for _ in range(4):
                a, b, c = faces[t, 0], faces[t, 1], faces[t, 2]
                ba, bb, bc, nx, ny, nz, height = _barycentric(x, v, a, b, c)
                corner = 0 if ba <= bb and ba <= bc else (1 if bb <= bc else 2)
                lowest = min(ba, bb, bc)
                if lowest >= INSIDE:
                    break
                beyond = mesh.neighbours[t, corner]
                if beyond < 0 or _turned_over(x, faces, t, beyond):
                    break
                if beyond == lists.face[v, s - 1] or beyond == lists.face[v, s - 2]:
                    break  # another slot is there: within a crease a vertex is kept from both of its sides
                t = beyond
                if faces[t, 0] == v or faces[t, 1] == v or faces[t, 2] == v:
                    break
            if lowest < INSIDE:
                if faces[t, 0] == v or faces[t, 1] == v or faces[t, 2] == v:
                    continue
                lists.face[v, s] = t
                lists.side[v, s] = 0
                continue
            if lists.face[v, s] != t:  # beyond a sharp crease the old side may be the wrong one
                lists.face[v, s] = t
                lists.side[v, s] = 0
            if lists.side[v, s] == 0:
                lists.side[v, s] = 1 if _height(before, v, a, b, c) >= 0.0 else -1
            side = lists.side[v, s]
            gap = side * height
            if gap >= wanted:
                if keep == 1.0 and gap > 1.1 * thickness:
                    lists.anchor_face[v, s] = -1
                    lists.wake[v, s] = lists.travelled[0] + 0.8 * (gap - thickness)
                continue
            weight = inverse_mass[v] + ba * ba * inverse_mass[a] + bb * bb * inverse_mass[b] + bc * bc * inverse_mass[c]
            if inverse_mass[v] == 0.0 and min(inverse_mass[a], inverse_mass[b], inverse_mass[c]) == 0.0:
                continue  # where both layers are held, the hand decides how far they are apart
            push, silent = pushes(gap, side * _height(before, v, a, b, c), wanted, step)
            if push <= 0.0:
                continue
            smallest = min(smallest, gap)
            if gap < PRESSED * thickness and keep == 1.0:
                for o in (v, a, b, c):
                    lists.call[0] |= lists.pressed[o] == 0
                    lists.pressed[o] = PRESSED_FOR
            silent /= weight
            if push > noticeable:
                touched[v] = touched[a] = touched[b] = touched[c] = last + 1
            if push > hard:
                restless[v] = restless[a] = restless[b] = restless[c] = until
            nx, ny, nz = side * nx, side * ny, side * nz
            if lists.anchor_face[v, s] != t:
                lists.anchor_face[v, s] = t
                anchor[v, s, 0], anchor[v, s, 1], anchor[v, s, 2] = _barycentric(before, v, a, b, c)[:3]
            pa, pb, pc = anchor[v, s, 0], anchor[v, s, 1], anchor[v, s, 2]
            sx, sy, sz = _slip(x, v, a, b, c, pa, pb, pc, nx, ny, nz)
            slip = np.sqrt(sx * sx + sy * sy + sz * sz) + 1e-30
            held = min(1.0, friction * push / slip)
            lag = 2.0 * friction * push / slip
            if keep == 1.0 and lag < 1.0:  # slides: drags the anchor along, as far behind as the next step can hold
                anchor[v, s, 0] = ba + lag * (pa - ba)
                anchor[v, s, 1] = bb + lag * (pb - bb)
                anchor[v, s, 2] = bc + lag * (pc - bc)
            px = (push * nx - held * sx) / weight
            py = (push * ny - held * sy) / weight
            pz = (push * nz - held * sz) / weight
            fv, fa, fb, fc = inverse_mass[v], -ba * inverse_mass[a], -bb * inverse_mass[b], -bc * inverse_mass[c]
            shift(x, v, fv, px, py, pz)
            shift(x, a, fa, px, py, pz)
            shift(x, b, fb, px, py, pz)
            shift(x, c, fc, px, py, pz)
            if silent > 0.0:
                shift(moved, v, fv * silent, nx, ny, nz)
                shift(moved, a, fa * silent, nx, ny, nz)
                shift(moved, b, fb * silent, nx, ny, nz)
                shift(moved, c, fc * silent, nx, ny, nz)
    return smallest


@njit(cache=True, error_model="numpy")
def sweep(x, before, moved, mesh, lists, friction, step, keep):  # type: ignore[no-untyped-def]
    """Push pairs apart once.

    Args:
        x: Positions to correct [m], shape (n, 3).
        before: Legal positions at the start of the step [m], shape (n, 3).
        moved: Reference for the change of velocity [m], shape (n, 3); shifted by what shall not become velocity.
        mesh: The mesh.
        lists: Its candidate pairs.
        friction: Coulomb coefficient of cloth on cloth.
        step: Outer step [s].
        keep: Part of the thickness to restore.

    Returns:
        Smallest gap found before it was corrected, as part of what the pair should keep.
    """
    lists.sweeps[0] += 1
    edge_gap = pairs.sweep(x, before, moved, mesh, lists, step, keep)
    gap = _sweep_slots(x, before, moved, mesh, lists, friction, step, keep)
    return min(gap, edge_gap / pairs.EDGE_GAP) / mesh.reach[0]
