"""Least squares by Levenberg and Marquardt, with finite differences as derivatives (Marquardt 1963; More 1978).

    minimise  |r(p)|^2,   (J'J + lambda diag(J'J)) step = -J'r,   J_k = (r(p + h e_k) - r(p)) / h

p is a point of the unit cube, r the vector of residuals and J its Jacobian matrix. lambda is the damping. h is the
difference for derivatives, and e_k the unit vector along coordinate k.

The module evaluates nothing itself. A search is a generator: it yields the points that it needs, and the caller sends
the residuals at these points. A search yields several points together if they do not depend on each other. `next_point`
runs such searches on known residuals, so the set of evaluated points is the whole state of a search.
"""

from __future__ import annotations

from collections.abc import Generator, Iterable, Mapping, Set

import numpy as np

DIFFERENCE = 0.01
"""Difference h between two points for a derivative, in sides of the unit cube."""
FIRST_DAMPING = 0.01
"""Damping lambda at the start of a search."""
LESS, MORE = 0.2, 5.0
"""Factors of the damping lambda: after a step that lowered the sum of squares, and after any other step."""
MOST_DAMPING = 1e3
"""Largest damping lambda. If no step lowers the sum of squares up to this damping, the search ends."""
SHORTEST_STEP = 1e-3
"""Shortest step, in sides of the unit cube. The search ends before a step whose largest coordinate is smaller."""
LEAST_GAIN = 1e-3
"""Smallest relative decrease of the sum of squares in a step. The search ends after a step with a smaller decrease."""
DIGITS = 9
"""Number of decimals to which the coordinates of points are rounded before the points are compared."""

Residuals = np.ndarray | None
"""Vector of residuals at a point; None if the evaluation failed."""
Key = tuple[float, ...]
"""Rounded coordinates of a point, with which residuals are looked up."""


def key_of(point: np.ndarray) -> Key:
    """Return the key of a point: its rounded coordinates."""
    return tuple(np.round(point, DIGITS).tolist())


def next_point(starts: Iterable[np.ndarray], known: Mapping[Key, Residuals], pending: Set[Key]) -> np.ndarray:
    """Return the next point at which the searches need residuals.

    The searches are run one after the other. If all points that a search needs are pending, the function returns
    neighbours of the point that the search tries. The search will need these neighbours for derivatives if this point
    is better than the last. If the neighbours are pending too, the next search starts.

    Args:
        starts: Starting points of the searches in the unit cube, one for each search. There must be more than are ever
            needed.
        known: Residuals at evaluated points.
        pending: Points that are being evaluated.
    """
    for start in starts:
        search = least_squares(start)
        wanted = next(search)
        while wanted:
            missing = [point for point in wanted if key_of(point) not in known]
            if missing:
                ahead = neighbours(missing[0]) if len(wanted) == 1 else []
                for point in [*missing, *ahead]:
                    if key_of(point) not in pending and key_of(point) not in known:
                        return point
                break
            wanted = _sent(search, [known[key_of(point)] for point in wanted])
    raise ValueError("starts: must be more")


def least_squares(start: np.ndarray) -> Generator[list[np.ndarray], list[Residuals], None]:
    """Run a search from a point of the unit cube, shape (d,), until it has converged or cannot continue.

    The generator yields the points that it needs. The caller sends their residuals in the same order.
    """
    point = start
    residuals, *around = yield [point, *neighbours(point)]
    damping = FIRST_DAMPING
    while residuals is not None:
        jacobian = _jacobian(point, residuals, around)
        square = float(residuals @ residuals)
        while True:
            tried = np.clip(point + _step(jacobian, residuals, damping), 0.0, 1.0)
            if np.abs(tried - point).max() < SHORTEST_STEP:
                return
            (reached,) = yield [tried]
            if reached is not None and reached @ reached < square:
                break
            damping *= MORE
            if damping > MOST_DAMPING:
                return
        if square - float(reached @ reached) < LEAST_GAIN * square:
            return
        damping *= LESS
        point, residuals = tried, reached
        around = yield neighbours(point)


def neighbours(point: np.ndarray) -> list[np.ndarray]:
    """Return the points for finite differences at a point, one along each coordinate, all inside the unit cube."""
    steps = np.where(point + DIFFERENCE <= 1.0, DIFFERENCE, -DIFFERENCE)
    return list(point + np.diag(steps))


def _jacobian(point: np.ndarray, residuals: np.ndarray, around: list[Residuals]) -> np.ndarray:
    """Return the Jacobian matrix J, shape (n, d), from residuals at a point and its neighbours.

    J is zero along coordinates whose neighbour could not be evaluated.
    """
    columns = [
        np.zeros_like(residuals) if beside is None else (beside - residuals) / (neighbour - point)[k]
        for k, (neighbour, beside) in enumerate(zip(neighbours(point), around, strict=True))
    ]
    return np.column_stack(columns)


def _step(jacobian: np.ndarray, residuals: np.ndarray, damping: float) -> np.ndarray:
    """Return the step of the Levenberg-Marquardt method for a given damping, shape (d,)."""
    normal = jacobian.T @ jacobian
    scale = np.diag(normal) + 1e-12 * max(float(np.trace(normal)), 1e-300)
    return np.asarray(np.linalg.solve(normal + damping * np.diag(scale), -jacobian.T @ residuals))


def _sent(search: Generator[list[np.ndarray], list[Residuals], None], residuals: list[Residuals]) -> list[np.ndarray]:
    """Send residuals to a search, and return the next points that it needs.

    The list is empty if the search has ended.
    """
    try:
        return search.send(residuals)
    except StopIteration:
        return []
