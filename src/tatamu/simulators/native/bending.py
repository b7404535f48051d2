"""Bending: hinge angles combined per triangle, so that cylinder, twist and sphere all carry the right energy.

    g   = 4 tan(theta / 4)                         hinge measure; keeps tight loops open on coarse meshes
    K_T = A_T (R D^-1 R')^-1                       D = B diag(1, 1, 2) for (k_uu, k_vv, k_uv)
    W   = sum_T 1/2 (g - g0)' K_T (g - g0)         over the inner edges of triangle T

R maps the curvatures of a quadratic deflection to the small hinge angles of the six-point patch around T; the hinges
that a border or a seam lacks are condensed out. Bending carries no Poisson coupling, so a narrow strip and a wide
sheet have the same moment per width per curvature, B. Derived in docs/native.md.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from tatamu.topology import Topology, areas

TINY = np.float32(1e-30)
HALF, ONE, FOUR = np.float32(0.5), np.float32(1.0), np.float32(4.0)  # a plain 0.5 would turn single into double
WIDE = np.float32(0.4)


def _feet(rest: np.ndarray, hinges: np.ndarray, apex: int) -> tuple[np.ndarray, np.ndarray]:
    """Foot of the apex on the edge as a fraction of it, and height over it [m], each shape (h,)."""
    x0, x1, x2 = rest[hinges[:, 0]], rest[hinges[:, 1]], rest[hinges[:, apex]]
    edge = x1 - x0
    t = np.einsum("ij,ij->i", x2 - x0, edge) / np.einsum("ij,ij->i", edge, edge)
    return t, np.linalg.norm(x2 - x0 - t[:, None] * edge, axis=1)


def _rows(rest: np.ndarray, faces: np.ndarray, frames: np.ndarray, hinges: np.ndarray, at: np.ndarray) -> np.ndarray:
    """R of every triangle, shape (m, 3 edges, 3 curvatures); zero where an edge is no hinge (at < 0)."""
    feet = [_feet(rest, hinges, 2), _feet(rest, hinges, 3)]
    rows = np.zeros((len(faces), 3, 3))
    for q in range(3):
        i, j, k = (q + 1) % 3, (q + 2) % 3, q
        has = np.flatnonzero(at[:, q] >= 0)
        h, face = at[has, q], faces[has]
        own_second = hinges[h, 2] != face[:, k]  # this triangle holds x3 rather than x2
        forward = hinges[h, 0] == face[:, i]
        t_own, l_own, t_far, l_far = (
            np.where(own_second, feet[1 - s][p][h], feet[s][p][h]) for s in (0, 1) for p in (0, 1)
        )
        t_own, t_far = (np.where(forward, t, 1 - t) for t in (t_own, t_far))
        p, d = frames[has, i], frames[has, j] - frames[has, i]
        outward = np.column_stack([d[:, 1], -d[:, 0]]) / np.linalg.norm(d, axis=1)[:, None]
        far = p + t_far[:, None] * d + l_far[:, None] * outward
        points = (p, frames[has, j], frames[has, k], far)
        weights = (
            (1 - t_own) / l_own + (1 - t_far) / l_far,
            t_own / l_own + t_far / l_far,
            -1 / l_own,
            -1 / l_far,
        )
        sign = np.where(own_second == forward, -1.0, 1.0)
        for x, w in zip(points, weights, strict=True):
            u, v = x[:, 0], x[:, 1]
            rows[has, q] += (sign * w)[:, None] * np.column_stack([u * u / 2, v * v / 2, u * v])
    return rows


def constants(
    rest: np.ndarray, topology: Topology, frames: np.ndarray, free: np.ndarray, bending_rigidity: float
) -> tuple[np.ndarray, np.ndarray]:
    """Moment of every hinge as a sum over five hinges, itself first.

    Args:
        rest: Unstrained positions [m], shape (n, 3).
        topology: Of the mesh, with h hinges.
        frames: Corners of each triangle in its plane [m], shape (m, 3, 2).
        free: Which hinges carry no moment (seams), shape (h,).
        bending_rigidity: B [N m].

    Returns:
        Coefficients [N m], shape (5, h), and the hinges they multiply, shape (5, h).
    """
    faces, hinges = topology.faces, topology.hinges
    number = np.full(len(topology.edges), -1)
    inner = np.flatnonzero(topology.faces_per_edge == 2)
    number[inner] = np.where(free, -1, np.arange(len(inner)))
    at = number[topology.face_edges]  # (m, 3)
    rows = _rows(rest, faces, frames, hinges, at)
    inverse_d = np.diag([1.0, 1.0, 0.5]) / max(bending_rigidity, TINY)
    compliance = rows @ inverse_d @ rows.transpose(0, 2, 1)
    lacking = at < 0
    compliance[:, range(3), range(3)] += lacking  # a unit pivot keeps the missing hinges apart
    stiffness = areas(rest, faces)[:, None, None] * np.linalg.inv(compliance)
    stiffness *= ~(lacking[:, :, None] | lacking[:, None, :])

    weights = np.zeros((5, len(hinges)))
    others = np.tile(np.arange(len(hinges)), (5, 1))
    filled = np.ones(len(hinges), dtype=np.int64)
    for q in range(3):
        has = np.flatnonzero(at[:, q] >= 0)
        np.add.at(weights[0], at[has, q], stiffness[has, q, q])
    for face in np.flatnonzero((~lacking).sum(1) > 1):
        for q in range(3):
            for p in range(3):
                h, o = at[face, q], at[face, p]
                if p != q and h >= 0 and o >= 0:
                    weights[filled[h], h], others[filled[h], h] = stiffness[face, q, p], o
                    filled[h] += 1
    if bending_rigidity == 0.0:
        weights[:] = 0.0
    return weights, others


@njit(cache=True, error_model="numpy")
def _normals(X, a, b, c, n, H, row, foot, e):  # type: ignore[no-untyped-def]
    """Edge x apex, into rows row .. row + 2 of H, and the foot of apex c on edge (a, b) as a fraction of it."""
    xa, ya, za = X[0, a : a + n], X[1, a : a + n], X[2, a : a + n]
    xb, yb, zb = X[0, b : b + n], X[1, b : b + n], X[2, b : b + n]
    xc, yc, zc = X[0, c : c + n], X[1, c : c + n], X[2, c : c + n]
    h0, h1, h2, h3 = H[row, e : e + n], H[row + 1, e : e + n], H[row + 2, e : e + n], H[foot, e : e + n]
    for j in range(n):
        ex, ey, ez = xb[j] - xa[j], yb[j] - ya[j], zb[j] - za[j]
        px, py, pz = xc[j] - xa[j], yc[j] - ya[j], zc[j] - za[j]
        h0[j], h1[j], h2[j] = ey * pz - ez * py, ez * px - ex * pz, ex * py - ey * px
        h3[j] = (px * ex + py * ey + pz * ez) / (ex * ex + ey * ey + ez * ez + TINY)


@njit(cache=True, error_model="numpy")
def _gradients(X, a, b, n, H, e):  # type: ignore[no-untyped-def]
    """Turn the normals in H into gradients of theta; cosine and sine of theta into rows 8 and 9."""
    xa, ya, za = X[0, a : a + n], X[1, a : a + n], X[2, a : a + n]
    xb, yb, zb = X[0, b : b + n], X[1, b : b + n], X[2, b : b + n]
    h0, h1, h2 = H[0, e : e + n], H[1, e : e + n], H[2, e : e + n]
    h3, h4, h5 = H[3, e : e + n], H[4, e : e + n], H[5, e : e + n]
    h8, h9 = H[8, e : e + n], H[9, e : e + n]
    for j in range(n):
        ex, ey, ez = xb[j] - xa[j], yb[j] - ya[j], zb[j] - za[j]
        px, py, pz, qx, qy, qz = h0[j], h1[j], h2[j], -h3[j], -h4[j], -h5[j]
        length = np.sqrt(ex * ex + ey * ey + ez * ez + TINY)
        s1 = px * px + py * py + pz * pz + TINY
        s2 = qx * qx + qy * qy + qz * qz + TINY
        i1, i2 = ONE / np.sqrt(s1), ONE / np.sqrt(s2)  # apart, as s1 s2 may be too small for single precision
        scale = i1 * i2
        cx, cy, cz = py * qz - pz * qy, pz * qx - px * qz, px * qy - py * qx
        h8[j] = (px * qx + py * qy + pz * qz) * scale
        h9[j] = (cx * ex + cy * ey + cz * ez) * scale / length
        g1, g2 = -length * i1 * i1, -length * i2 * i2
        h0[j], h1[j], h2[j] = g1 * px, g1 * py, g1 * pz
        h3[j], h4[j], h5[j] = g2 * qx, g2 * qy, g2 * qz


@njit(cache=True, error_model="numpy")
def _half_angles(H):  # type: ignore[no-untyped-def]
    """Turn cosine and sine of theta (rows 8, 9 of H) into g = 4 tan(theta/4) and g' = 1 + tan^2(theta/4)."""
    cosines, sines = H[8], H[9]
    for j in range(H.shape[1]):
        cosine, sine = cosines[j], sines[j]
        half_cos = np.sqrt(max(HALF + HALF * cosine, TINY))
        wide = np.copysign(np.sqrt(max(HALF - HALF * cosine, TINY)), sine)  # exact where half_cos is small
        narrow = HALF * sine / max(half_cos, WIDE)
        t = (wide if cosine < -HALF else narrow) / (ONE + half_cos)
        cosines[j] = FOUR * t
        sines[j] = ONE + t * t


@njit(cache=True, error_model="numpy")
def _moments(g, slope, rest, weights, others, moment):  # type: ignore[no-untyped-def]
    """(K g0 - K g) g' of every hinge, with `rest` = K g0."""
    w0, w1, w2, w3, w4 = weights[0], weights[1], weights[2], weights[3], weights[4]
    o1, o2, o3, o4 = others[1], others[2], others[3], others[4]
    for h in range(moment.shape[0]):
        near = w1[h] * g[o1[h]] + w2[h] * g[o2[h]] + w3[h] * g[o3[h]] + w4[h] * g[o4[h]]
        moment[h] = (rest[h] - w0[h] * g[h] - near) * slope[h]


@njit(cache=True, error_model="numpy")
def _push_apex(F, c, n, moment, H, row, e):  # type: ignore[no-untyped-def]
    """Force on the apex whose gradient stands in rows row .. row + 2 of H."""
    m = moment[e : e + n]
    for k in range(3):
        f, d = F[k, c : c + n], H[row + k, e : e + n]
        for j in range(n):
            f[j] += m[j] * d[j]


@njit(cache=True, error_model="numpy")
def _push_ends(F, a, b, n, moment, H, e):  # type: ignore[no-untyped-def]
    """The ends of the hinge's edge balance force and torque of its two apices."""
    m, t2, t3 = moment[e : e + n], H[6, e : e + n], H[7, e : e + n]
    for k in range(3):
        fa, fb, d2, d3 = F[k, a : a + n], F[k, b : b + n], H[k, e : e + n], H[3 + k, e : e + n]
        for j in range(n):
            fa[j] -= m[j] * ((ONE - t2[j]) * d2[j] + (ONE - t3[j]) * d3[j])
        for j in range(n):
            fb[j] -= m[j] * (t2[j] * d2[j] + t3[j] * d3[j])


@njit(cache=True, error_model="numpy")
def measure(X, table, H):  # type: ignore[no-untyped-def]
    """Fill H, shape (10, places): d theta / d x2 (rows 0-2) and x3 (3-5), feet t2, t3 (6, 7), g (8), g' (9)."""
    for r in range(table.shape[0]):
        e, n, a, b, c, d = table[r, 0], table[r, 1], table[r, 2], table[r, 3], table[r, 4], table[r, 5]
        _normals(X, a, b, c, n, H, 0, 6, e)
        _normals(X, a, b, d, n, H, 3, 7, e)
        _gradients(X, a, b, n, H, e)
    _half_angles(H)


@njit(cache=True, error_model="numpy")
def add_force(X, F, table, rest, weights, others, H, moment):  # type: ignore[no-untyped-def]
    """Add the bending force at X, shape (3, slots), to F [N]; `rest` is K g0, H and moment are scratch."""
    measure(X, table, H)
    _moments(H[8], H[9], rest, weights, others, moment)
    for r in range(table.shape[0]):
        e, n, a, b, c, d = table[r, 0], table[r, 1], table[r, 2], table[r, 3], table[r, 4], table[r, 5]
        _push_apex(F, c, n, moment, H, 0, e)
        _push_apex(F, d, n, moment, H, 3, e)
        _push_ends(F, a, b, n, moment, H, e)
