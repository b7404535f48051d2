"""The last resort of contact: parts that have passed through each other in spite of it move as one for a step.

Where hands crush many layers, corrections of one pair undo those of another, and a pair may end a step on the wrong
side. All four vertices of such a pair, and of pairs that share vertices with it, are then a *zone*: it is set back to
the legal positions before the step and moved by its mean motion, which keeps its momentum and every distance within it.
Rigid impact zones go back to Provot (1997).
"""

from __future__ import annotations

import numpy as np
from numba import njit

from tatamu.simulators.native.contact.projection import RESTLESS_FOR
from tatamu.simulators.native.geometry import closest_on_segments, normal_of

MOST_PASSES = 30
"""A zone may run into what is beside it; after so many passes the rest is left to the next step."""
INSIDE = -0.02


@njit(cache=True, error_model="numpy")
def _root(zone, v):  # type: ignore[no-untyped-def]
    while zone[v] != v:
        zone[v] = zone[zone[v]]
        v = zone[v]
    return v


@njit(cache=True, error_model="numpy")
def _join(zone, a, b):  # type: ignore[no-untyped-def]
    """Put two vertices into one zone; -1 stands for vertices in none."""
    for v in (a, b):
        if zone[v] < 0:
            zone[v] = v
    zone[_root(zone, a)] = _root(zone, b)


@njit(cache=True, error_model="numpy")
def _together(zone, a, b, c, d):  # type: ignore[no-untyped-def]
    """Whether four vertices are in one zone."""
    if zone[a] < 0 or zone[b] < 0 or zone[c] < 0 or zone[d] < 0:
        return False
    root = _root(zone, a)
    return _root(zone, b) == root and _root(zone, c) == root and _root(zone, d) == root


@njit(cache=True, error_model="numpy")
def _apart(x, a, b, c, d):  # type: ignore[no-untyped-def]
    """The shortest vector from segment (c, d) to segment (a, b)."""
    _, s, t = closest_on_segments(x, a, b, c, d)
    rx = (1 - s) * x[a, 0] + s * x[b, 0] - (1 - t) * x[c, 0] - t * x[d, 0]
    ry = (1 - s) * x[a, 1] + s * x[b, 1] - (1 - t) * x[c, 1] - t * x[d, 1]
    rz = (1 - s) * x[a, 2] + s * x[b, 2] - (1 - t) * x[c, 2] - t * x[d, 2]
    return rx, ry, rz


@njit(cache=True, error_model="numpy")
def _edges_passed(x, before, a, b, c, d):  # type: ignore[no-untyped-def]
    px, py, pz = _apart(before, a, b, c, d)
    qx, qy, qz = _apart(x, a, b, c, d)
    return px * qx + py * qy + pz * qz <= 0.0


@njit(cache=True, error_model="numpy")
def _vertex_passed(x, v, a, b, c, side):  # type: ignore[no-untyped-def]
    """Whether v is over the inside of triangle (a, b, c), but not on that side of it."""
    nx, ny, nz = normal_of(x, a, b, c)
    px, py, pz = x[v, 0] - x[a, 0], x[v, 1] - x[a, 1], x[v, 2] - x[a, 2]
    if side * (nx * px + ny * py + nz * pz) > 0.0:
        return False
    least = INSIDE * (nx * nx + ny * ny + nz * nz)
    for p, q in ((a, b), (b, c), (c, a)):
        ex, ey, ez = x[q, 0] - x[p, 0], x[q, 1] - x[p, 1], x[q, 2] - x[p, 2]
        rx, ry, rz = x[v, 0] - x[p, 0], x[v, 1] - x[p, 1], x[v, 2] - x[p, 2]
        if nx * (ey * rz - ez * ry) + ny * (ez * rx - ex * rz) + nz * (ex * ry - ey * rx) < least:
            return False
    return True


@njit(cache=True, error_model="numpy")
def _mark(x, before, mesh, lists, zone):  # type: ignore[no-untyped-def]
    """Join the vertices of pairs that have passed through each other; whether any zone grew."""
    grew, restless, now = False, lists.restless, lists.number[0]
    for p in range(lists.used[0]):
        if lists.pair_wake[p] > lists.travelled[0]:
            continue
        a, b, c, d = lists.pairs[p, 0], lists.pairs[p, 1], lists.pairs[p, 2], lists.pairs[p, 3]
        if restless[a] < now and restless[b] < now and restless[c] < now and restless[d] < now:
            continue
        held_on_both = min(mesh.inverse_mass[a], mesh.inverse_mass[b]) == 0.0
        held_on_both &= min(mesh.inverse_mass[c], mesh.inverse_mass[d]) == 0.0
        if not held_on_both and _edges_passed(x, before, a, b, c, d) and not _together(zone, a, b, c, d):
            _join(zone, a, b)
            _join(zone, b, c)
            _join(zone, c, d)
            grew = True
    for v in range(x.shape[0]):
        for s in range(lists.face.shape[1]):
            t = lists.face[v, s]
            if t < 0 or lists.side[v, s] == 0 or lists.wake[v, s] > lists.travelled[0]:
                continue
            a, b, c = mesh.faces[t, 0], mesh.faces[t, 1], mesh.faces[t, 2]
            if restless[v] < now and restless[a] < now and restless[b] < now and restless[c] < now:
                continue
            held_on_both = mesh.inverse_mass[v] == 0.0
            held_on_both &= min(mesh.inverse_mass[a], mesh.inverse_mass[b], mesh.inverse_mass[c]) == 0.0
            if held_on_both:
                continue
            if _vertex_passed(x, v, a, b, c, lists.side[v, s]) and not _together(zone, v, a, b, c):
                _join(zone, v, a)
                _join(zone, a, b)
                _join(zone, b, c)
                grew = True
    return grew


@njit(cache=True, error_model="numpy")
def _move(x, before, inverse_mass, zone):  # type: ignore[no-untyped-def]
    """Move every zone from where it was by its mean motion, or by that of its held vertices."""
    n = x.shape[0]
    mean, weight, held = np.zeros((n, 3)), np.zeros(n), np.zeros(n, dtype=np.bool_)
    for v in range(n):
        if zone[v] >= 0 and inverse_mass[v] == 0.0:
            held[_root(zone, v)] = True
    for v in range(n):
        if zone[v] < 0:
            continue
        root = _root(zone, v)
        if held[root] and inverse_mass[v] > 0.0:
            continue
        mass = 1.0 if held[root] else 1.0 / inverse_mass[v]
        weight[root] += mass
        for k in range(3):
            mean[root, k] += mass * (x[v, k] - before[v, k])
    for v in range(n):
        if zone[v] >= 0:
            root = _root(zone, v)
            for k in range(3):
                x[v, k] = before[v, k] + mean[root, k] / weight[root]


@njit(cache=True, error_model="numpy")
def hold(x, before, mesh, lists):  # type: ignore[no-untyped-def]
    """Undo what passed through something else; x and before [m], shape (n, 3), before being legal.

    Only what contact has pushed hard, or is in a zone, can have.

    Returns:
        Number of passes that it took; 0 when nothing had passed.
    """
    zone = np.full(x.shape[0], -1)
    for passes in range(MOST_PASSES):
        if not _mark(x, before, mesh, lists, zone):
            return passes
        _move(x, before, mesh.inverse_mass, zone)
        for v in range(zone.shape[0]):
            if zone[v] >= 0:
                lists.restless[v] = lists.number[0] + RESTLESS_FOR
    return MOST_PASSES
