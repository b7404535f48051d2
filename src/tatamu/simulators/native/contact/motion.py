"""The motion of the cloth since the search, which determines how long distant pairs sleep.

A pair need not be tested before it can have come too near. The approach of its two sides is bounded by the lengths of
their own paths, so a fast vertex wakes only its own pairs. Paths lead through legal positions, where contact left the
cloth; the predicted motion of a round is added for that round only: layers that a hand presses are predicted within one
another in every round and put back, and go nowhere.

All of it is motion against the mean: a cloth that is carried as a whole wakes nothing.
"""

from __future__ import annotations

import numpy as np

from tatamu.simulators.native.compiled import kernel
from tatamu.simulators.native.contact.projection import Positions
from tatamu.simulators.native.contact.state import ContactState
from tatamu.simulators.native.geometry import Vector

EVERY = 16
"""Step between the vertices over which the mean is taken; the bound holds for any reference vector."""


@kernel
def of_edges(length: np.ndarray, a: int, b: int, c: int, d: int) -> float:
    """Return the largest approach of edges (a, b) and (c, d) for path lengths of their vertices [m]."""
    return max(length[a], length[b]) + max(length[c], length[d])


@kernel
def of_vertex_and_face(length: np.ndarray, v: int, a: int, b: int, c: int) -> float:
    """Return the largest approach of vertex v and triangle (a, b, c) for path lengths of their vertices [m].

    A vertex that slides onto a neighbouring triangle meanwhile is not covered to the letter; it gets no farther there
    than it has slid, where that triangle is still about where the two corners that it shares are.
    """
    return length[v] + max(length[a], length[b], length[c])


@kernel
def begin(x: np.ndarray, contact: ContactState) -> None:
    """Begin to count, at legal positions x [m], shape (n, 3)."""
    motion = contact.motion
    motion.path[:] = 0.0
    motion.legal[:] = x
    motion.searched_at[:] = x
    contact.counters.longest_path = 0.0
    contact.counters.due = 0.0


@kernel
def follow(positions: Positions, contact: ContactState) -> None:
    """Add the motion to the legal positions at the start of this round to the paths, then update the reach.

    If the search found no pairs, nothing can wake, and only `worn_out` uses the motion.
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
    legal[:] = start
    counters.longest_path += 2.0 * longest
    reach(positions, contact)


@kernel
def reach(positions: Positions, contact: ContactState) -> None:
    """Reach from the legal positions at the start of this round to the present ones, predicted or corrected."""
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
    """Mean motion of some of the vertices between two sets of positions [m]."""
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
    """Return the motion of vertex v relative to the mean [m]."""
    x = end[v, 0] - start[v, 0] - mean[0]
    y = end[v, 1] - start[v, 1] - mean[1]
    z = end[v, 2] - start[v, 2] - mean[2]
    return np.sqrt(x * x + y * y + z * z)


@kernel
def worn_out(x: np.ndarray, contact: ContactState, limit: float) -> bool:
    """Whether any two vertices may have come closer than a limit [m] since the search.

    Oscillations add to paths, which wake sleeping pairs, but they do not make the candidates stale.
    """
    counters = contact.counters
    if counters.travelled <= counters.due:
        return False
    away = _relative_motion(x, contact.motion.searched_at)
    counters.due = limit - away + 2.0 * counters.longest_path - counters.travelled
    return away >= limit


@kernel
def _relative_motion(x: np.ndarray, start: np.ndarray) -> float:
    """A bound on how far any two vertices moved against each other [m]: the diagonal of the box of displacements."""
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
