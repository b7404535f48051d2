"""Narrow phase and correction of edges against edges, without friction.

The module `edge_edge_search` finds pairs of edges. This module keeps the edges of each pair apart. They are pushed
along the line that joined their closest points at the start of the step.

Most pairs are near but not too near. Distances are therefore computed for many pairs at a time. From the first pair
that is too near, pairs are treated one by one, because the correction of a pair may bring other pairs too near. The
result equals the result of a Gauss-Seidel sweep over single pairs.
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
"""Index of the first gap in the array that `_measure` fills. Other measures of the pairs come before the gaps."""
SLEEP = 0.9
"""Fraction that determines how long a distant pair of edges sleeps, that is, is not tested [-].

The excess of a pair is its distance minus the distance that contact keeps between edges. The pair is tested again when
its edges may have approached each other by this fraction of the excess."""
FARTHEST = 3.0
"""Largest distance of a pair of edges that the first sweep corrects, as a multiple of the gap that edges keep [-].

The distance is measured at the start of the step. A later sweep also corrects a pair with a larger distance if the
sweep before it moved one of the pair's vertices."""
TOUCHING = 1e-9
"""Smallest distance of two edges at which contact can push them apart [m].

The distance is measured at the start of the step. A closer pair is not corrected, because it has no direction for a
push."""


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
    """Write four rows of measures of n pairs of edges to `out`.

    The first row contains the distances at the start of the step. The next two rows contain the positions of the
    closest points, as fractions of the first and of the second edge. The last row contains the present gaps. The array
    m has twelve rows with the vertex coordinates at the start of the step, and twelve rows with the present
    coordinates.
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
    """Fill `chosen` with the numbers of the next pairs of edges that may be too near to each other, from pair p on.

    Returns:
        The number of pairs in `chosen`, and the number of the pair where the next call continues.
    """
    pairs = contact.edge_edge.pairs
    wake = contact.edge_edge.wake
    meets = contact.edge_edge.meets
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
        p += 1
    return n, p


@kernel
def _choose_again(contact: ContactState, i: int, chosen: np.ndarray) -> tuple[int, int]:
    """Fill `chosen` with the next awake pairs that the last sweep moved, beginning with the i-th awake pair.

    Awake pairs are the pairs that the first sweep did not put to sleep. The function returns the number of pairs in
    `chosen`, and the place in the list of awake pairs where the next call continues.
    """
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
    """Let pairs of edges whose distance exceeds `kept` [m] sleep, and list all other pairs as awake."""
    pairs = contact.edge_edge.pairs
    wake = contact.edge_edge.wake
    meets = contact.edge_edge.meets
    awake = contact.edge_edge.awake
    path = contact.motion.path
    reach = contact.motion.reach
    counters = contact.counters
    count = counters.pairs_awake
    for i in range(n):
        p = chosen[i]
        if distance[i] > kept:
            a, b, c, d = pairs[p, 0], pairs[p, 1], pairs[p, 2], pairs[p, 3]
            far = SLEEP * (distance[i] - kept)
            wake[p] = counters.longest_path + far
            meets[p] = of_edges(path, a, b, c, d) + far
            if meets[p] > of_edges(reach, a, b, c, d):
                continue
        awake[count] = p
        count += 1
    counters.pairs_awake = count


@kernel
def _first_too_near(gap: np.ndarray, n: int, wanted: float) -> int:
    """Return the index of the first of n gaps that is smaller than `wanted`; n if all gaps are large enough."""
    for i in range(n):
        if gap[i] < wanted:
            return i
    return n


@kernel
def _combined(x: np.ndarray, pair: tuple[int, int, int, int], weights: tuple[float, float, float, float]) -> Vector:
    """Return the vector between the closest points of two edges [m], from the barycentric weights of these points."""
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
    """Push one pair apart along the line of its closest points at the start of the step.

    Args:
        positions: Positions to correct.
        inverse_mass: Inverse masses of the vertices [1/kg].
        activity: Record of noticeable and hard pushes, which is updated.
        pair: Ends of both edges.
        closest: Distance of the edges at the start [m], and the fractions along both edges where their closest points
            are.
        wanted: Distance that the edges should have [m].
        speeds: Largest increase of the pair's distance, and the largest increase that becomes velocity [m]. See
            `projection.correction`, which has them as `clearing` and `recovery`.
        thresholds: Two lengths of a push [m]. After a longer push than the first, vertices count as touched. After a
            longer push than the second, they are restless: they are tested for passing through cloth.
        numbers: Number of this sweep, and number of the last outer step in which pushed vertices are restless.

    Returns:
        The gap before the push [m]; infinity if the gap was large enough.
    """
    distance, s, t = closest
    weights = (1.0 - s, s, -(1.0 - t), -t)
    wa, wb, wc, wd = weights
    sx, sy, sz = _combined(positions.start, pair, weights)
    nx = sx / distance
    ny = sy / distance
    nz = sz / distance
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
    """Make one Gauss-Seidel sweep over the edge pairs, in the order of their numbers.

    Args:
        positions: Positions to correct, and the positions at the start of the step.
        mesh: The mesh.
        contact: State of contact. Distant pairs are put to sleep, and activity is updated.
        options: Limits of the corrections.
        step: Time since the start of the step [s].
        restored: Fraction of the gap that this sweep restores [-].

    Returns:
        Smallest gap before its correction [m]. It is at most the gap that edges keep.
    """
    inverse_mass = mesh.inverse_mass
    pairs = contact.edge_edge.pairs
    counters = contact.counters
    first_sweep = restored == 1.0
    kept = options.edge_gap * mesh.thickness
    wanted = restored * kept
    smallest = kept
    farthest = FARTHEST * kept if first_sweep else np.inf
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
            if near[i] < TOUCHING or near[i] > farthest:
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
