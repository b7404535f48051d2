"""Membrane: St. Venant-Kirchhoff elasticity on linear triangles, written in squared edge lengths.

    eps_q = |x_b - x_a|^2 - L_q^2            edge q, opposite corner q: exact Green strain along it, no square root
    eps   = P (E_xx, E_yy, 2 E_xy),          rows of P: 2 (dx^2, dy^2, dx dy) of the rest edge
    W     = A/2 E' C E = 1/2 eps' S eps,     S = A P^-T C P^-1, plane stress C with stiffness Y and ratio nu
    f_a   = -2 tau_q (x_a - x_b) - ..,       tau = S eps

Damping is Kelvin-Voigt: lengths and edges are taken at x + tau_d v. Derived in docs/native.md.

eps is a small difference of large numbers, so it is taken in double precision; all that follows in single.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from tatamu.material import Material
from tatamu.simulators.native import wrinkling

BLOCK = 528
"""Triangles whose forces are computed together: what they need in between stays in the nearest cache, and its rows
do not begin a power of two apart, which processors take for the same place."""
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
def _measure(X, a, b, n, l2, edge, eps):  # type: ignore[no-untyped-def]
    """Edges from a + j to b + j, in rows 0 .. 2 of `edge`, and their eps.

    Rows are cut out one by one, as only a one-dimensional cut is known to be contiguous when this is compiled.
    """
    xa, ya, za = X[0, a : a + n], X[1, a : a + n], X[2, a : a + n]
    xb, yb, zb = X[0, b : b + n], X[1, b : b + n], X[2, b : b + n]
    x, y, z = edge[0, :n], edge[1, :n], edge[2, :n]
    for j in range(n):
        ux, uy, uz = xb[j] - xa[j], yb[j] - ya[j], zb[j] - za[j]
        x[j], y[j], z[j] = ux, uy, uz
        eps[j] = ux * ux + uy * uy + uz * uz - l2[j]


@njit(cache=True, error_model="numpy")
def _tension(S, e, n, tau):  # type: ignore[no-untyped-def]
    """Turn eps, in tau, into tau = 2 S eps."""
    s0, s1, s2 = S[0, e : e + n], S[1, e : e + n], S[2, e : e + n]
    s3, s4, s5 = S[3, e : e + n], S[4, e : e + n], S[5, e : e + n]
    t0, t1, t2 = tau[0, :n], tau[1, :n], tau[2, :n]
    for j in range(n):
        e0, e1, e2 = t0[j], t1[j], t2[j]
        t0[j] = s0[j] * e0 + s1[j] * e1 + s2[j] * e2
        t1[j] = s1[j] * e0 + s3[j] * e1 + s4[j] * e2
        t2[j] = s2[j] * e0 + s4[j] * e1 + s5[j] * e2


@njit(cache=True, error_model="numpy")
def _pull(F, a, n, leaving, tau_leaving, arriving, tau_arriving):  # type: ignore[no-untyped-def]
    """Pull corners a along the edges that leave them, and back along those that arrive."""
    for k in range(3):
        u, v, f = leaving[k, :n], arriving[k, :n], F[k, a : a + n]
        for j in range(n):
            f[j] += tau_leaving[j] * u[j] - tau_arriving[j] * v[j]


@njit(cache=True, error_model="numpy")
def add_force(X, F, table, S, L2, R, soft, scratch):  # type: ignore[no-untyped-def]
    """Add the membrane force at X, shape (3, slots), to F, shape (3, slots) [N]; `scratch` has shape (12, BLOCK)."""
    u, v, w, tau = scratch[:3], scratch[3:6], scratch[6:9], scratch[9:]  # edges opposite corners a, b, c
    for r in range(table.shape[0]):
        for done in range(0, table[r, 1], BLOCK):
            n = min(table[r, 1] - done, BLOCK)
            e, a, b, c = table[r, 0] + done, table[r, 2] + done, table[r, 3] + done, table[r, 4] + done
            _measure(X, b, c, n, L2[0, e : e + n], u, tau[0])
            _measure(X, c, a, n, L2[1, e : e + n], v, tau[1])
            _measure(X, a, b, n, L2[2, e : e + n], w, tau[2])
            if R.shape[1]:
                wrinkling.tension(R, soft, e, n, tau)
            else:
                _tension(S, e, n, tau)
            _pull(F, a, n, w, tau[2], v, tau[1])
            _pull(F, b, n, u, tau[0], w, tau[2])
            _pull(F, c, n, v, tau[1], u, tau[0])


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
