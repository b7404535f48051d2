"""Bending: hinge angles combined per triangle into its curvature.

    g   = 4 tan(theta / 4)                      hinge measure; keeps tight loops open on coarse meshes
    Q   = a C + (1 - a) R^-1                    from the three angles of triangle T to its curvatures (k_uu, k_vv, k_uv)
    K_T = A_T Q' D Q                            D = B diag(1, 1, 2)
    W   = sum_T 1/2 (g - g0)' K_T (g - g0)      over the inner edges of T

R maps the curvatures of a quadratic deflection to the small hinge angles of the six-point patch around T. R^-1 is exact
for such a deflection, but on irregular meshes the forces of a constant moment do not cancel, and cloth is too soft. C
adds up how far the surface has turned at each edge, k = sum_e l_e s_e theta_e n_e n_e' / A (as in the basic shell
triangle of Onate and Zarate 2000, with s_e = 1/2); of theta_e a triangle of height d has the share s_e = d / (d + d'),
which is exact for curvature across the edge. Both shares make 1, so the forces of a constant moment cancel on any mesh;
but the curvature is not exact, and cloth is too stiff. In regular rows both are the same; elsewhere their mean is
nearer than either. At a border or a seam, which carries no moment, the curvature across it is none. Bending carries no
Poisson coupling, so a narrow strip and a wide sheet have the same moment per width per curvature, B. Derived in
docs/theory/bending.md.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from tatamu.simulators.native.memory.bands import BLOCK
from tatamu.topology import Topology, areas

PART_OF_C = 0.45
"""a: where irregular and turned meshes are too soft as often as too stiff (benchmarks/statics.py)."""
TINY = np.float32(1e-30)
HALF, ONE, FOUR = np.float32(0.5), np.float32(1.0), np.float32(4.0)  # a plain 0.5 would turn single into double
WIDE = np.float32(0.4)


def _feet(rest: np.ndarray, hinges: np.ndarray, apex: int) -> tuple[np.ndarray, np.ndarray]:
    """Foot of the apex on the edge as a fraction of it, and height over it [m], each shape (h,)."""
    x0, x1, x2 = rest[hinges[:, 0]], rest[hinges[:, 1]], rest[hinges[:, apex]]
    edge = x1 - x0
    t = np.einsum("ij,ij->i", x2 - x0, edge) / np.einsum("ij,ij->i", edge, edge)
    return t, np.linalg.norm(x2 - x0 - t[:, None] * edge, axis=1)


def _operators(
    rest: np.ndarray, faces: np.ndarray, frames: np.ndarray, hinges: np.ndarray, at: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """R, shape (m, 3 edges, 3 curvatures), and C, shape (m, 3 curvatures, 3 edges), of every triangle.

    Where an edge is no hinge (at < 0) the row of R is the curvature across it, and the column of C is zero.
    """
    feet = [_feet(rest, hinges, 2), _feet(rest, hinges, 3)]
    rows, columns = np.zeros((len(faces), 3, 3)), np.zeros((len(faces), 3, 3))
    area = areas(rest, faces)
    for q in range(3):
        i, j, k = (q + 1) % 3, (q + 2) % 3, q
        side = frames[:, j] - frames[:, i]
        length = np.linalg.norm(side, axis=1)
        normal = np.column_stack([side[:, 1], -side[:, 0]]) / length[:, None]
        nn = np.column_stack([normal[:, 0] ** 2, normal[:, 1] ** 2, normal[:, 0] * normal[:, 1]])
        none, has = np.flatnonzero(at[:, q] < 0), np.flatnonzero(at[:, q] >= 0)
        rows[none, q] = nn[none] * [1.0, 1.0, 2.0]
        h, face = at[has, q], faces[has]
        own_second = hinges[h, 2] != face[:, k]  # this triangle holds x3 rather than x2
        forward = hinges[h, 0] == face[:, i]
        sign = np.where(own_second == forward, -1.0, 1.0)
        t_own, l_own, t_far, l_far = (
            np.where(own_second, feet[1 - s][p][h], feet[s][p][h]) for s in (0, 1) for p in (0, 1)
        )
        t_own, t_far = (np.where(forward, t, 1 - t) for t in (t_own, t_far))
        share = l_own / (l_own + l_far)
        columns[has, :, q] = (-sign * length[has] * share / area[has])[:, None] * nn[has]
        p = frames[has, i]
        far = p + t_far[:, None] * side[has] + l_far[:, None] * normal[has]
        points = (p, frames[has, j], frames[has, k], far)
        weights = (
            (1 - t_own) / l_own + (1 - t_far) / l_far,
            t_own / l_own + t_far / l_far,
            -1 / l_own,
            -1 / l_far,
        )
        for x, w in zip(points, weights, strict=True):
            u, v = x[:, 0], x[:, 1]
            rows[has, q] += (sign * w)[:, None] * np.column_stack([u * u / 2, v * v / 2, u * v])
    return rows, columns


def curvatures(R: np.ndarray, C: np.ndarray) -> np.ndarray:
    """Q of every triangle: its curvatures from its hinge angles, shape (m, 3, 3)."""
    return np.asarray(PART_OF_C * C + (1.0 - PART_OF_C) * np.linalg.inv(R))


def constants(
    rest: np.ndarray, topology: Topology, frames: np.ndarray, free: np.ndarray, bending_rigidity: float
) -> tuple[np.ndarray, np.ndarray]:
    """K_T of every triangle, and which hinges its edges are.

    Args:
        rest: Unstrained positions [m], shape (n, 3).
        topology: Of the mesh, with h hinges.
        frames: Corners of each triangle in its plane [m], shape (m, 3, 2).
        free: Which hinges carry no moment (seams), shape (h,).
        bending_rigidity: B [N m].

    Returns:
        K_T [N m], shape (t, 3, 3), and hinges, shape (t, 3), of the triangles that have any; an edge that carries no
        moment has zeros in K_T, and another hinge of the triangle for its own.
    """
    number = np.full(len(topology.edges), -1)
    inner = np.flatnonzero(topology.faces_per_edge == 2)
    number[inner] = np.where(free, -1, np.arange(len(inner)))
    at = number[topology.face_edges]  # (m, 3)
    lacking = at < 0
    R, C = _operators(rest, topology.faces, frames, topology.hinges, at)
    Q = curvatures(R, C)
    D = bending_rigidity * np.diag([1.0, 1.0, 2.0])
    stiffness = areas(rest, topology.faces)[:, None, None] * (Q.transpose(0, 2, 1) @ D @ Q)
    stiffness *= ~(lacking[:, :, None] | lacking[:, None, :])
    some = ~lacking.all(axis=1)
    return stiffness[some], np.where(lacking, at.max(axis=1)[:, None], at)[some]


@njit(cache=True, error_model="numpy")
def _half_angle(cosine, sine):  # type: ignore[no-untyped-def]
    """tan(theta / 4)."""
    half_cos = np.sqrt(max(HALF + HALF * cosine, TINY))
    wide = np.copysign(np.sqrt(max(HALF - HALF * cosine, TINY)), sine)  # exact where half_cos is small
    narrow = HALF * sine / max(half_cos, WIDE)
    return (wide if cosine < -HALF else narrow) / (ONE + half_cos)


@njit(cache=True, error_model="numpy")
def _measure(X, a, b, c, d, n, H, g, slope):  # type: ignore[no-untyped-def]
    """Fill the first n columns of H, eight rows of BLOCK, and n elements of g and of its slope."""
    xa, ya, za = X[0, a : a + n], X[1, a : a + n], X[2, a : a + n]
    xb, yb, zb = X[0, b : b + n], X[1, b : b + n], X[2, b : b + n]
    xc, yc, zc = X[0, c : c + n], X[1, c : c + n], X[2, c : c + n]
    xd, yd, zd = X[0, d : d + n], X[1, d : d + n], X[2, d : d + n]
    real = H.dtype.type
    for j in range(n):
        ex, ey, ez = real(xb[j] - xa[j]), real(yb[j] - ya[j]), real(zb[j] - za[j])
        ux, uy, uz = real(xc[j] - xa[j]), real(yc[j] - ya[j]), real(zc[j] - za[j])
        wx, wy, wz = real(xd[j] - xa[j]), real(yd[j] - ya[j]), real(zd[j] - za[j])
        square = ex * ex + ey * ey + ez * ez + TINY
        px, py, pz = ey * uz - ez * uy, ez * ux - ex * uz, ex * uy - ey * ux
        qx, qy, qz = ez * wy - ey * wz, ex * wz - ez * wx, ey * wx - ex * wy
        length = np.sqrt(square)
        i1 = ONE / np.sqrt(px * px + py * py + pz * pz + TINY)  # apart, as the product of both squares
        i2 = ONE / np.sqrt(qx * qx + qy * qy + qz * qz + TINY)  # may be too small for single precision
        scale = i1 * i2
        cx, cy, cz = py * qz - pz * qy, pz * qx - px * qz, px * qy - py * qx
        sine = (cx * ex + cy * ey + cz * ez) * scale / length
        t = _half_angle((px * qx + py * qy + pz * qz) * scale, sine)
        g[j], slope[j] = FOUR * t, ONE + t * t
        g1, g2 = -length * i1 * i1, -length * i2 * i2
        H[j], H[j + BLOCK], H[j + 2 * BLOCK] = g1 * px, g1 * py, g1 * pz
        H[j + 3 * BLOCK], H[j + 4 * BLOCK], H[j + 5 * BLOCK] = g2 * qx, g2 * qy, g2 * qz
        H[j + 6 * BLOCK] = (ux * ex + uy * ey + uz * ez) / square
        H[j + 7 * BLOCK] = (wx * ex + wy * ey + wz * ez) / square


@njit(cache=True, error_model="numpy")
def _curl(g0, g1, g2, K, e, n, m0, m1, m2):  # type: ignore[no-untyped-def]
    """Add K_T g of n triangles."""
    k0, k1, k2 = K[0, e : e + n], K[1, e : e + n], K[2, e : e + n]
    k3, k4, k5 = K[3, e : e + n], K[4, e : e + n], K[5, e : e + n]
    for j in range(n):  # apart, as rows of m may overlap
        m0[j] += k0[j] * g0[j] + k1[j] * g1[j] + k2[j] * g2[j]
    for j in range(n):
        m1[j] += k1[j] * g0[j] + k3[j] * g1[j] + k4[j] * g2[j]
    for j in range(n):
        m2[j] += k2[j] * g0[j] + k4[j] * g1[j] + k5[j] * g2[j]


@njit(cache=True, error_model="numpy")
def _moments(g, slope, rest, table, copied, K, moment):  # type: ignore[no-untyped-def]
    """(K g0 - K g) g' of every hinge, with `rest` = K g0; g and moment have room for `copied` behind."""
    count = slope.shape[0]
    for i in range(copied.shape[0]):
        g[count + i] = g[copied[i]]
    moment[:] = 0.0
    for r in range(table.shape[0]):
        e, n, a, b, c = table[r, 0], table[r, 1], table[r, 2], table[r, 3], table[r, 4]
        g0, g1, g2 = g[a : a + n], g[b : b + n], g[c : c + n]
        _curl(g0, g1, g2, K, e, n, moment[a : a + n], moment[b : b + n], moment[c : c + n])
    for i in range(copied.shape[0]):
        moment[copied[i]] += moment[count + i]
    for h in range(count):
        moment[h] = (rest[h] - moment[h]) * slope[h]


@njit(cache=True, error_model="numpy")
def _push_apex(F, c, n, moment, H, row):  # type: ignore[no-untyped-def]
    """Force on the apex whose gradient stands in rows row .. row + 2 of H."""
    fx, fy, fz = F[0, c : c + n], F[1, c : c + n], F[2, c : c + n]
    d = H[row * BLOCK :]
    for j in range(n):
        m = moment[j]
        fx[j] += m * d[j]
        fy[j] += m * d[j + BLOCK]
        fz[j] += m * d[j + 2 * BLOCK]


@njit(cache=True, error_model="numpy")
def _push_end(F, a, n, moment, H, first):  # type: ignore[no-untyped-def]
    """Force on an end of the hinge's edge, the first or the other: they balance force and torque of both apices."""
    fx, fy, fz = F[0, a : a + n], F[1, a : a + n], F[2, a : a + n]
    for j in range(n):
        m, t2, t3 = moment[j], H[j + 6 * BLOCK], H[j + 7 * BLOCK]
        if first:
            t2, t3 = ONE - t2, ONE - t3
        fx[j] -= m * (t2 * H[j] + t3 * H[j + 3 * BLOCK])
        fy[j] -= m * (t2 * H[j + BLOCK] + t3 * H[j + 4 * BLOCK])
        fz[j] -= m * (t2 * H[j + 2 * BLOCK] + t3 * H[j + 5 * BLOCK])


@njit(cache=True, error_model="numpy")
def measure(X, table, H, g, slope):  # type: ignore[no-untyped-def]
    """Measure all hinges at X, shape (3, slots).

    Args:
        X: Positions in slots.
        table: Bands of hinges.
        H: To be filled, shape (`blocks(table)`, 8 BLOCK), per block of a band the rows d theta / d x2 (0-2) and x3
            (3-5), and the feet t2, t3 (6, 7).
        g: To be filled, per place.
        slope: To be filled with g', per place.
    """
    block = 0
    for r in range(table.shape[0]):
        for done in range(0, table[r, 1], BLOCK):
            n, e = min(table[r, 1] - done, BLOCK), table[r, 0] + done
            a, b, c, d = table[r, 2] + done, table[r, 3] + done, table[r, 4] + done, table[r, 5] + done
            _measure(X, a, b, c, d, n, H[block], g[e : e + n], slope[e : e + n])
            block += 1


@njit(cache=True, error_model="numpy")
def add_force(X, F, table, rest, triangles, copied, K, H, g, slope, moment):  # type: ignore[no-untyped-def]
    """Add the bending force at X, shape (3, slots), to F, shape (3, slots) [N].

    Args:
        X: Positions in slots [m].
        F: Forces in slots [N].
        table: Bands of hinges over slots.
        rest: K g0 of each hinge.
        triangles: Bands of triangles over hinges.
        copied: Hinges copied behind the last one for these bands.
        K: K_T of each triangle as (K00, K01, K02, K11, K12, K22).
        H: Scratch, see `measure`.
        g: Scratch per hinge and copy.
        slope: Scratch per hinge.
        moment: Scratch per hinge and copy.
    """
    measure(X, table, H, g, slope)
    _moments(g, slope, rest, triangles, copied, K, moment)
    block = 0
    for r in range(table.shape[0]):
        for done in range(0, table[r, 1], BLOCK):
            n, e = min(table[r, 1] - done, BLOCK), table[r, 0] + done
            m, h = moment[e : e + n], H[block]
            _push_apex(F, table[r, 4] + done, n, m, h, 0)
            _push_apex(F, table[r, 5] + done, n, m, h, 3)
            _push_end(F, table[r, 2] + done, n, m, h, True)
            _push_end(F, table[r, 3] + done, n, m, h, False)
            block += 1
