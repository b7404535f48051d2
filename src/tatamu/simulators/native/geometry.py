"""Small geometry for the compiled loops: products, closest points, and a grid of points."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

MOST_CELLS = 65536


@njit(cache=True, error_model="numpy", inline="always")
def cross(ax, ay, az, bx, by, bz):  # type: ignore[no-untyped-def]
    """Vector product."""
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@njit(cache=True, error_model="numpy")
def dot(a, b):  # type: ignore[no-untyped-def]
    """Scalar product of two arrays of three."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True, error_model="numpy")
def normal_of(x, a, b, c):  # type: ignore[no-untyped-def]
    """(b - a) x (c - a), twice the area long."""
    return cross(
        x[b, 0] - x[a, 0],
        x[b, 1] - x[a, 1],
        x[b, 2] - x[a, 2],
        x[c, 0] - x[a, 0],
        x[c, 1] - x[a, 1],
        x[c, 2] - x[a, 2],
    )


@njit(cache=True, error_model="numpy")
def _clamp(value):  # type: ignore[no-untyped-def]
    return min(1.0, max(0.0, value))


@njit(cache=True, error_model="numpy", inline="always")
def closest_between(ux, uy, uz, vx, vy, vz, rx, ry, rz):  # type: ignore[no-untyped-def]
    """`closest_on_segments` of edges u and v, the first beginning at r as seen from where the second does.

    Without branches, so that many may be computed at once.
    """
    uu, vv = ux * ux + uy * uy + uz * uz + 1e-30, vx * vx + vy * vy + vz * vz + 1e-30
    uv, ur, vr = ux * vx + uy * vy + uz * vz, ux * rx + uy * ry + uz * rz, vx * rx + vy * ry + vz * rz
    area = uu * vv - uv * uv
    s = _clamp((uv * vr - ur * vv) / area) if area > 1e-9 * uu * vv else 0.5
    t = (uv * s + vr) / vv
    at_start, at_end = _clamp(-ur / uu), _clamp((uv - ur) / uu)
    s = at_start if t < 0.0 else (at_end if t > 1.0 else s)
    t = 0.0 if t < 0.0 else (1.0 if t > 1.0 else t)
    dx, dy, dz = rx + s * ux - t * vx, ry + s * uy - t * vy, rz + s * uz - t * vz
    return np.sqrt(dx * dx + dy * dy + dz * dz), s, t


@njit(cache=True, error_model="numpy")
def closest_on_segments(x, a, b, c, d):  # type: ignore[no-untyped-def]
    """Distance of segments (a, b) and (c, d), and the fractions along them where it is reached."""
    ux, uy, uz = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
    vx, vy, vz = x[d, 0] - x[c, 0], x[d, 1] - x[c, 1], x[d, 2] - x[c, 2]
    rx, ry, rz = x[a, 0] - x[c, 0], x[a, 1] - x[c, 1], x[a, 2] - x[c, 2]
    return closest_between(ux, uy, uz, vx, vy, vz, rx, ry, rz)


@njit(cache=True, error_model="numpy")
def point_triangle(x, v, a, b, c, up):  # type: ignore[no-untyped-def]
    """Distance of v from triangle (a, b, c), and whether the closest point lies towards `up`."""
    abx, aby, abz = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
    acx, acy, acz = x[c, 0] - x[a, 0], x[c, 1] - x[a, 1], x[c, 2] - x[a, 2]
    apx, apy, apz = x[v, 0] - x[a, 0], x[v, 1] - x[a, 1], x[v, 2] - x[a, 2]
    d1, d2 = abx * apx + aby * apy + abz * apz, acx * apx + acy * apy + acz * apz
    bb, cc, bc = abx * abx + aby * aby + abz * abz, acx * acx + acy * acy + acz * acz, abx * acx + aby * acy + abz * acz
    area = bb * cc - bc * bc + 1e-30
    s, t = (cc * d1 - bc * d2) / area, (bb * d2 - bc * d1) / area
    if s < 0.0 or t < 0.0 or s + t > 1.0:  # nearest point of the three edges
        e1 = _clamp(d1 / bb)
        e2 = _clamp(d2 / cc)
        e3 = _clamp((d2 - d1 + bb - bc) / (bb + cc - 2.0 * bc))
        best = np.inf
        for p, q in ((e1, 0.0), (0.0, e2), (1.0 - e3, e3)):
            dx, dy, dz = p * abx + q * acx - apx, p * aby + q * acy - apy, p * abz + q * acz - apz
            square = dx * dx + dy * dy + dz * dz
            if square < best:
                best, s, t = square, p, q
    dx, dy, dz = s * abx + t * acx - apx, s * aby + t * acy - apy, s * abz + t * acz - apz
    above = dx * up[0] + dy * up[1] + dz * up[2] > 0.0
    return np.sqrt(dx * dx + dy * dy + dz * dz), above


class Grid(NamedTuple):
    """Points sorted into cells; cell (i, j, k) is number (i * shape[1] + j) * shape[2] + k."""

    origin: np.ndarray  # (3,)
    cell: np.ndarray  # (3,)
    shape: np.ndarray  # (3,)
    start: np.ndarray  # (cells + 1,): where each cell begins in `order`
    order: np.ndarray  # (points,)


@njit(cache=True, error_model="numpy")
def grid_of(points, size):  # type: ignore[no-untyped-def]
    """Sort points, shape (p, 3), into cells of at least `size`."""
    origin, cell, shape = np.empty(3), np.empty(3), np.empty(3, dtype=np.int64)
    for k in range(3):
        low, high = points[0, k], points[0, k]
        for p in range(points.shape[0]):
            low, high = min(low, points[p, k]), max(high, points[p, k])
        origin[k], cell[k] = low, size
        shape[k] = min(int((high - low) / size), MOST_CELLS) + 1
    while shape[0] * shape[1] * shape[2] > MOST_CELLS:
        k = np.argmax(shape)
        cell[k] *= 2.0
        shape[k] = shape[k] // 2 + 1
    start = np.zeros(shape[0] * shape[1] * shape[2] + 1, dtype=np.int64)
    order, at = np.empty(points.shape[0], dtype=np.int64), np.empty(points.shape[0], dtype=np.int64)
    grid = Grid(origin, cell, shape, start, order)
    for p in range(points.shape[0]):
        i, j, k = grid_cell(points[p], grid)
        at[p] = (i * shape[1] + j) * shape[2] + k
        start[at[p] + 1] += 1
    for c in range(start.shape[0] - 1):
        start[c + 1] += start[c]
    filled = start.copy()
    for p in range(points.shape[0]):
        order[filled[at[p]]] = p
        filled[at[p]] += 1
    return grid


@njit(cache=True, error_model="numpy")
def grid_cell(point, grid):  # type: ignore[no-untyped-def]
    """Cell of a point, clamped to the grid."""
    i = min(max(int((point[0] - grid.origin[0]) / grid.cell[0]), 0), grid.shape[0] - 1)
    j = min(max(int((point[1] - grid.origin[1]) / grid.cell[1]), 0), grid.shape[1] - 1)
    k = min(max(int((point[2] - grid.origin[2]) / grid.cell[2]), 0), grid.shape[2] - 1)
    return i, j, k
