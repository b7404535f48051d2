"""Vectors, normals and closest points for compiled loops; a vector is three numbers, which stay in registers."""

from __future__ import annotations

import numpy as np

from tatamu.simulation.native.compiled import inlined, kernel

Vector = tuple[float, float, float]

TINY_LENGTH = 1e-30
"""Added to lengths and squares that are used as divisors, because they may be zero."""


@inlined
def cross(ax: float, ay: float, az: float, bx: float, by: float, bz: float) -> Vector:
    """Return the vector product of a and b."""
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@kernel
def dot(a: np.ndarray, b: np.ndarray) -> float:
    """Return the scalar product of two arrays of three numbers."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def copy(x: np.ndarray, to: np.ndarray) -> None:
    """Copy positions to another array, because numba compiles an assignment of arrays ten times as long."""
    for v in range(x.shape[0]):
        for k in range(3):
            to[v, k] = x[v, k]


@kernel
def longest_displacement(x: np.ndarray, start: np.ndarray) -> float:
    """Return the longest distance of a vertex between two sets of positions [m]."""
    square = 0.0
    for v in range(x.shape[0]):
        dx = x[v, 0] - start[v, 0]
        dy = x[v, 1] - start[v, 1]
        dz = x[v, 2] - start[v, 2]
        square = max(square, dx * dx + dy * dy + dz * dz)
    return np.sqrt(square)


@inlined
def difference(x: np.ndarray, v: int, a: int) -> Vector:
    """Return the vector from vertex a to vertex v [m]."""
    return x[v, 0] - x[a, 0], x[v, 1] - x[a, 1], x[v, 2] - x[a, 2]


@kernel
def unit(x: float, y: float, z: float) -> Vector:
    """Return a vector divided by its length."""
    scale = 1.0 / (np.sqrt(x * x + y * y + z * z) + TINY_LENGTH)
    return scale * x, scale * y, scale * z


@kernel
def normal_of(x: np.ndarray, a: int, b: int, c: int) -> Vector:
    """Return (b - a) x (c - a), along the normal and as long as twice the triangle's area [m^2]."""
    ux, uy, uz = difference(x, b, a)
    vx, vy, vz = difference(x, c, a)
    return cross(ux, uy, uz, vx, vy, vz)


@kernel
def _clamp(value: float) -> float:
    return min(1.0, max(0.0, value))


@inlined
def closest_between(
    ux: float, uy: float, uz: float, vx: float, vy: float, vz: float, rx: float, ry: float, rz: float
) -> Vector:
    """Return the distance of segments u and v [m], and the fractions along u and v at their closest points.

    r leads from the start of v to the start of u. Without branches, many pairs can be computed together.
    """
    uu = ux * ux + uy * uy + uz * uz + TINY_LENGTH
    vv = vx * vx + vy * vy + vz * vz + TINY_LENGTH
    uv = ux * vx + uy * vy + uz * vz
    ur = ux * rx + uy * ry + uz * rz
    vr = vx * rx + vy * ry + vz * rz
    area = uu * vv - uv * uv
    s = _clamp((uv * vr - ur * vv) / area) if area > 1e-9 * uu * vv else 0.5  # any value if the segments are parallel
    t = (uv * s + vr) / vv
    at_start = _clamp(-ur / uu)
    at_end = _clamp((uv - ur) / uu)
    s = at_start if t < 0.0 else (at_end if t > 1.0 else s)
    t = 0.0 if t < 0.0 else (1.0 if t > 1.0 else t)
    dx = rx + s * ux - t * vx
    dy = ry + s * uy - t * vy
    dz = rz + s * uz - t * vz
    return np.sqrt(dx * dx + dy * dy + dz * dz), s, t


@kernel
def closest_on_segments(x: np.ndarray, a: int, b: int, c: int, d: int) -> Vector:
    """Return the distance of segments (a, b) and (c, d) [m], and the fractions along them at their closest points."""
    ux, uy, uz = difference(x, b, a)
    vx, vy, vz = difference(x, d, c)
    rx, ry, rz = difference(x, a, c)
    return closest_between(ux, uy, uz, vx, vy, vz, rx, ry, rz)


@kernel
def point_triangle(x: np.ndarray, v: int, a: int, b: int, c: int, up: np.ndarray) -> tuple[float, bool]:
    """Return the distance of vertex v from triangle (a, b, c) [m], and whether its closest point is above v.

    Above is the direction `up`, shape (3,).
    """
    abx, aby, abz = difference(x, b, a)
    acx, acy, acz = difference(x, c, a)
    apx, apy, apz = difference(x, v, a)
    d1 = abx * apx + aby * apy + abz * apz
    d2 = acx * apx + acy * apy + acz * apz
    bb = abx * abx + aby * aby + abz * abz
    cc = acx * acx + acy * acy + acz * acz
    bc = abx * acx + aby * acy + abz * acz
    area = bb * cc - bc * bc + TINY_LENGTH
    s = (cc * d1 - bc * d2) / area
    t = (bb * d2 - bc * d1) / area
    if s < 0.0 or t < 0.0 or s + t > 1.0:  # the nearest point is on one of the three edges
        e1 = _clamp(d1 / bb)
        e2 = _clamp(d2 / cc)
        e3 = _clamp((d2 - d1 + bb - bc) / (bb + cc - 2.0 * bc))
        best = np.inf
        for p, q in ((e1, 0.0), (0.0, e2), (1.0 - e3, e3)):
            dx, dy, dz = p * abx + q * acx - apx, p * aby + q * acy - apy, p * abz + q * acz - apz
            square = dx * dx + dy * dy + dz * dz
            if square < best:
                best = square
                s = p
                t = q
    dx, dy, dz = s * abx + t * acx - apx, s * aby + t * acy - apy, s * abz + t * acz - apz
    above = dx * up[0] + dy * up[1] + dz * up[2] > 0.0
    return np.sqrt(dx * dx + dy * dy + dz * dz), above
