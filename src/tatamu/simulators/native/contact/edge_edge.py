"""Edges against edges: guarded edges (`ridges`) and those near them are kept apart, as vertices are from triangles.

Most pairs are near but not too near. How near they are is therefore computed for many pairs at a time, eight at once,
and they are looked at one by one only from the first on that is too near, as its push may bring others too near.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from tatamu.simulators.native.contact.projection import HARD, NOTICEABLE, RESTLESS_FOR, pushes, shift
from tatamu.simulators.native.geometry import closest_between

EDGE_GAP = 0.75
"""Edges keep this part of a thickness; vertices against triangles keep the whole."""
MANY = 32
"""Pairs that are measured together."""
S, T, GAP = MANY, 2 * MANY, 3 * MANY
"""Where rows of measures begin, after that of distances."""


@njit(cache=True, error_model="numpy")
def _gather(x, pairs, chosen, n, first, out):  # type: ignore[no-untyped-def]
    """The coordinates of the chosen pairs in rows of `out`."""
    for i in range(n):
        for q in range(4):
            v = pairs[chosen[i], q]
            for k in range(3):
                out[(first + 3 * q + k) * MANY + i] = x[v, k]


@njit(cache=True, error_model="numpy")
def _measure(n, m, out):  # type: ignore[no-untyped-def]
    """Distances before the step, where along both edges, and what is left of them at x: four rows of `out`.

    In m are twelve rows of coordinates before the step, and twelve at x.
    """
    for i in range(n):
        ax, ay, az, bx, by, bz = m[i], m[i + MANY], m[i + 2 * MANY], m[i + 3 * MANY], m[i + 4 * MANY], m[i + 5 * MANY]
        cx, cy, cz = m[i + 6 * MANY], m[i + 7 * MANY], m[i + 8 * MANY]
        dx, dy, dz = m[i + 9 * MANY], m[i + 10 * MANY], m[i + 11 * MANY]
        distance, s, t = closest_between(
            bx - ax, by - ay, bz - az, dx - cx, dy - cy, dz - cz, ax - cx, ay - cy, az - cz
        )
        wa, wb, wc, wd = 1.0 - s, s, -(1.0 - t), -t
        nx = (wa * ax + wb * bx + wc * cx + wd * dx) / distance
        ny = (wa * ay + wb * by + wc * cy + wd * dy) / distance
        nz = (wa * az + wb * bz + wc * cz + wd * dz) / distance
        x = wa * m[i + 12 * MANY] + wb * m[i + 15 * MANY] + wc * m[i + 18 * MANY] + wd * m[i + 21 * MANY]
        y = wa * m[i + 13 * MANY] + wb * m[i + 16 * MANY] + wc * m[i + 19 * MANY] + wd * m[i + 22 * MANY]
        z = wa * m[i + 14 * MANY] + wb * m[i + 17 * MANY] + wc * m[i + 20 * MANY] + wd * m[i + 23 * MANY]
        out[i], out[i + S], out[i + T], out[i + GAP] = distance, s, t, nx * x + ny * y + nz * z


@njit(cache=True, error_model="numpy")
def _choose(lists, p, keep, chosen):  # type: ignore[no-untyped-def]
    """The next pairs from number p on that may be too near; how many they are, and where to go on."""
    touched, last, n = lists.touched, lists.sweeps[0] - 1, 0
    while p < lists.used[0] and n < MANY:
        if lists.pair_wake[p] <= lists.travelled[0]:
            a, b, c, d = lists.pairs[p, 0], lists.pairs[p, 1], lists.pairs[p, 2], lists.pairs[p, 3]
            if keep == 1.0 or max(touched[a], touched[b], touched[c], touched[d]) >= last:
                chosen[n] = p
                n += 1
        p += 1
    return n, p


@njit(cache=True, error_model="numpy")
def _let_sleep(wake, travelled, chosen, distance, n, thickness):  # type: ignore[no-untyped-def]
    """Pairs that are far enough apart need not be looked at before they can have come too near."""
    for i in range(n):
        p = chosen[i]
        wake[p] = travelled + 0.9 * (distance[i] - thickness) if distance[i] > thickness else wake[p]


@njit(cache=True, error_model="numpy")
def _first_too_near(gap, n, wanted):  # type: ignore[no-untyped-def]
    """The first of n gaps that is too small, n if none is."""
    for i in range(n):
        if gap[i] < wanted:
            return i
    return n


@njit(cache=True, error_model="numpy")
def _push(x, before, moved, pair, inverse_mass, lists, thickness, distance, s, t, wanted, step):  # type: ignore[no-untyped-def]
    """Push one pair apart along its closest points before the step; the gap it had, or infinity if it was enough."""
    a, b, c, d = pair
    wa, wb, wc, wd = 1.0 - s, s, -(1.0 - t), -t
    nx = (wa * before[a, 0] + wb * before[b, 0] + wc * before[c, 0] + wd * before[d, 0]) / distance
    ny = (wa * before[a, 1] + wb * before[b, 1] + wc * before[c, 1] + wd * before[d, 1]) / distance
    nz = (wa * before[a, 2] + wb * before[b, 2] + wc * before[c, 2] + wd * before[d, 2]) / distance
    gap = (
        nx * (wa * x[a, 0] + wb * x[b, 0] + wc * x[c, 0] + wd * x[d, 0])
        + ny * (wa * x[a, 1] + wb * x[b, 1] + wc * x[c, 1] + wd * x[d, 1])
        + nz * (wa * x[a, 2] + wb * x[b, 2] + wc * x[c, 2] + wd * x[d, 2])
    )
    push, silent = pushes(gap, distance, wanted, step)
    if gap >= wanted or push <= 0.0:
        return np.inf
    weight = (
        wa * wa * inverse_mass[a] + wb * wb * inverse_mass[b] + wc * wc * inverse_mass[c] + wd * wd * inverse_mass[d]
    )
    for o, w in ((a, wa), (b, wb), (c, wc), (d, wd)):
        if push > NOTICEABLE * EDGE_GAP * thickness:
            lists.touched[o] = lists.sweeps[0]
        if push > HARD * thickness:
            lists.restless[o] = lists.number[0] + RESTLESS_FOR
        f = w * inverse_mass[o] / weight
        shift(x, o, f * push, nx, ny, nz)
        if silent > 0.0:
            shift(moved, o, f * silent, nx, ny, nz)
    return gap


@njit(cache=True, error_model="numpy")
def sweep(x, before, moved, mesh, lists, step, keep):  # type: ignore[no-untyped-def]
    """One pass over the edge pairs; the smallest gap seen before. See `contact.sweep`."""
    inverse_mass, thickness = mesh.inverse_mass, EDGE_GAP * mesh.reach[0]
    wanted, smallest = keep * thickness, thickness
    farthest = 3.0 * thickness if keep == 1.0 else np.inf
    chosen, m, near = np.empty(MANY, np.int64), np.empty(24 * MANY), np.empty(4 * MANY)
    p = 0
    while p < lists.used[0]:
        n, p = _choose(lists, p, keep, chosen)
        _gather(before, lists.pairs, chosen, n, 0, m)
        _gather(x, lists.pairs, chosen, n, 12, m)
        _measure(n, m, near)
        if keep == 1.0:
            _let_sleep(lists.pair_wake, lists.travelled[0], chosen, near, n, thickness)
        for i in range(_first_too_near(near[GAP:], n, wanted), n):
            if near[i] < 1e-9 or near[i] > farthest:
                continue
            q = chosen[i]
            a, b, c, d = lists.pairs[q, 0], lists.pairs[q, 1], lists.pairs[q, 2], lists.pairs[q, 3]
            if min(inverse_mass[a], inverse_mass[b]) == 0.0 and min(inverse_mass[c], inverse_mass[d]) == 0.0:
                continue  # where both edges are held, the hand decides how far they are apart
            pair, reached = (a, b, c, d), (near[i], near[i + S], near[i + T])
            gap = _push(x, before, moved, pair, inverse_mass, lists, mesh.reach[0], *reached, wanted, step)
            smallest = min(smallest, gap)
    return smallest
