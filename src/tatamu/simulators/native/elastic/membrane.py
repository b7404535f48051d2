"""Membrane: St. Venant-Kirchhoff elasticity on linear triangles, written in squared edge lengths.

    eps_q = |x_b - x_a|^2 - L_q^2            edge q, opposite corner q: exact Green strain along it, no square root
    eps   = P (E_xx, E_yy, 2 E_xy),          rows of P: 2 (dx^2, dy^2, dx dy) of the rest edge
    W     = A/2 E' C E = 1/2 eps' S eps,     S = A P^-T C P^-1, plane stress C with stiffness Y and ratio nu
    f_a   = -2 tau_q (x_a - x_b) - ..,       tau = S eps

Damping is Kelvin-Voigt: lengths and edges are taken at x + tau_d v. Derived in docs/theory/membrane.md.

eps is a small difference of large numbers, so it is taken in double precision; all that follows in single.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from tatamu.material import Material
from tatamu.simulators.native.elastic import wrinkling
from tatamu.simulators.native.memory.bands import BLOCK

ENDS = np.array([[1, 2], [2, 0], [0, 1]])
"""Corners of a triangle that edge q joins, shape (3, 2): the two that are not corner q."""


def rest_frames(rest: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Corners of every triangle in a plane of its own [m], shape (m, 3, 2): corner 0 at 0, corner 1 on +x."""
    a, b, c = (rest[faces[:, k]] for k in range(3))
    length = np.linalg.norm(b - a, axis=1)
    along = (b - a) / length[:, None]
    x = np.einsum("ij,ij->i", c - a, along)
    y = np.linalg.norm((c - a) - x[:, None] * along, axis=1)
    frames = np.zeros((len(faces), 3, 2))
    frames[:, 1, 0] = length
    frames[:, 2, 0], frames[:, 2, 1] = x, y
    return frames


def constants(frames: np.ndarray, material: Material) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of every triangle: S as (S00, S01, S02, S11, S12, S22), doubled for the force, shape (6, m).

    Then L^2 [m^2], shape (3, m), and what cloth that wrinkles needs instead of S, see `wrinkling.constants`.
    """
    edges = frames[:, ENDS[:, 1]] - frames[:, ENDS[:, 0]]
    dx, dy = edges[..., 0], edges[..., 1]
    inverse = np.linalg.inv(2 * np.stack([dx * dx, dy * dy, dx * dy], axis=-1))
    area = 0.5 * np.abs(edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0])
    nu = material.poisson_ratio
    plane = np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]]) * material.stretch_stiffness / (1 - nu * nu)
    s = area[:, None, None] * (inverse.transpose(0, 2, 1) @ plane @ inverse)
    upper = s[:, [0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]]
    return 2 * upper.T, (dx * dx + dy * dy).T, wrinkling.constants(inverse, area, material)


def gradients(rest: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """D eps_q / d x of both ends of edge q at rest, shape (m, 3 edges, 2 ends, 3); its ends are those of `ENDS`."""
    start, end = (rest[faces[:, ENDS[:, k]]] for k in range(2))
    return 2.0 * np.stack([start - end, end - start], axis=2)


@njit(cache=True, error_model="numpy")
def _side(x, y, z, to_x, to_y, to_z, l2, real):  # type: ignore[no-untyped-def]
    """An edge and its eps, in the precision `real`."""
    x, y, z = to_x - x, to_y - y, to_z - z
    return real(x), real(y), real(z), real(x * x + y * y + z * z - l2)


@njit(cache=True, error_model="numpy")
def _pull(ux, uy, uz, vx, vy, vz, wx, wy, wz, t0, t1, t2, j, out):  # type: ignore[no-untyped-def]
    """Column j of `out`: each corner is pulled along the edge that leaves it, and back along the one that arrives."""
    out[j], out[j + BLOCK], out[j + 2 * BLOCK] = t2 * wx - t1 * vx, t2 * wy - t1 * vy, t2 * wz - t1 * vz
    out[j + 3 * BLOCK], out[j + 4 * BLOCK], out[j + 5 * BLOCK] = t0 * ux - t2 * wx, t0 * uy - t2 * wy, t0 * uz - t2 * wz
    out[j + 6 * BLOCK], out[j + 7 * BLOCK], out[j + 8 * BLOCK] = t1 * vx - t0 * ux, t1 * vy - t0 * uy, t1 * vz - t0 * uz


@njit(cache=True, error_model="numpy")
def _forces(X, a, b, c, L2, S, e, n, out):  # type: ignore[no-untyped-def]
    """Forces on corners a + j, b + j, c + j, j < n, of the triangles at place e: nine rows of BLOCK in `out`.

    Rows are cut out one by one, as only a one-dimensional cut is known to be contiguous when this is compiled. `out` is
    one array with rows a known way apart: each further one that is written would have to be checked against each that
    is read, every time, before anything may be computed eight at a time.
    """
    xa, ya, za = X[0, a : a + n], X[1, a : a + n], X[2, a : a + n]
    xb, yb, zb = X[0, b : b + n], X[1, b : b + n], X[2, b : b + n]
    xc, yc, zc = X[0, c : c + n], X[1, c : c + n], X[2, c : c + n]
    l0, l1, l2 = L2[0, e : e + n], L2[1, e : e + n], L2[2, e : e + n]
    s0, s1, s2 = S[0, e : e + n], S[1, e : e + n], S[2, e : e + n]
    s3, s4, s5 = S[3, e : e + n], S[4, e : e + n], S[5, e : e + n]
    real = out.dtype.type
    for j in range(n):
        ux, uy, uz, e0 = _side(xb[j], yb[j], zb[j], xc[j], yc[j], zc[j], l0[j], real)
        vx, vy, vz, e1 = _side(xc[j], yc[j], zc[j], xa[j], ya[j], za[j], l1[j], real)
        wx, wy, wz, e2 = _side(xa[j], ya[j], za[j], xb[j], yb[j], zb[j], l2[j], real)
        t0 = s0[j] * e0 + s1[j] * e1 + s2[j] * e2
        t1 = s1[j] * e0 + s3[j] * e1 + s4[j] * e2
        t2 = s2[j] * e0 + s4[j] * e1 + s5[j] * e2
        _pull(ux, uy, uz, vx, vy, vz, wx, wy, wz, t0, t1, t2, j, out)


@njit(cache=True, error_model="numpy")
def _forces_of_wrinkled(X, a, b, c, L2, R, soft, e, n, out):  # type: ignore[no-untyped-def]
    """`_forces` of cloth that gives way under compression."""
    xa, ya, za = X[0, a : a + n], X[1, a : a + n], X[2, a : a + n]
    xb, yb, zb = X[0, b : b + n], X[1, b : b + n], X[2, b : b + n]
    xc, yc, zc = X[0, c : c + n], X[1, c : c + n], X[2, c : c + n]
    l0, l1, l2 = L2[0, e : e + n], L2[1, e : e + n], L2[2, e : e + n]
    p0, p1, p2 = R[0, e : e + n], R[1, e : e + n], R[2, e : e + n]
    p3, p4, p5 = R[3, e : e + n], R[4, e : e + n], R[5, e : e + n]
    p6, p7, p8 = R[6, e : e + n], R[7, e : e + n], R[8, e : e + n]
    pull, push, ratio = R[9, e : e + n], R[10, e : e + n], R[11, e : e + n]
    real = out.dtype.type
    for j in range(n):
        ux, uy, uz, e0 = _side(xb[j], yb[j], zb[j], xc[j], yc[j], zc[j], l0[j], real)
        vx, vy, vz, e1 = _side(xc[j], yc[j], zc[j], xa[j], ya[j], za[j], l1[j], real)
        wx, wy, wz, e2 = _side(xa[j], ya[j], za[j], xb[j], yb[j], zb[j], l2[j], real)
        exx = p0[j] * e0 + p1[j] * e1 + p2[j] * e2
        eyy = p3[j] * e0 + p4[j] * e1 + p5[j] * e2
        exy = wrinkling.HALF * (p6[j] * e0 + p7[j] * e1 + p8[j] * e2)
        sxx, syy, sxy = wrinkling.stress(exx, eyy, exy, pull[j], push[j], ratio[j], soft)
        t0 = p0[j] * sxx + p3[j] * syy + p6[j] * sxy
        t1 = p1[j] * sxx + p4[j] * syy + p7[j] * sxy
        t2 = p2[j] * sxx + p5[j] * syy + p8[j] * sxy
        _pull(ux, uy, uz, vx, vy, vz, wx, wy, wz, t0, t1, t2, j, out)


@njit(cache=True, error_model="numpy")
def _add(F, a, n, forces, row):  # type: ignore[no-untyped-def]
    for k in range(3):
        f, first = F[k, a : a + n], (row + k) * BLOCK
        more = forces[first : first + n]
        for j in range(n):
            f[j] += more[j]


@njit(cache=True, error_model="numpy")
def add_force(X, F, table, S, L2, R, soft, scratch):  # type: ignore[no-untyped-def]
    """Add the membrane force at X, shape (3, slots), to F, shape (3, slots) [N]; `scratch` has shape (9 BLOCK,)."""
    for r in range(table.shape[0]):
        for done in range(0, table[r, 1], BLOCK):
            n = min(table[r, 1] - done, BLOCK)
            e, a, b, c = table[r, 0] + done, table[r, 2] + done, table[r, 3] + done, table[r, 4] + done
            if R.shape[1]:
                _forces_of_wrinkled(X, a, b, c, L2, R, soft, e, n, scratch)
            else:
                _forces(X, a, b, c, L2, S, e, n, scratch)
            _add(F, a, n, scratch, 0)
            _add(F, b, n, scratch, 3)
            _add(F, c, n, scratch, 6)


@njit(cache=True, error_model="numpy")
def largest_stretch(X, table, L2):  # type: ignore[no-untyped-def]
    """Largest |x_b - x_a| / L of any edge, NaN if anything is not finite."""
    worst = 0.0
    for r in range(table.shape[0]):
        e, n = table[r, 0], table[r, 1]
        for q in range(3):
            i, k = table[r, 2 + (q + 1) % 3], table[r, 2 + (q + 2) % 3]
            for j in range(n):
                if L2[q, e + j] > 0.0:
                    s = 0.0
                    for d in range(3):
                        s += (X[d, k + j] - X[d, i + j]) ** 2
                    s /= L2[q, e + j]
                    if not s <= worst:
                        worst = s
                        if s != s:
                            return np.nan
    return np.sqrt(worst)
