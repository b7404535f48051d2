"""Separates layers that passed through one another where a hand pinches them, when the hand opens.

A hand keeps the orientation of the held cloth, but the cloth next to it may turn over, as a hem does in a fold. A pinch
may be a single row of vertices without depth, so edges then pass through triangles, and contact would keep these
crossings, because it keeps every vertex on its side. Each edge and triangle are therefore moved relative to each other
in the direction in which the curve of intersection shortens fastest (Volino and Magnenat-Thalmann 2006, "Resolving
surface collisions through intersection contour minimization"), which needs no memory of sides. Then the lengths of
edges are restored, which also moves the cloth around the crossing.
"""

from __future__ import annotations

import numpy as np

from tatamu.simulation.mesh.crossings import crossing_pairs
from tatamu.simulation.mesh.topology import areas, edge_lengths, longest_sides
from tatamu.simulation.native.compiled import allocating, kernel
from tatamu.simulation.native.contact.state import ContactMesh
from tatamu.simulation.native.geometry import TINY_LENGTH, Vector, cross, difference, normal_of, unit
from tatamu.simulation.native.options import UntangleOptions


def untangle(x: np.ndarray, mesh: ContactMesh, lengths: np.ndarray, options: UntangleOptions) -> tuple[np.ndarray, int]:
    """Return the positions with the fewest crossings that were found, and the number of these crossings.

    If none have fewer than x, x itself is returned. Held vertices stay where they are. `lengths` are those of the edges
    at rest [m], shape (e,).
    """
    best = x
    pairs = crossing_pairs(x, mesh.faces, mesh.edges)
    if not len(pairs):
        return best, 0
    now = edge_lengths(x, mesh.edges)
    shortest = np.minimum(options.shortest * lengths, now)
    longest = np.maximum(options.longest * lengths, now)
    slimmest = min(options.slimmest * lengths.min(), smallest_height(x, mesh.faces))
    fewest = len(pairs)
    passes = 0
    x = x.copy()
    while len(pairs) and passes < options.most_passes:
        before = x.copy()
        _part(x, pairs, mesh, options.step * mesh.thickness, options.flattest, options.blunt)
        _keep_lengths(x, mesh.edges, shortest, longest, mesh.inverse_mass, options.length_sweeps)
        pairs = crossing_pairs_after(x, before, pairs, mesh)
        passes += 1
        if len(pairs) < fewest and smallest_height(x, mesh.faces) > slimmest:
            best = x.copy()
            fewest = len(pairs)
    return best, fewest


def crossing_pairs_after(x: np.ndarray, before: np.ndarray, pairs: np.ndarray, mesh: ContactMesh) -> np.ndarray:
    """Return the pairs that cross after a pass, testing only those with a moved vertex or that crossed before it."""
    moved = (x != before).any(axis=1)
    wanted_edges = moved[mesh.edges].any(axis=1)
    wanted_edges[pairs[:, 0]] = True
    return crossing_pairs(x, mesh.faces, mesh.edges, (moved[mesh.faces].any(axis=1), wanted_edges))


def smallest_height(x: np.ndarray, faces: np.ndarray) -> float:
    """Return the smallest height of all triangles [m]."""
    return float((2.0 * areas(x, faces) / (longest_sides(x, faces) + TINY_LENGTH)).min())


@kernel
def _shortening(x: np.ndarray, e: int, t: int, mesh: ContactMesh, flattest: float) -> Vector:
    """Return the direction G in which edge e should move relative to triangle t, through which it passes.

    G = sum of R - 2 (E R) / (E N) N over the edge's triangles, with unit vectors E along the edge, N along the normal
    of t, and R along the curve of intersection, from the edge into its triangle.
    """
    p, q = mesh.edges[e, 0], mesh.edges[e, 1]
    nx, ny, nz = unit(*normal_of(x, mesh.faces[t, 0], mesh.faces[t, 1], mesh.faces[t, 2]))
    ex, ey, ez = unit(*difference(x, q, p))
    lean = ex * nx + ey * ny + ez * nz
    gx, gy, gz = 0.0, 0.0, 0.0
    for side in range(2):
        own = mesh.edge_faces[e, side]
        if own < 0:
            continue
        o = mesh.faces[own, 0] + mesh.faces[own, 1] + mesh.faces[own, 2] - p - q
        ix, iy, iz = difference(x, o, p)
        up = nx * ix + ny * iy + nz * iz
        along = ex * ix + ey * iy + ez * iz
        rx, ry, rz = unit(up * ex - lean * ix, up * ey - lean * iy, up * ez - lean * iz)  # N x (E x I)
        inwards = rx * (ix - along * ex) + ry * (iy - along * ey) + rz * (iz - along * ez)
        if not inwards > 0.0:
            rx, ry, rz = -rx, -ry, -rz
        slope = 2.0 * (ex * rx + ey * ry + ez * rz) / np.copysign(max(abs(lean), flattest), lean)
        gx, gy, gz = gx + rx - slope * nx, gy + ry - slope * ny, gz + rz - slope * nz
    return gx, gy, gz


@kernel
def _meeting(x: np.ndarray, e: int, t: int, mesh: ContactMesh) -> tuple[float, float, float, float]:
    """Return where edge e meets triangle t: the fraction along the edge, and the barycentric coordinates."""
    p, q = mesh.edges[e, 0], mesh.edges[e, 1]
    a, b, c = mesh.faces[t, 0], mesh.faces[t, 1], mesh.faces[t, 2]
    nx, ny, nz = normal_of(x, a, b, c)
    bx, by, bz = difference(x, a, p)
    ex, ey, ez = difference(x, q, p)
    below = nx * bx + ny * by + nz * bz
    s = below / (nx * ex + ny * ey + nz * ez)
    mx = (1 - s) * x[p, 0] + s * x[q, 0] - x[a, 0]
    my = (1 - s) * x[p, 1] + s * x[q, 1] - x[a, 1]
    mz = (1 - s) * x[p, 2] + s * x[q, 2] - x[a, 2]
    square = nx * nx + ny * ny + nz * nz
    ux, uy, uz = difference(x, b, a)
    wx, wy, wz = difference(x, c, a)
    kx, ky, kz = cross(mx, my, mz, wx, wy, wz)
    second = (kx * nx + ky * ny + kz * nz) / square
    kx, ky, kz = cross(ux, uy, uz, mx, my, mz)
    third = (kx * nx + ky * ny + kz * nz) / square
    return s, 1.0 - second - third, second, third


@allocating
def _part(x: np.ndarray, pairs: np.ndarray, mesh: ContactMesh, step: float, flattest: float, blunt: float) -> None:
    """Move each edge relative to the triangle that it passes through; a vertex of several pairs moves by their mean."""
    shift = np.zeros_like(x)
    weight = np.zeros(x.shape[0])
    for i in range(pairs.shape[0]):
        e, t = pairs[i, 0], pairs[i, 1]
        gx, gy, gz = _shortening(x, e, t, mesh, flattest)
        scale = step / np.sqrt(gx * gx + gy * gy + gz * gz + blunt * blunt)
        s, first, second, third = _meeting(x, e, t, mesh)
        p, q = mesh.edges[e, 0], mesh.edges[e, 1]
        a, b, c = mesh.faces[t, 0], mesh.faces[t, 1], mesh.faces[t, 2]
        for v, share in ((p, 1.0 - s), (q, s), (a, -first), (b, -second), (c, -third)):
            shift[v, 0] += share * scale * gx
            shift[v, 1] += share * scale * gy
            shift[v, 2] += share * scale * gz
            weight[v] += abs(share)
    for v in range(x.shape[0]):
        if weight[v] > 0.0 and mesh.inverse_mass[v] > 0.0:
            for k in range(3):
                x[v, k] += shift[v, k] / max(weight[v], 1.0)


@kernel
def _keep_lengths(
    x: np.ndarray, edges: np.ndarray, shortest: np.ndarray, longest: np.ndarray, inverse_mass: np.ndarray, sweeps: int
) -> None:
    """Bring the length of every edge between its limits [m], one edge after another (position-based Gauss-Seidel)."""
    for number in range(sweeps * edges.shape[0]):
        e = number % edges.shape[0]
        p, q = edges[e, 0], edges[e, 1]
        dx, dy, dz = difference(x, q, p)
        length = np.sqrt(dx * dx + dy * dy + dz * dz) + TINY_LENGTH
        mobility = inverse_mass[p] + inverse_mass[q]
        if shortest[e] <= length <= longest[e] or mobility == 0.0:
            continue
        pull = (length - min(max(length, shortest[e]), longest[e])) / (length * mobility)
        for v, share in ((p, inverse_mass[p]), (q, -inverse_mass[q])):
            x[v, 0] += share * pull * dx
            x[v, 1] += share * pull * dy
            x[v, 2] += share * pull * dz
