"""The motion of the cloth since the last search, which determines how long distant pairs sleep (are not tested).

Two elements approach each other by at most the lengths of the paths of their own vertices, so a fast vertex wakes only
its own pairs. Paths lead through legal positions. The predicted motion of a round is added for this round only, because
the paths of layers that a hand presses would become long otherwise: their predicted positions lie within one another in
every round, and contact sets them back. All motion is relative to the mean motion, so a cloth that is carried as a
whole wakes no pairs.
"""

from __future__ import annotations

import numpy as np

from tatamu.simulation.native.compiled import kernel
from tatamu.simulation.native.contact.projection import Positions
from tatamu.simulation.native.contact.state import ContactState
from tatamu.simulation.native.geometry import Vector, copy

EVERY = 16
"""Spacing of the vertices that give the mean motion; any reference motion gives a valid bound on the approach."""


@kernel
def of_edges(length: np.ndarray, a: int, b: int, c: int, d: int) -> float:
    """Return the maximum approach of edges (a, b) and (c, d) from the path lengths of vertices [m]."""
    return max(length[a], length[b]) + max(length[c], length[d])


@kernel
def of_vertex_and_face(length: np.ndarray, v: int, a: int, b: int, c: int) -> float:
    """Return the maximum approach of vertex v and triangle (a, b, c) from the path lengths of vertices [m].

    If v slides onto a neighbouring triangle, the path of one corner is not counted; the triangles share the other two.
    """
    return length[v] + max(length[a], length[b], length[c])


@kernel
def begin(x: np.ndarray, contact: ContactState) -> None:
    """Set all paths to zero, and start to add up the motion from legal positions x [m]."""
    motion = contact.motion
    for v in range(x.shape[0]):
        motion.path[v] = 0.0
    copy(x, motion.legal)
    copy(x, motion.searched_at)
    contact.counters.longest_path = 0.0
    contact.counters.due = 0.0


@kernel
def follow(positions: Positions, contact: ContactState) -> None:
    """Add the motion since the start of the last round to the vertices' paths, then update their reach.

    If the search found no pairs, none can wake, so `worn_out` compares positions in every round instead.
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
    """Update the reach of each vertex: its path plus the distance of its present position from the round's start."""
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

    Positions are compared with those at the search, so oscillations, which add to paths, do not make candidates stale.
    """
    counters = contact.counters
    if counters.travelled <= counters.due:
        return False
    away = _relative_motion(x, contact.motion.searched_at)
    counters.due = limit - away + 2.0 * counters.longest_path - counters.travelled
    return away >= limit


@kernel
def _relative_motion(x: np.ndarray, start: np.ndarray) -> float:
    """Return a bound on the relative motion of any two vertices [m]: the diagonal of the box of all displacements."""
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
