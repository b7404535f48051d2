"""Narrow phase and correction of edges against edges, without friction.

The pairs from `edge_edge_search` are pushed along the line of their closest points at the start of the step. Most pairs
are not too close, so distances are computed for many at a time. From the first that is too close, pairs are treated one
by one, because a correction may bring others too close. The result equals that of a sweep over single pairs.
"""

from __future__ import annotations

import numpy as np

from tatamu.simulation.native.compiled import allocating, kernel
from tatamu.simulation.native.contact.motion import of_edges
from tatamu.simulation.native.contact.projection import Positions, correction, move
from tatamu.simulation.native.contact.state import Activity, ContactMesh, ContactState
from tatamu.simulation.native.geometry import Vector, closest_between
from tatamu.simulation.native.options import ContactOptions

MANY = 32
"""Number of pairs that are measured together."""
FIRST_FRACTION = MANY
SECOND_FRACTION = 2 * MANY
GAP = 3 * MANY
"""Index of the first gap in the array that `_measure` fills."""


@kernel
def _gather(x: np.ndarray, pairs: np.ndarray, chosen: np.ndarray, n: int, first: int, out: np.ndarray) -> None:
    """Write the vertex coordinates of n chosen pairs of edges to the rows of `out`, beginning with row `first`."""
    for i in range(n):
        for q in range(4):
            v = pairs[chosen[i], q]
            for k in range(3):
                out[(first + 3 * q + k) * MANY + i] = x[v, k]


@kernel
def _measure(n: int, m: np.ndarray, out: np.ndarray) -> None:
    """Write four rows of n pairs to `out`: distance at the start, fractions along both edges, and present gap.

    m has twelve rows with the vertex coordinates at the start of the step, and twelve with the present ones.
    """
    for i in range(n):
        ax, ay, az = m[i], m[i + MANY], m[i + 2 * MANY]
        bx, by, bz = m[i + 3 * MANY], m[i + 4 * MANY], m[i + 5 * MANY]
        cx, cy, cz = m[i + 6 * MANY], m[i + 7 * MANY], m[i + 8 * MANY]
        dx, dy, dz = m[i + 9 * MANY], m[i + 10 * MANY], m[i + 11 * MANY]
        distance, s, t = closest_between(
            bx - ax, by - ay, bz - az, dx - cx, dy - cy, dz - cz, ax - cx, ay - cy, az - cz
        )
        wa = 1.0 - s
        wb = s
        wc = -(1.0 - t)
        wd = -t
        nx = (wa * ax + wb * bx + wc * cx + wd * dx) / distance
        ny = (wa * ay + wb * by + wc * cy + wd * dy) / distance
        nz = (wa * az + wb * bz + wc * cz + wd * dz) / distance
        x = wa * m[i + 12 * MANY] + wb * m[i + 15 * MANY] + wc * m[i + 18 * MANY] + wd * m[i + 21 * MANY]
        y = wa * m[i + 13 * MANY] + wb * m[i + 16 * MANY] + wc * m[i + 19 * MANY] + wd * m[i + 22 * MANY]
        z = wa * m[i + 14 * MANY] + wb * m[i + 17 * MANY] + wc * m[i + 20 * MANY] + wd * m[i + 23 * MANY]
        out[i] = distance
        out[i + FIRST_FRACTION] = s
        out[i + SECOND_FRACTION] = t
        out[i + GAP] = nx * x + ny * y + nz * z


@kernel
def _choose(contact: ContactState, p: int, chosen: np.ndarray) -> tuple[int, int]:
    """Collect, from pair p on, the pairs that may be too close; return their count and where to continue."""
    pairs = contact.edge_edge.pairs
    wake = contact.edge_edge.wake
    meets = contact.edge_edge.meets
    apart = contact.edge_edge.apart
    path = contact.motion.path
    reach = contact.motion.reach
    count = contact.counters.pairs
    longest_path = contact.counters.longest_path
    travelled = contact.counters.travelled
    n = 0
    while p < count and n < MANY:
        if wake[p] <= travelled:
            a, b, c, d = pairs[p, 0], pairs[p, 1], pairs[p, 2], pairs[p, 3]
            if meets[p] <= of_edges(reach, a, b, c, d):
                chosen[n] = p
                n += 1
            else:
                wake[p] = longest_path + meets[p] - of_edges(path, a, b, c, d)
                apart[p] = 0.0
        p += 1
    return n, p


@kernel
def _choose_again(contact: ContactState, i: int, chosen: np.ndarray) -> tuple[int, int]:
    """Collect, from the i-th awake pair on, pairs that the last sweep moved; return count and where to continue."""
    pairs = contact.edge_edge.pairs
    awake = contact.edge_edge.awake
    touched = contact.activity.touched
    count = contact.counters.pairs_awake
    last_sweep = contact.counters.sweep - 1
    n = 0
    while i < count and n < MANY:
        p = awake[i]
        a, b, c, d = pairs[p, 0], pairs[p, 1], pairs[p, 2], pairs[p, 3]
        if max(touched[a], touched[b], touched[c], touched[d]) >= last_sweep:
            chosen[n] = p
            n += 1
        i += 1
    return n, i


@kernel
def _let_sleep(contact: ContactState, chosen: np.ndarray, distance: np.ndarray, n: int, kept: float) -> None:
    """Let pairs sleep whose distance exceeds `kept` [m], and list all other pairs as awake."""
    pairs = contact.edge_edge.pairs
    wake = contact.edge_edge.wake
    meets = contact.edge_edge.meets
    apart = contact.edge_edge.apart
    awake = contact.edge_edge.awake
    path = contact.motion.path
    reach = contact.motion.reach
    counters = contact.counters
    count = counters.pairs_awake
    for i in range(n):
        p = chosen[i]
        if distance[i] > kept:
            a, b, c, d = pairs[p, 0], pairs[p, 1], pairs[p, 2], pairs[p, 3]
            far = 0.9 * (distance[i] - kept)  # by which the pair may approach before it is tested again
            wake[p] = counters.longest_path + far
            meets[p] = of_edges(path, a, b, c, d) + far
            if meets[p] > of_edges(reach, a, b, c, d):
                apart[p] = 0.0
                continue
        apart[p] = distance[i]
        awake[count] = p
        count += 1
    counters.pairs_awake = count


@kernel
def _first_too_near(gap: np.ndarray, n: int, wanted: float) -> int:
    """Return the index of the first of n gaps below `wanted`; n if there is none."""
    for i in range(n):
        if gap[i] < wanted:
            return i
    return n


@kernel
def _combined(x: np.ndarray, pair: tuple[int, int, int, int], weights: tuple[float, float, float, float]) -> Vector:
    """Return the vector between the closest points of two edges [m], from the barycentric weights of the points."""
    a, b, c, d = pair
    wa, wb, wc, wd = weights
    return (
        wa * x[a, 0] + wb * x[b, 0] + wc * x[c, 0] + wd * x[d, 0],
        wa * x[a, 1] + wb * x[b, 1] + wc * x[c, 1] + wd * x[d, 1],
        wa * x[a, 2] + wb * x[b, 2] + wc * x[c, 2] + wd * x[d, 2],
    )


@kernel
def _push_apart(
    positions: Positions,
    inverse_mass: np.ndarray,
    activity: Activity,
    pair: tuple[int, int, int, int],
    closest: Vector,
    wanted: float,
    speeds: tuple[float, float],
    thresholds: tuple[float, float],
    numbers: tuple[int, int],
) -> float:
    """Push one pair apart, and return its gap before the push [m], or infinity if the gap was large enough.

    `closest` is the distance at the start [m] with the fractions along both edges, and `speeds` are `clearing` and
    `recovery` of `projection.correction` [m]. After a push above the first of `thresholds` [m], vertices are touched in
    the sweep `numbers[0]`; above the second, they are restless until the outer step `numbers[1]`.
    """
    distance, s, t = closest
    weights = (1.0 - s, s, -(1.0 - t), -t)
    wa, wb, wc, wd = weights
    sx, sy, sz = _combined(positions.start, pair, weights)
    nx, ny, nz = sx / distance, sy / distance, sz / distance
    gx, gy, gz = _combined(positions.x, pair, weights)
    gap = nx * gx + ny * gy + nz * gz
    push, position_only = correction(gap, distance, wanted, speeds[0], speeds[1])
    if gap >= wanted or push <= 0.0:
        return np.inf
    a, b, c, d = pair
    weight = (
        wa * wa * inverse_mass[a] + wb * wb * inverse_mass[b] + wc * wc * inverse_mass[c] + wd * wd * inverse_mass[d]
    )
    for o, w in ((a, wa), (b, wb), (c, wc), (d, wd)):
        if push > thresholds[0]:
            activity.touched[o] = numbers[0]
        if push > thresholds[1]:
            activity.restless[o] = numbers[1]
        f = w * inverse_mass[o] / weight
        move(positions.x, o, f * push, nx, ny, nz)
        if position_only > 0.0:
            move(positions.predicted, o, f * position_only, nx, ny, nz)
    return gap


@allocating
def sweep(
    positions: Positions,
    mesh: ContactMesh,
    contact: ContactState,
    options: ContactOptions,
    step: float,
    restored: float,
) -> float:
    """Make one Gauss-Seidel sweep over the edge pairs, and return the minimum gap [m].

    The gap is measured before its correction, and is at most the gap that edges keep.
    """
    inverse_mass = mesh.inverse_mass
    pairs = contact.edge_edge.pairs
    counters = contact.counters
    first_sweep = restored == 1.0
    kept = options.edge_gap * mesh.thickness
    wanted = restored * kept
    smallest = kept
    farthest = 3.0 * kept if first_sweep else np.inf  # later sweeps also correct pairs that the sweep before moved
    speeds = (options.clearing_speed * step, options.recovery_speed * step)
    thresholds = (options.noticeable * options.edge_gap * mesh.thickness, options.hard * mesh.thickness)
    numbers = (counters.sweep, counters.outer_step + options.restless_steps)
    chosen = np.empty(MANY, np.int64)
    coordinates = np.empty(24 * MANY)
    near = np.empty(4 * MANY)
    if first_sweep:
        counters.pairs_awake = 0
    count = counters.pairs if first_sweep else counters.pairs_awake
    p = 0
    while p < count:
        if first_sweep:
            n, p = _choose(contact, p, chosen)
        else:
            n, p = _choose_again(contact, p, chosen)
        _gather(positions.start, pairs, chosen, n, 0, coordinates)
        _gather(positions.x, pairs, chosen, n, 12, coordinates)
        _measure(n, coordinates, near)
        if first_sweep:
            _let_sleep(contact, chosen, near, n, kept)
        for i in range(_first_too_near(near[GAP:], n, wanted), n):
            if near[i] < 1e-9 or near[i] > farthest:  # a pair that touches has no direction
                continue
            q = chosen[i]
            a, b, c, d = pairs[q, 0], pairs[q, 1], pairs[q, 2], pairs[q, 3]
            if min(inverse_mass[a], inverse_mass[b]) == 0.0 and min(inverse_mass[c], inverse_mass[d]) == 0.0:
                continue  # if hands hold both edges, they determine the distance
            closest = near[i], near[i + FIRST_FRACTION], near[i + SECOND_FRACTION]
            gap = _push_apart(
                positions, inverse_mass, contact.activity, (a, b, c, d), closest, wanted, speeds, thresholds, numbers
            )
            smallest = min(smallest, gap)
    return smallest
