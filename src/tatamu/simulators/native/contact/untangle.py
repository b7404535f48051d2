"""Layers that went through one another in a pinch come apart when the hand opens.

A hand keeps the arrangement of what it holds, while the cloth beside it may turn over, as a hem does when the garment
is folded: the layers then lie in one order in the pinch and in the other beside it. Real cloth leaves a tongue as deep
as the fingers and turns around it; on a mesh the pinch may be a single row of vertices, which has no depth, and edges
pass through triangles. Contact, which keeps every vertex on its side, would keep them so.

Where an edge passes through a triangle, the curve along which the two layers meet begins, ends or goes on. The edge is
moved against the triangle in the direction in which that curve gets shorter fastest (Volino and Magnenat-Thalmann 2006,
"Resolving surface collisions through intersection contour minimization"), which needs no memory of which layer was on
which side; then the edges get back their lengths, which takes the cloth around along.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from tatamu.crossings import crossing_pairs
from tatamu.simulators.native.contact.broad_phase import Mesh
from tatamu.simulators.native.geometry import cross, normal_of
from tatamu.topology import areas, edge_lengths, longest_sides

STEP = 0.3
"""How far one pass moves an edge against a triangle, in thicknesses."""
MOST_PASSES = 60
FLATTEST = 1e-3
"""An edge less steep on a triangle than this sine counts as this steep."""
BLUNT = 0.1
"""Where the sum of the directions is not longer than this, it tells little, and the pass moves less."""
SHORTEST, LONGEST = 0.7, 1.1
"""Edges keep between these parts of their rest lengths; farther, and the membrane would throw them back."""
SLIMMEST = 0.1
"""Triangles stay higher than this part of the shortest edge, or than they were: bending forces go with the inverse."""
SWEEPS = 4
"""Sweeps per pass that give edges back such lengths."""


def untangle(x: np.ndarray, mesh: Mesh, lengths: np.ndarray) -> tuple[np.ndarray, int]:
    """Move the cloth out of itself; what is not tangled stays where it is to the last bit.

    Args:
        x: Positions [m], shape (n, 3).
        mesh: The mesh; held vertices stay where they are.
        lengths: Of its edges at rest [m], shape (e,).

    Returns:
        The positions with the fewest crossings that were found, x itself where none has fewer, and how many are left.
    """
    best, pairs = x, crossing_pairs(x, mesh.faces, mesh.edges)
    if not len(pairs):
        return best, 0
    now = edge_lengths(x, mesh.edges)
    low, high = np.minimum(SHORTEST * lengths, now), np.maximum(LONGEST * lengths, now)
    slimmest = min(SLIMMEST * lengths.min(), _slimmest(x, mesh.faces))
    fewest, passes, x = len(pairs), 0, x.copy()
    while len(pairs) and passes < MOST_PASSES:
        _part(x, pairs, mesh, STEP * mesh.reach[0])
        _keep_lengths(x, mesh.edges, low, high, mesh.inverse_mass)
        pairs, passes = crossing_pairs(x, mesh.faces, mesh.edges), passes + 1
        if len(pairs) < fewest and _slimmest(x, mesh.faces) > slimmest:
            best, fewest = x.copy(), len(pairs)
    return best, fewest


def _slimmest(x: np.ndarray, faces: np.ndarray) -> float:
    """Smallest height of all triangles [m]."""
    return float((2.0 * areas(x, faces) / (longest_sides(x, faces) + 1e-30)).min())


@njit(cache=True, error_model="numpy")
def _unit(x, y, z):  # type: ignore[no-untyped-def]
    scale = 1.0 / (np.sqrt(x * x + y * y + z * z) + 1e-30)
    return scale * x, scale * y, scale * z


@njit(cache=True, error_model="numpy")
def _shortening(x, e, t, mesh):  # type: ignore[no-untyped-def]
    """The way that edge e should move against triangle t: the sum of R - 2 (E R) / (E N) N over the edge's triangles.

    E and N are the unit vectors along the edge and across the triangle; R runs along the curve from the edge into one
    of its own triangles.
    """
    p, q = mesh.edges[e, 0], mesh.edges[e, 1]
    nx, ny, nz = _unit(*normal_of(x, mesh.faces[t, 0], mesh.faces[t, 1], mesh.faces[t, 2]))
    ex, ey, ez = _unit(x[q, 0] - x[p, 0], x[q, 1] - x[p, 1], x[q, 2] - x[p, 2])
    lean = ex * nx + ey * ny + ez * nz
    gx, gy, gz = 0.0, 0.0, 0.0
    for side in range(2):
        own = mesh.edge_faces[e, side]
        if own < 0:
            continue
        o = mesh.faces[own, 0] + mesh.faces[own, 1] + mesh.faces[own, 2] - p - q
        ix, iy, iz = x[o, 0] - x[p, 0], x[o, 1] - x[p, 1], x[o, 2] - x[p, 2]
        up, along = nx * ix + ny * iy + nz * iz, ex * ix + ey * iy + ez * iz
        rx, ry, rz = _unit(up * ex - lean * ix, up * ey - lean * iy, up * ez - lean * iz)  # N x (E x I)
        inwards = rx * (ix - along * ex) + ry * (iy - along * ey) + rz * (iz - along * ez)
        rx, ry, rz = (rx, ry, rz) if inwards > 0.0 else (-rx, -ry, -rz)
        slope = 2.0 * (ex * rx + ey * ry + ez * rz) / np.copysign(max(abs(lean), FLATTEST), lean)
        gx, gy, gz = gx + rx - slope * nx, gy + ry - slope * ny, gz + rz - slope * nz
    return gx, gy, gz


@njit(cache=True, error_model="numpy")
def _meeting(x, e, t, mesh):  # type: ignore[no-untyped-def]
    """Where edge e passes through triangle t: the fraction along the edge, barycentric coordinates in the triangle."""
    p, q = mesh.edges[e, 0], mesh.edges[e, 1]
    a, b, c = mesh.faces[t, 0], mesh.faces[t, 1], mesh.faces[t, 2]
    nx, ny, nz = normal_of(x, a, b, c)
    below = nx * (x[a, 0] - x[p, 0]) + ny * (x[a, 1] - x[p, 1]) + nz * (x[a, 2] - x[p, 2])
    s = below / (nx * (x[q, 0] - x[p, 0]) + ny * (x[q, 1] - x[p, 1]) + nz * (x[q, 2] - x[p, 2]))
    mx, my, mz = (1 - s) * x[p, 0] + s * x[q, 0], (1 - s) * x[p, 1] + s * x[q, 1], (1 - s) * x[p, 2] + s * x[q, 2]
    mx, my, mz = mx - x[a, 0], my - x[a, 1], mz - x[a, 2]
    square = nx * nx + ny * ny + nz * nz
    kx, ky, kz = cross(mx, my, mz, x[c, 0] - x[a, 0], x[c, 1] - x[a, 1], x[c, 2] - x[a, 2])
    second = (kx * nx + ky * ny + kz * nz) / square
    kx, ky, kz = cross(x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2], mx, my, mz)
    third = (kx * nx + ky * ny + kz * nz) / square
    return s, 1.0 - second - third, second, third


@njit(cache=True, error_model="numpy")
def _part(x, pairs, mesh, step):  # type: ignore[no-untyped-def]
    """Move each edge against the triangle that it passes through; a vertex of several pairs by the mean."""
    shift, weight = np.zeros_like(x), np.zeros(x.shape[0])
    for i in range(pairs.shape[0]):
        e, t = pairs[i, 0], pairs[i, 1]
        gx, gy, gz = _shortening(x, e, t, mesh)
        scale = step / np.sqrt(gx * gx + gy * gy + gz * gz + BLUNT * BLUNT)
        s, first, second, third = _meeting(x, e, t, mesh)
        p, q, a, b, c = mesh.edges[e, 0], mesh.edges[e, 1], mesh.faces[t, 0], mesh.faces[t, 1], mesh.faces[t, 2]
        for v, share in ((p, 1.0 - s), (q, s), (a, -first), (b, -second), (c, -third)):
            shift[v, 0] += share * scale * gx
            shift[v, 1] += share * scale * gy
            shift[v, 2] += share * scale * gz
            weight[v] += abs(share)
    for v in range(x.shape[0]):
        if weight[v] > 0.0 and mesh.inverse_mass[v] > 0.0:
            for k in range(3):
                x[v, k] += shift[v, k] / max(weight[v], 1.0)


@njit(cache=True, error_model="numpy")
def _keep_lengths(x, edges, low, high, inverse_mass):  # type: ignore[no-untyped-def]
    """Bring every edge between its lengths, in turn."""
    for number in range(SWEEPS * edges.shape[0]):
        e = number % edges.shape[0]
        p, q = edges[e, 0], edges[e, 1]
        dx, dy, dz = x[q, 0] - x[p, 0], x[q, 1] - x[p, 1], x[q, 2] - x[p, 2]
        length, mobility = np.sqrt(dx * dx + dy * dy + dz * dz) + 1e-30, inverse_mass[p] + inverse_mass[q]
        if low[e] <= length <= high[e] or mobility == 0.0:
            continue
        pull = (length - min(max(length, low[e]), high[e])) / (length * mobility)
        for v, share in ((p, inverse_mass[p]), (q, -inverse_mass[q])):
            x[v, 0] += share * pull * dx
            x[v, 1] += share * pull * dy
            x[v, 2] += share * pull * dz
