"""Bending forces. Each triangle combines the dihedral angles at its edges to its curvature.

    g   = 4 tan(theta / 4)                      theta: dihedral angle, 0 when flat; g keeps tight loops open
    K_T = A_T Q' D Q                            stiffness of triangle T, see `curvature`
    W   = sum_T 1/2 (g - g0)' K_T (g - g0)      energy, over the inner edges of T; g0: g of the unstrained shape

For large angles, g grows faster than theta, which keeps tight loops open. A_T is the area of triangle T. Q is the
matrix from the measures g to the curvatures of the triangle, and D contains the rigidities. Bending has no Poisson
effect. Therefore a narrow strip and a wide sheet have the same moment per width and curvature, which is the bending
rigidity B. The derivation is in docs/theory/bending.md.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from tatamu.simulation.material import Material
from tatamu.simulation.native.compiled import kernel
from tatamu.simulation.native.elastic import hysteresis, symmetric
from tatamu.simulation.native.elastic.curvature import CurvatureMaps
from tatamu.simulation.native.elastic.hysteresis import Friction, Slip
from tatamu.simulation.native.memory.bands import BLOCK, Bands, bands, blocks

# Constants in single precision. A plain 0.5 would convert everything that it is multiplied by to double precision.
TINY: Any = np.float32(1e-30)
HALF: Any = np.float32(0.5)
ZERO: Any = np.float32(0.0)
ONE: Any = np.float32(1.0)
FOUR: Any = np.float32(4.0)
WIDE: Any = np.float32(0.4)
"""Smallest cosine of half a dihedral angle that is used as a divisor [-].

For smaller cosines, a formula without this divisor is used."""

PART = BLOCK // 3
"""Number of hinges whose edges are kept in the nearest cache."""


class Bending(NamedTuple):
    """Constants of bending, in the order in which forces are computed.

    A hinge is an inner edge with its two triangles: the vertices a and b of the edge, and the opposite vertices c and
    d. A band is a run of hinges or triangles that are neighbours in memory. Places without a hinge or a triangle
    contain zeros.
    """

    hinges: np.ndarray
    """Table of the bands of hinges, with the slots of their vertices."""
    copies: np.ndarray
    """Slots that some hinges need as copies."""
    rest_moment: np.ndarray
    """Moment K g0 of each hinge in the unstrained shape, in the order of memory [N m], shape (hinge places,).

    K is the stiffness of bending, and g0 are the measures of the dihedral angles. The moments have single precision."""
    couplings: np.ndarray
    """Table of the bands of triangles, with the memory positions of each triangle's hinges."""
    coupling_copies: np.ndarray
    """Memory positions of hinges that some triangles need as copies. The copies are stored behind the last hinge."""
    friction: Friction
    """Constants of the friction of bending, for cloth with hysteresis."""
    K: np.ndarray
    """Stiffness K_T of each triangle, in the order of memory and in single precision [N m], shape (6, triangle places).

    The six different elements of each symmetric matrix are packed as in `symmetric`."""


class HingeMeasures(NamedTuple):
    """Temporary arrays for the angles and moments of all hinges, in the order of their places in memory.

    `g` and `moment` have additional memory for copies of hinges.
    """

    gradients: np.ndarray
    """For each block of a band, eight rows of BLOCK numbers, shape (`blocks(hinges)`, 8 BLOCK).

    Rows 0 to 5 contain the derivatives of the dihedral angle theta with respect to the positions of both opposite
    vertices [1/m]: rows 0 to 2 for the vertex c, rows 3 to 5 for the vertex d. Rows 6 and 7 contain the feet of these
    vertices, as fractions of the edge."""
    edges: np.ndarray
    """Rows of PART numbers with the edges of some hinges [m], shape (9 PART,)."""
    g: np.ndarray
    """Measure g = 4 tan(theta / 4) of the dihedral angle theta of each hinge [-]."""
    slope: np.ndarray
    """Derivative g' = d g / d theta of the measure g of each hinge's angle theta [-]."""
    moment: np.ndarray
    """Moment at each hinge [N m]."""
    slip: Slip
    """State of the friction of bending. It is not temporary: cloth with hysteresis keeps it from step to step."""


def scratch(
    hinges: np.ndarray, places: int, copies: int, real: type = np.float32, slip: Slip | None = None
) -> HingeMeasures:
    """Return the temporary arrays of hinges.

    Args:
        hinges: Table of the bands of hinges.
        places: Number of places in the bands.
        copies: Number of places that are copied behind the last place.
        real: Precision in which forces are computed.
        slip: State of the friction of bending; None for cloth without friction.
    """
    if slip is None:
        slip = hysteresis.unslipped(hysteresis.none(real), np.zeros(0), np.zeros((0, 5), dtype=np.int64))
    return HingeMeasures(
        gradients=np.zeros((blocks(hinges), 8 * BLOCK), dtype=real),
        edges=np.zeros(9 * PART, dtype=real),
        g=np.zeros(places + copies, dtype=real),
        slope=np.zeros(places, dtype=real),
        moment=np.zeros(places + copies, dtype=real),
        slip=slip,
    )


def in_bands(
    hinges: Bands,
    curved: CurvatureMaps,
    K: np.ndarray,
    rest_moment: np.ndarray,
    material: Material,
    real: type = np.float32,
) -> Bending:
    """Return the constants of bending in the order in which forces are computed.

    Args:
        hinges: Bands of hinges, with slots of vertices.
        curved: Hinges of each triangle, and the matrices from their angles to its curvatures.
        K: Stiffness K_T of each of the t triangles from `curvature.stiffness` [N m], shape (t, 3, 3).
        rest_moment: Moment of each of the h hinges in the unstrained shape [N m], shape (h,).
        material: Material of the cloth, which contains its hysteresis.
        real: Precision in which forces are computed.
    """
    couplings = bands(hinges.place[curved.hinges], hinges.size)
    return Bending(
        hinges=hinges.table,
        copies=hinges.copied,
        rest_moment=hinges.spread(rest_moment).astype(real),
        couplings=couplings.table,
        coupling_copies=couplings.copied,
        friction=hysteresis.in_bands(couplings, curved, material, real),
        K=couplings.spread(symmetric.pack(K)).astype(real),
    )


@kernel
def _tan_of_quarter(cosine, sine):  # type: ignore[no-untyped-def]
    """Return tan(theta / 4) from the cosine and the sine of theta."""
    half_cos = np.sqrt(max(HALF + HALF * cosine, TINY))
    wide = np.copysign(np.sqrt(max(HALF - HALF * cosine, TINY)), sine)  # accurate if half_cos is small
    narrow = HALF * sine / max(half_cos, WIDE)
    return (wide if cosine < -HALF else narrow) / (ONE + half_cos)


@kernel
def _set_edges(X: np.ndarray, a: int, b: int, c: int, d: int, n: int, out: np.ndarray) -> None:
    """Set nine rows of `out` to the vectors from vertex a + j to b + j, c + j and d + j of n hinges [m]."""
    xa, ya, za = X[0, a : a + n], X[1, a : a + n], X[2, a : a + n]
    xb, yb, zb = X[0, b : b + n], X[1, b : b + n], X[2, b : b + n]
    xc, yc, zc = X[0, c : c + n], X[1, c : c + n], X[2, c : c + n]
    xd, yd, zd = X[0, d : d + n], X[1, d : d + n], X[2, d : d + n]
    real = out.dtype.type
    for j in range(n):
        out[j] = real(xb[j] - xa[j])
        out[j + PART] = real(yb[j] - ya[j])
        out[j + 2 * PART] = real(zb[j] - za[j])
        out[j + 3 * PART] = real(xc[j] - xa[j])
        out[j + 4 * PART] = real(yc[j] - ya[j])
        out[j + 5 * PART] = real(zc[j] - za[j])
        out[j + 6 * PART] = real(xd[j] - xa[j])
        out[j + 7 * PART] = real(yd[j] - ya[j])
        out[j + 8 * PART] = real(zd[j] - za[j])


@kernel
def _measure(m: np.ndarray, n: int, gradients: np.ndarray, g: np.ndarray, slope: np.ndarray) -> None:
    """Measure the dihedral angles of n hinges from the rows m of `_set_edges`: fill `gradients`, `g` and `slope`.

    This loop has no numbers in double precision, because the compiler would then use half of each vector register.
    """
    for j in range(n):
        ex, ey, ez = m[j], m[j + PART], m[j + 2 * PART]
        ux, uy, uz = m[j + 3 * PART], m[j + 4 * PART], m[j + 5 * PART]
        wx, wy, wz = m[j + 6 * PART], m[j + 7 * PART], m[j + 8 * PART]
        square = ex * ex + ey * ey + ez * ez + TINY
        px, py, pz = ey * uz - ez * uy, ez * ux - ex * uz, ex * uy - ey * ux
        qx, qy, qz = ez * wy - ey * wz, ex * wz - ez * wx, ey * wx - ex * wy
        length = np.sqrt(square)
        i1 = ONE / np.sqrt(px * px + py * py + pz * pz + TINY)  # two roots, because the product
        i2 = ONE / np.sqrt(qx * qx + qy * qy + qz * qz + TINY)  # of both squares may be too small for single precision
        scale = i1 * i2
        cx, cy, cz = py * qz - pz * qy, pz * qx - px * qz, px * qy - py * qx
        sine = (cx * ex + cy * ey + cz * ez) * scale / length
        t = _tan_of_quarter((px * qx + py * qy + pz * qz) * scale, sine)
        g[j] = FOUR * t
        slope[j] = ONE + t * t
        g1 = -length * i1 * i1
        g2 = -length * i2 * i2
        gradients[j] = g1 * px
        gradients[j + BLOCK] = g1 * py
        gradients[j + 2 * BLOCK] = g1 * pz
        gradients[j + 3 * BLOCK] = g2 * qx
        gradients[j + 4 * BLOCK] = g2 * qy
        gradients[j + 5 * BLOCK] = g2 * qz
        gradients[j + 6 * BLOCK] = (ux * ex + uy * ey + uz * ez) / square
        gradients[j + 7 * BLOCK] = (wx * ex + wy * ey + wz * ez) / square


@kernel
def _add_moments_of_band(
    g: np.ndarray, K: np.ndarray, e: int, n: int, a: int, b: int, c: int, moment: np.ndarray
) -> None:
    """Add the moments K_T g of n triangles, which are stored from place e on.

    K_T is the stiffness of a triangle, and g are the measures of the angles at its hinges. The hinges of triangle j are
    stored at a + j, b + j and c + j.
    """
    g0, g1, g2 = g[a : a + n], g[b : b + n], g[c : c + n]
    m0, m1, m2 = moment[a : a + n], moment[b : b + n], moment[c : c + n]
    k0, k1, k2 = K[0, e : e + n], K[1, e : e + n], K[2, e : e + n]
    k3, k4, k5 = K[3, e : e + n], K[4, e : e + n], K[5, e : e + n]
    for j in range(n):  # three separate loops, because the rows of moment may overlap
        m0[j] += k0[j] * g0[j] + k1[j] * g1[j] + k2[j] * g2[j]
    for j in range(n):
        m1[j] += k1[j] * g0[j] + k3[j] * g1[j] + k4[j] * g2[j]
    for j in range(n):
        m2[j] += k2[j] * g0[j] + k4[j] * g1[j] + k5[j] * g2[j]


@kernel
def _clear_moments(g: np.ndarray, copies: np.ndarray, moment: np.ndarray, count: int) -> None:
    """Copy the measures g of some hinges behind the last of `count` hinges, and set all moments to zero."""
    for i in range(copies.shape[0]):
        g[count + i] = g[copies[i]]
    for h in range(moment.shape[0]):
        moment[h] = ZERO


@kernel
def _finish_moments(rest_moment: np.ndarray, slope: np.ndarray, copies: np.ndarray, moment: np.ndarray) -> None:
    """Turn the resisting moment K g of every hinge into (K g0 - K g) g', see `HingeMeasures`."""
    count = slope.shape[0]
    for i in range(copies.shape[0]):
        moment[copies[i]] += moment[count + i]
    for h in range(count):
        moment[h] = (rest_moment[h] - moment[h]) * slope[h]


@kernel
def _push_apex(F: np.ndarray, c: int, n: int, moment: np.ndarray, gradients: np.ndarray, row: int) -> None:
    """Add the forces on one of the two opposite vertices of n hinges.

    These vertices have the slots from c to c + n - 1. The derivatives of the angles with respect to these
    vertices are in the rows `row` to `row` + 2 of `gradients`.
    """
    fx, fy, fz = F[0, c : c + n], F[1, c : c + n], F[2, c : c + n]
    d = gradients[row * BLOCK :]
    for j in range(n):
        m = moment[j]
        fx[j] += m * d[j]
        fy[j] += m * d[j + BLOCK]
        fz[j] += m * d[j + 2 * BLOCK]


@kernel
def _push_end(F: np.ndarray, a: int, n: int, moment: np.ndarray, gradients: np.ndarray, first: bool) -> None:
    """Add the forces on the first or the second end of the edges of n hinges.

    These ends have the slots from a to a + n - 1. The forces on both ends balance the forces and torques of the
    opposite vertices.
    """
    fx, fy, fz = F[0, a : a + n], F[1, a : a + n], F[2, a : a + n]
    for j in range(n):
        m = moment[j]
        t2 = gradients[j + 6 * BLOCK]
        t3 = gradients[j + 7 * BLOCK]
        if first:
            t2 = ONE - t2
            t3 = ONE - t3
        fx[j] -= m * (t2 * gradients[j] + t3 * gradients[j + 3 * BLOCK])
        fy[j] -= m * (t2 * gradients[j + BLOCK] + t3 * gradients[j + 4 * BLOCK])
        fz[j] -= m * (t2 * gradients[j + 2 * BLOCK] + t3 * gradients[j + 5 * BLOCK])


@kernel
def measure(X: np.ndarray, hinges: np.ndarray, measures: HingeMeasures) -> None:
    """Measure the dihedral angles of all hinges. Moments are not computed.

    Args:
        X: Positions in slots and copies [m], shape (3, width).
        hinges: Table of the bands of hinges.
        measures: Arrays that are filled.
    """
    block = 0
    for r in range(hinges.shape[0]):
        for done in range(0, hinges[r, 1], BLOCK):
            n = min(hinges[r, 1] - done, BLOCK)
            e = hinges[r, 0] + done
            a = hinges[r, 2] + done
            b = hinges[r, 3] + done
            c = hinges[r, 4] + done
            d = hinges[r, 5] + done
            for first in range(0, n, PART):
                k = min(n - first, PART)
                i = e + first
                _set_edges(X, a + first, b + first, c + first, d + first, k, measures.edges)
                rows = measures.gradients[block, first:]
                _measure(measures.edges, k, rows, measures.g[i : i + k], measures.slope[i : i + k])
            block += 1


@kernel
def add_force(X: np.ndarray, F: np.ndarray, bending: Bending, measures: HingeMeasures) -> None:
    """Add the bending force at the positions X to F.

    Args:
        X: Positions in slots and copies [m], shape (3, width).
        F: Forces in slots and copies [N], shape (3, width).
        bending: Constants of bending.
        measures: Temporary arrays.
    """
    table = bending.couplings
    measure(X, bending.hinges, measures)
    _clear_moments(measures.g, bending.coupling_copies, measures.moment, measures.slope.shape[0])
    for r in range(table.shape[0]):
        _add_moments_of_band(
            measures.g, bending.K, table[r, 0], table[r, 1], table[r, 2], table[r, 3], table[r, 4], measures.moment
        )
    _finish_moments(bending.rest_moment, measures.slope, bending.coupling_copies, measures.moment)
    _push(F, bending.hinges, measures.moment, measures.gradients)


@kernel
def add_force_with_friction(X: np.ndarray, F: np.ndarray, bending: Bending, measures: HingeMeasures) -> None:
    """Add the bending force of cloth with hysteresis at the positions X to F, like `add_force`."""
    measure(X, bending.hinges, measures)
    _clear_moments(measures.g, bending.coupling_copies, measures.moment, measures.slope.shape[0])
    hysteresis.add_moments(measures.g, bending.friction, measures.slip, bending.couplings, measures.moment)
    _finish_moments(bending.rest_moment, measures.slope, bending.coupling_copies, measures.moment)
    _push(F, bending.hinges, measures.moment, measures.gradients)


@kernel
def _push(F: np.ndarray, table: np.ndarray, moment: np.ndarray, gradients: np.ndarray) -> None:
    """Add the forces of all moments on the four vertices of their hinges to F."""
    block = 0
    for r in range(table.shape[0]):
        for done in range(0, table[r, 1], BLOCK):
            n = min(table[r, 1] - done, BLOCK)
            e = table[r, 0] + done
            m = moment[e : e + n]
            rows = gradients[block]
            _push_apex(F, table[r, 4] + done, n, m, rows, 0)
            _push_apex(F, table[r, 5] + done, n, m, rows, 3)
            _push_end(F, table[r, 2] + done, n, m, rows, True)
            _push_end(F, table[r, 3] + done, n, m, rows, False)
            block += 1
