"""The motion of the cloth since the last search, which determines how long distant pairs sleep (are not tested).

A pair is a vertex and a triangle, or two edges. It needs no test until its two elements may be too near to each other.
They cannot approach each other by more than the lengths of the paths of their own vertices. A fast vertex therefore
wakes only its own pairs.

The path of a vertex leads through the positions that contact left at the end of each round of corrections. These
positions are called legal, because every vertex is on the correct side of all layers. The predicted motion of a round
is added for this round only. If it were added permanently, the paths of layers that a hand presses would become long,
although the layers do not travel. In every round, their predicted positions lie within one another, and contact sets
them back again.

All motion is measured relative to the mean motion, so a cloth that is carried as a whole wakes no pairs.
"""

from __future__ import annotations

import numpy as np

from tatamu.simulation.native.compiled import kernel
from tatamu.simulation.native.contact.projection import Positions
from tatamu.simulation.native.contact.state import ContactState
from tatamu.simulation.native.geometry import Vector, copy

EVERY = 16
"""Spacing of the vertices from which the mean motion of the cloth is computed.

Only vertices whose number is a multiple of this value are used. All vertices need not be used, because motion relative
to any reference motion gives a valid bound on the approach."""


@kernel
def of_edges(length: np.ndarray, a: int, b: int, c: int, d: int) -> float:
    """Return the largest distance by which edges (a, b) and (c, d) can have approached each other [m].

    `length` contains the path lengths of all vertices [m].
    """
    return max(length[a], length[b]) + max(length[c], length[d])


@kernel
def of_vertex_and_face(length: np.ndarray, v: int, a: int, b: int, c: int) -> float:
    """Return the largest distance by which vertex v and triangle (a, b, c) can have approached each other [m].

    `length` contains the path lengths of all vertices [m]. The bound is not exact if the vertex slides onto a
    neighbouring triangle, because the path of one corner of this triangle is not counted. The error is small, because
    both triangles share two corners.
    """
    return length[v] + max(length[a], length[b], length[c])


@kernel
def begin(x: np.ndarray, contact: ContactState) -> None:
    """Set all paths to zero, and start to add up the motion from the positions x of the n vertices [m], shape (n, 3).

    In these positions every vertex is on the correct side of all layers.
    """
    motion = contact.motion
    for v in range(x.shape[0]):
        motion.path[v] = 0.0
    copy(x, motion.legal)
    copy(x, motion.searched_at)
    contact.counters.longest_path = 0.0
    contact.counters.due = 0.0


@kernel
def follow(positions: Positions, contact: ContactState) -> None:
    """Add the motion since the start of the last round of contact to the vertices' paths, then update their reach.

    The reach of a vertex is its path plus its motion within the round. If the search found no pairs, no pair can wake,
    so paths are not needed. In this case `worn_out` compares positions in every round.
    """
    counters = contact.counters
    if counters.ordered == 0 and counters.pairs == 0:
        counters.travelled = np.inf
        return
    start = positions.start
    path = contact.motion.path
    legal = contact.motion.legal
    mean = _mean_motion(legal, start)
    longest = 0.0
    for v in range(path.shape[0]):
        step = _distance(legal, start, v, mean)
        path[v] += step
        longest = max(longest, step)
    copy(start, legal)
    counters.longest_path += 2.0 * longest
    reach(positions, contact)


@kernel
def reach(positions: Positions, contact: ContactState) -> None:
    """Update the reach of each vertex: its path plus its distance from its position at the start of the round.

    The distance is measured to the present position, which is the predicted or the corrected position.
    """
    x = positions.x
    start = positions.start
    path = contact.motion.path
    reached = contact.motion.reach
    mean = _mean_motion(start, x)
    farthest = 0.0
    for v in range(path.shape[0]):
        beyond = _distance(start, x, v, mean)
        reached[v] = path[v] + beyond
        farthest = max(farthest, beyond)
    contact.counters.travelled = contact.counters.longest_path + 2.0 * farthest


@kernel
def _mean_motion(start: np.ndarray, end: np.ndarray) -> Vector:
    """Return the mean motion of a sample of the vertices between two sets of positions [m]."""
    x, y, z = 0.0, 0.0, 0.0
    n = 0
    for v in range(0, start.shape[0], EVERY):
        x += end[v, 0] - start[v, 0]
        y += end[v, 1] - start[v, 1]
        z += end[v, 2] - start[v, 2]
        n += 1
    return x / n, y / n, z / n


@kernel
def _distance(start: np.ndarray, end: np.ndarray, v: int, mean: Vector) -> float:
    """Return the length of the motion of vertex v relative to the mean motion [m]."""
    x = end[v, 0] - start[v, 0] - mean[0]
    y = end[v, 1] - start[v, 1] - mean[1]
    z = end[v, 2] - start[v, 2] - mean[2]
    return np.sqrt(x * x + y * y + z * z)


@kernel
def worn_out(x: np.ndarray, contact: ContactState, limit: float) -> bool:
    """Return whether two vertices may have come closer by more than a limit [m] since the search for candidates.

    Positions are compared with the positions at the search, so oscillations do not make candidates stale. Oscillations
    do add to paths, which wake sleeping pairs.
    """
    counters = contact.counters
    if counters.travelled <= counters.due:
        return False
    away = _relative_motion(x, contact.motion.searched_at)
    counters.due = limit - away + 2.0 * counters.longest_path - counters.travelled
    return away >= limit


@kernel
def _relative_motion(x: np.ndarray, start: np.ndarray) -> float:
    """Return a bound on the relative motion of any two vertices [m].

    The bound is the diagonal of the box around all displacements.
    """
    low_x, low_y, low_z = np.inf, np.inf, np.inf
    high_x, high_y, high_z = -np.inf, -np.inf, -np.inf
    for v in range(x.shape[0]):
        dx = x[v, 0] - start[v, 0]
        dy = x[v, 1] - start[v, 1]
        dz = x[v, 2] - start[v, 2]
        low_x = min(low_x, dx)
        low_y = min(low_y, dy)
        low_z = min(low_z, dz)
        high_x = max(high_x, dx)
        high_y = max(high_y, dy)
        high_z = max(high_z, dz)
    return np.sqrt((high_x - low_x) ** 2 + (high_y - low_y) ** 2 + (high_z - low_z) ** 2)
