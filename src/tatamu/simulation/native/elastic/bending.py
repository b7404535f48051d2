"""Bending forces. Each triangle combines the dihedral angles at its edges to its curvature (docs/theory/bending.md).

    g   = 4 tan(theta / 4)                      theta: dihedral angle, 0 when flat; g keeps tight loops open
    K_T = A_T Q' D Q                            stiffness of triangle T, see `curvature`
    W   = sum_T 1/2 (g - g0)' K_T (g - g0)      energy, over the inner edges of T; g0: g of the unstrained shape

Bending has no Poisson effect, so a narrow strip and a wide sheet have the same moment per width and curvature B.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from tatamu.simulation.material import Material
from tatamu.simulation.native.bands import BLOCK, Bands, bands, blocks
from tatamu.simulation.native.compiled import kernel
from tatamu.simulation.native.elastic import hysteresis, symmetric
from tatamu.simulation.native.elastic.curvature import CurvatureMaps
from tatamu.simulation.native.elastic.hysteresis import Friction, Slip

# Constants in single precision. A plain 0.5 would convert everything that it is multiplied by to double precision.
TINY: Any = np.float32(1e-30)
HALF: Any = np.float32(0.5)
ZERO: Any = np.float32(0.0)
ONE: Any = np.float32(1.0)
FOUR: Any = np.float32(4.0)
WIDE: Any = np.float32(0.4)
"""Minimum cosine of half a dihedral angle that is used as a divisor [-]."""

PART = BLOCK // 3
"""Number of hinges whose edges are kept in the nearest cache."""


class Bending(NamedTuple):
    """Constants of bending, in the order of memory, with zeros at places without a hinge or a triangle.

    A hinge is an inner edge with the ends a and b, and with the vertices c and d opposite it.
    """

    hinges: np.ndarray
    """Table of the bands of hinges, with the slots of their vertices."""
    copies: np.ndarray
    """Slots that some hinges need as copies."""
    rest_moment: np.ndarray
    """Moment K g0 of each hinge in the unstrained shape [N m], shape (hinge places,)."""
    couplings: np.ndarray
    """Table of the bands of triangles, with the places of their hinges."""
    coupling_copies: np.ndarray
    """Places of hinges that some triangles need as copies behind the last hinge."""
    friction: Friction
    K: np.ndarray
    """Stiffness K_T of each triangle [N m], packed as in `symmetric`, shape (6, triangle places)."""


class HingeMeasures(NamedTuple):
    """Temporary arrays for all hinges in the order of memory; `g` and `moment` have room for copies."""

    gradients: np.ndarray
    """For each block of a band, eight rows of BLOCK numbers, shape (`blocks(hinges)`, 8 BLOCK). Rows 0 to 2 are d theta
    / dx of the vertex c [1/m], rows 3 to 5 of d, and rows 6 and 7 the feet of c and d as fractions of the edge."""
    edges: np.ndarray
    """Rows of PART numbers with the edges of some hinges [m], shape (9 PART,)."""
    g: np.ndarray
    """Measure g = 4 tan(theta / 4) of each hinge [-]."""
    slope: np.ndarray
    """Derivative g' = d g / d theta [-]."""
    moment: np.ndarray
    """Moment at each hinge [N m]."""
    slip: Slip
    """State of the friction of bending, which cloth with hysteresis keeps from step to step."""


def scratch(
    hinges: np.ndarray, places: int, copies: int, real: type = np.float32, slip: Slip | None = None
) -> HingeMeasures:
    """Return temporary arrays for places of hinges and copies, in the precision of forces."""
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
    """Return the constants of bending in the order of memory.

    K comes from `curvature.stiffness`, `rest_moment` is the moment of each hinge in the unstrained shape [N m], and
    `real` is the precision in which forces are computed.
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
    """Fill `gradients`, `g` and `slope` of n hinges from the rows m of `_set_edges`.

    With a number in double precision, the compiler would use half of each vector register.
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
    """Add the moments K_T g of n triangles from place e on, whose hinges are at a + j, b + j and c + j."""
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
    """Copy the measures of some hinges behind the last of `count` hinges, and set all moments to zero."""
    for i in range(copies.shape[0]):
        g[count + i] = g[copies[i]]
    for h in range(moment.shape[0]):
        moment[h] = ZERO


@kernel
def _finish_moments(rest_moment: np.ndarray, slope: np.ndarray, copies: np.ndarray, moment: np.ndarray) -> None:
    """Turn the resisting moment K g of every hinge into (K g0 - K g) g'."""
    count = slope.shape[0]
    for i in range(copies.shape[0]):
        moment[copies[i]] += moment[count + i]
    for h in range(count):
        moment[h] = (rest_moment[h] - moment[h]) * slope[h]


@kernel
def _push_apex(F: np.ndarray, c: int, n: int, moment: np.ndarray, gradients: np.ndarray, row: int) -> None:
    """Add the forces on one opposite vertex of n hinges, slots from c on, with its derivatives from `row` on."""
    fx, fy, fz = F[0, c : c + n], F[1, c : c + n], F[2, c : c + n]
    d = gradients[row * BLOCK :]
    for j in range(n):
        m = moment[j]
        fx[j] += m * d[j]
        fy[j] += m * d[j + BLOCK]
        fz[j] += m * d[j + 2 * BLOCK]


@kernel
def _push_end(F: np.ndarray, a: int, n: int, moment: np.ndarray, gradients: np.ndarray, first: bool) -> None:
    """Add the forces on the first or second end of n hinges, slots from a on, which balance those on c and d."""
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
    """Measure the dihedral angles of all hinges at the positions X [m], without moments."""
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
    """Add the bending force at the positions X [m] to F [N], both in slots and copies."""
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
    """Add the bending force of cloth with hysteresis, like `add_force`."""
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
