"""Signed distance of a rounded box, its normal, and its minimum along an edge, all in the frame of the body."""

from __future__ import annotations

import numpy as np

from tatamu.simulation.native.compiled import kernel

BISECTIONS = 14
"""Number of bisections, which find the nearest point of an edge of 20 mm to about a micrometre."""


@kernel
def distance(half: np.ndarray, radius: float, x: float, y: float, z: float) -> tuple[float, float, float, float]:
    """Return the signed distance of a point from a body [m], negative inside, and the outward unit normal there."""
    qx, qy, qz = abs(x) - half[0], abs(y) - half[1], abs(z) - half[2]
    sx = 1.0 if x >= 0.0 else -1.0
    sy = 1.0 if y >= 0.0 else -1.0
    sz = 1.0 if z >= 0.0 else -1.0
    if qx <= 0.0 and qy <= 0.0 and qz <= 0.0:  # in the core: out through the nearest of its faces
        if qx >= qy and qx >= qz:
            return qx - radius, sx, 0.0, 0.0
        if qy >= qz:
            return qy - radius, 0.0, sy, 0.0
        return qz - radius, 0.0, 0.0, sz
    qx = max(qx, 0.0)
    qy = max(qy, 0.0)
    qz = max(qz, 0.0)
    away = np.sqrt(qx * qx + qy * qy + qz * qz)
    return away - radius, sx * qx / away, sy * qy / away, sz * qz / away


@kernel
def along_edge(half: np.ndarray, radius: float, a: np.ndarray, b: np.ndarray, within: float) -> float:
    """Return the fraction along an edge at which it is nearest to the body.

    It is -1 if the distance is smallest at an end, or is nowhere below `within` [m].
    """
    ex, ey, ez = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    at_a, nx, ny, nz = distance(half, radius, a[0], a[1], a[2])
    down = nx * ex + ny * ey + nz * ez  # change of the distance over the edge, by its slope at the beginning
    at_b, nx, ny, nz = distance(half, radius, b[0], b[1], b[2])
    up = nx * ex + ny * ey + nz * ez
    if down >= 0.0 or up <= 0.0:
        return -1.0
    meet = (at_b - up - at_a) / (down - up)
    if at_a + down * meet >= within:  # where the tangents at both ends meet: a convex function is above its tangents
        return -1.0
    low = 0.0
    high = 1.0
    level = 1e-9 * np.sqrt(ex * ex + ey * ey + ez * ez)  # a smaller slope counts as parallel to the surface
    for _ in range(BISECTIONS):
        s = 0.5 * (low + high)
        _, nx, ny, nz = distance(half, radius, a[0] + s * ex, a[1] + s * ey, a[2] + s * ez)
        slope = nx * ex + ny * ey + nz * ez
        if abs(slope) <= level:
            return s
        if slope < 0.0:
            low = s
        else:
            high = s
    return 0.5 * (low + high)
