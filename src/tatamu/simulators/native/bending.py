"""Bending: hinge angles combined per triangle, so that cylinder, twist and sphere all carry the right energy.

    g   = 4 tan(theta / 4)                         hinge measure; keeps tight loops open on coarse meshes
    K_T = A_T (R D^-1 R')^-1                       D = B diag(1, 1, 2) for (k_uu, k_vv, k_uv)
    W   = sum_T 1/2 (g - g0)' K_T (g - g0)         over the inner edges of triangle T

R maps the curvatures of a quadratic deflection to the small hinge angles of the six-point patch around T; the hinges
that a border or a seam lacks are condensed out. Bending carries no Poisson coupling, so a narrow strip and a wide
sheet have the same moment per width per curvature, B. Source: design.md section 5, facts/solver.md round two.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from tatamu.topology import Topology, areas

TINY = 1e-30


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
        weights = ((1 - t_own) / l_own + (1 - t_far) / l_far, t_own / l_own + t_far / l_far, -1 / l_own, -1 / l_far)
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
def _angles(X, a, b, c, d, n, e, H):  # type: ignore[no-untyped-def]
    """Per hinge into H: gradients d2 (rows 0-2) and d3 (3-5), feet t2, t3 (6, 7), g (8), g' (9)."""
    x, y, z = X[0], X[1], X[2]
    for j in range(n):
        ex, ey, ez = x[b + j] - x[a + j], y[b + j] - y[a + j], z[b + j] - z[a + j]
        px, py, pz = x[c + j] - x[a + j], y[c + j] - y[a + j], z[c + j] - z[a + j]
        qx, qy, qz = x[d + j] - x[a + j], y[d + j] - y[a + j], z[d + j] - z[a + j]
        n1x, n1y, n1z = ey * pz - ez * py, ez * px - ex * pz, ex * py - ey * px
        n2x, n2y, n2z = qy * ez - qz * ey, qz * ex - qx * ez, qx * ey - qy * ex
        ee = ex * ex + ey * ey + ez * ez + TINY
        length = np.sqrt(ee)
        s1 = n1x * n1x + n1y * n1y + n1z * n1z + TINY
        s2 = n2x * n2x + n2y * n2y + n2z * n2z + TINY
        scale = 1.0 / np.sqrt(s1 * s2)
        cosine = (n1x * n2x + n1y * n2y + n1z * n2z) * scale
        cx, cy, cz = n1y * n2z - n1z * n2y, n1z * n2x - n1x * n2z, n1x * n2y - n1y * n2x
        sine = (cx * ex + cy * ey + cz * ez) * scale / length
        half_cos = np.sqrt(max(0.5 + 0.5 * cosine, 0.0))
        root = np.sqrt(max(0.5 - 0.5 * cosine, 0.0))
        wide = root if sine >= 0.0 else -root
        half_sin = wide if cosine < -0.5 else 0.5 * sine / max(half_cos, 0.4)
        t = half_sin / (1.0 + half_cos)
        g1, g2 = -length / s1, -length / s2
        H[0, e + j], H[1, e + j], H[2, e + j] = g1 * n1x, g1 * n1y, g1 * n1z
        H[3, e + j], H[4, e + j], H[5, e + j] = g2 * n2x, g2 * n2y, g2 * n2z
        H[6, e + j] = (px * ex + py * ey + pz * ez) / ee
        H[7, e + j] = (qx * ex + qy * ey + qz * ez) / ee
        H[8, e + j] = 4.0 * t
        H[9, e + j] = 1.0 + t * t


@njit(cache=True, error_model="numpy")
def _moments(H, g0, weights, others, moment):  # type: ignore[no-untyped-def]
    """-(K (g - g0)) g' of every hinge."""
    g = H[8]
    for h in range(moment.shape[0]):
        m = 0.0
        for k in range(5):
            o = others[k, h]
            m += weights[k, h] * (g[o] - g0[o])
        moment[h] = -m * H[9, h]


@njit(cache=True, error_model="numpy")
def _push(F, a, b, c, d, n, e, H, moment):  # type: ignore[no-untyped-def]
    """Force on the four vertices of each hinge: moment times the gradient of its angle."""
    t2, t3 = H[6], H[7]
    for k in range(3):
        f, d2, d3 = F[k], H[k], H[3 + k]
        for j in range(n):
            f[c + j] += moment[e + j] * d2[e + j]
        for j in range(n):
            f[d + j] += moment[e + j] * d3[e + j]
        for j in range(n):
            f[a + j] -= moment[e + j] * ((1.0 - t2[e + j]) * d2[e + j] + (1.0 - t3[e + j]) * d3[e + j])
        for j in range(n):
            f[b + j] -= moment[e + j] * (t2[e + j] * d2[e + j] + t3[e + j] * d3[e + j])


@njit(cache=True, error_model="numpy")
def measure(X, table, H):  # type: ignore[no-untyped-def]
    """Fill H, shape (10, places), with angles and gradients at X."""
    for r in range(table.shape[0]):
        e, n, a, b, c, d = table[r, 0], table[r, 1], table[r, 2], table[r, 3], table[r, 4], table[r, 5]
        _angles(X, a, b, c, d, n, e, H)


@njit(cache=True, error_model="numpy")
def add_force(X, F, table, g0, weights, others, H, moment):  # type: ignore[no-untyped-def]
    """Add the bending force at X, shape (3, slots), to F, shape (3, slots) [N]; H and moment are scratch."""
    measure(X, table, H)
    _moments(H, g0, weights, others, moment)
    for r in range(table.shape[0]):
        e, n, a, b, c, d = table[r, 0], table[r, 1], table[r, 2], table[r, 3], table[r, 4], table[r, 5]
        _push(F, a, b, c, d, n, e, H, moment)
