"""Hysteresis of bending: elastoplastic elements, which stand for the friction of yarns, act on the curvature.

    k   = Q g                                curvatures (k_uu, k_vv, k_uv) of a triangle, see `curvature`
    q_j = k - p_j,  |q_j| <= y_j             elastic part of the curvature in element j, p_j its plastic part
    m   = D k + sum_j s_j E q_j              elastic and frictional moments, E = diag(1, 1, 2), |q|^2 = q' E q

Elements of Prandtl act side by side (Prandtl 1928; as a yarn model Zhou and Ghosh 1998). Each follows the curvature
with the stiffness s_j up to the yield curvature y_j. Then it slips: p_j changes in the direction of q_j, so that |q_j|
stays y_j. The sum of s_j y_j is the material's HB, and the slope after a reversal is B plus the sum of s_j. While an
element slips, its moment points along its slip, so every closed cycle of curvature takes energy from the cloth
(docs/theory/hysteresis.md).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tatamu.simulation.material import Material
from tatamu.simulation.native.bands import Bands
from tatamu.simulation.native.compiled import kernel
from tatamu.simulation.native.elastic.curvature import CurvatureMaps, rigidities


class Friction(NamedTuple):
    """Constants of the friction of bending, in the order of the triangles in memory; empty without hysteresis."""

    Q: np.ndarray
    """From the measures g to curvatures [1/m], row by row, shape (9, places)."""
    area: np.ndarray
    """Area of each triangle [m^2], shape (places,)."""
    stiffness: np.ndarray
    """Stiffness s_j of each element [N m], shape (elements,)."""
    limit: np.ndarray
    """Yield curvature y_j of each element [1/m], shape (elements,)."""
    rigidity: np.ndarray
    """Elastic rigidities along warp and weft, and half of that of twist [N m], shape (3,)."""


class Slip(NamedTuple):
    """State of the friction of bending, and temporary memory."""

    plastic: np.ndarray
    """Plastic parts p_j [1/m], with three rows for each element, shape (3 elements, places)."""
    curvature: np.ndarray
    """Temporary: curvatures k [1/m], shape (3, places)."""
    moment: np.ndarray
    """Temporary: sums of elastic and frictional moments, with half of the twist [N], shape (3, places)."""


def none(real: type = np.float32) -> Friction:
    """Return empty constants, for cloth without friction."""
    return Friction(*(np.zeros(shape, dtype=real) for shape in ((9, 0), (0,), (0,), (0,), (3,))))


def in_bands(couplings: Bands, curved: CurvatureMaps, material: Material, real: type = np.float32) -> Friction:
    """Return the constants of friction in the order of `couplings`, the bands of triangles."""
    elements = material.friction_elements
    if not elements:
        return none(real)
    stiffness, limit = np.array(elements, dtype=real).T.copy()
    Q: np.ndarray = couplings.spread(curved.Q.reshape(len(curved.Q), 9).T).astype(real)
    rigidity: np.ndarray = (np.diag(rigidities(material)) * [1.0, 1.0, 0.5]).astype(real)
    return Friction(Q, couplings.spread(curved.area).astype(real), stiffness, limit, rigidity)


def unslipped(friction: Friction, g0: np.ndarray, triangles: np.ndarray) -> Slip:
    """Return the state in which no element has slipped since the unstrained shape with the measures g0 and copies."""
    places = friction.area.shape[0]
    real = friction.Q.dtype
    rest = np.zeros((3, places), dtype=real)
    if places:
        _curvatures(g0.astype(real), friction.Q, triangles, rest)
    plastic = np.tile(rest, (len(friction.stiffness), 1))
    return Slip(plastic, np.zeros_like(rest), np.zeros_like(rest))


@kernel
def _curvatures(g: np.ndarray, Q: np.ndarray, triangles: np.ndarray, curvature: np.ndarray) -> None:
    """Compute the curvatures of all triangles from the measures g [1/m], shape (3, places)."""
    for r in range(triangles.shape[0]):
        e = triangles[r, 0]
        n = triangles[r, 1]
        a = triangles[r, 2]
        b = triangles[r, 3]
        c = triangles[r, 4]
        g0, g1, g2 = g[a : a + n], g[b : b + n], g[c : c + n]
        for k in range(3):
            out = curvature[k, e : e + n]
            q0, q1, q2 = Q[3 * k, e : e + n], Q[3 * k + 1, e : e + n], Q[3 * k + 2, e : e + n]
            for j in range(n):
                out[j] = q0[j] * g0[j] + q1[j] * g1[j] + q2[j] * g2[j]


@kernel
def _slide(plastic: np.ndarray, curvature: np.ndarray, moment: np.ndarray, stiffness: float, limit: float) -> None:
    """Let one element with the yield curvature `limit` [1/m] slip where it is exceeded, and add its moment [N]."""
    n = curvature.shape[1]
    k0, k1, k2 = curvature[0, :n], curvature[1, :n], curvature[2, :n]
    p0, p1, p2 = plastic[0, :n], plastic[1, :n], plastic[2, :n]
    m0, m1, m2 = moment[0, :n], moment[1, :n], moment[2, :n]
    one = limit / limit  # both numbers must have the precision of the arrays
    zero = limit - limit
    for i in range(n):
        q0 = k0[i] - p0[i]
        q1 = k1[i] - p1[i]
        q2 = k2[i] - p2[i]
        size = np.sqrt(q0 * q0 + q1 * q1 + q2 * q2 + q2 * q2)
        slip = max(size - limit, zero) / max(size, limit)
        p0[i] += slip * q0
        p1[i] += slip * q1
        p2[i] += slip * q2
        kept = stiffness * (one - slip)
        m0[i] += kept * q0
        m1[i] += kept * q1
        m2[i] += kept * q2


@kernel
def _add_moments_of_band(
    bent: np.ndarray, friction: Friction, e: int, n: int, a: int, b: int, c: int, moment: np.ndarray
) -> None:
    """Add the moments A Q' E m of n triangles from place e on, where m is `bent`, to their hinges.

    The hinges of triangle j are stored at a + j, b + j and c + j.
    """
    Q = friction.Q
    area = friction.area[e : e + n]
    m0, m1, m2 = bent[0, e : e + n], bent[1, e : e + n], bent[2, e : e + n]
    for h in range(3):
        place = a if h == 0 else (b if h == 1 else c)
        out = moment[place : place + n]
        q0, q1, q2 = Q[h, e : e + n], Q[3 + h, e : e + n], Q[6 + h, e : e + n]
        for j in range(n):
            out[j] += area[j] * (q0[j] * m0[j] + q1[j] * m1[j] + q2[j] * (m2[j] + m2[j]))


@kernel
def add_moments(g: np.ndarray, friction: Friction, slip: Slip, triangles: np.ndarray, moment: np.ndarray) -> None:
    """Let all elements of friction slip, and add the moments that resist the measures g to the hinges [N m].

    The elastic moments equal K_T g, but are computed without reading K_T from memory.
    """
    _curvatures(g, friction.Q, triangles, slip.curvature)
    for k in range(3):
        bent = slip.curvature[k]
        resisting = slip.moment[k]
        rigidity = friction.rigidity[k]
        for i in range(bent.shape[0]):
            resisting[i] = rigidity * bent[i]
    for j in range(friction.stiffness.shape[0]):
        plastic = slip.plastic[3 * j : 3 * j + 3]
        _slide(plastic, slip.curvature, slip.moment, friction.stiffness[j], friction.limit[j])
    for r in range(triangles.shape[0]):
        e, n, a, b, c = triangles[r, 0], triangles[r, 1], triangles[r, 2], triangles[r, 3], triangles[r, 4]
        _add_moments_of_band(slip.moment, friction, e, n, a, b, c, moment)
