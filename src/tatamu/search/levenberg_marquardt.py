"""Least squares by Levenberg and Marquardt, with derivatives by finite differences (Marquardt 1963; More 1978).

    minimise  |r(p)|^2,   (J'J + lambda diag(J'J)) step = -J'r,   J_k = (r(p + h e_k) - r(p)) / h

within the unit cube. The module evaluates nothing itself. A search is a generator: it yields the points that it needs,
and is sent their residuals. It yields several points at once if they do not depend on each other. `next_point` runs
such searches on known residuals, so the whole state of a search is the set of evaluated points.
"""

from __future__ import annotations

from collections.abc import Generator, Iterable, Mapping, Set

import numpy as np

DIFFERENCE = 0.01
"""h, in sides of the cube."""
FIRST_DAMPING = 0.01
"""lambda at the start of a search."""
LESS, MORE = 0.2, 5.0
"""Factors of lambda after a step that lowered the value, and after another step."""
MOST_DAMPING = 1e3
"""Largest damping; if no step with less damping lowers the value, the search ends."""
SHORTEST_STEP = 1e-3
"""Largest coordinate of a step at which the search ends, in sides of the cube."""
LEAST_GAIN = 1e-3
"""Relative decrease of the sum of squares at which the search ends."""
DIGITS = 9
"""Number of digits in which equal points agree."""

Residuals = np.ndarray | None
"""Residuals at a point, shape (n,); None if the evaluation failed."""
Key = tuple[float, ...]
"""A point by which residuals are looked up."""


def key_of(point: np.ndarray) -> Key:
    """The key of a point, shape (d,)."""
    return tuple(np.round(point, DIGITS).tolist())


def next_point(starts: Iterable[np.ndarray], known: Mapping[Key, Residuals], pending: Set[Key]) -> np.ndarray:
    """Return the next point that the searches need, shape (d,).

    The searches are run one after the other. If all points that a search needs are pending, the neighbours of its trial
    step are returned next, because the search needs them if the step succeeds. Then the next search starts.

    Args:
        starts: Starting points of the searches in the unit cube, shape (d,) each; enough for all searches.
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
    """Search from a point of the unit cube, shape (d,), until it has converged or cannot continue.

    It yields the points that it needs and is sent their residuals in the same order.
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
    """Points at which derivatives are taken: one along each coordinate, towards the inside of the cube."""
    steps = np.where(point + DIFFERENCE <= 1.0, DIFFERENCE, -DIFFERENCE)
    return list(point + np.diag(steps))


def _jacobian(point: np.ndarray, residuals: np.ndarray, around: list[Residuals]) -> np.ndarray:
    """J, shape (n, d), from residuals at a point and its neighbours; zero along coordinates whose neighbour failed."""
    columns = [
        np.zeros_like(residuals) if beside is None else (beside - residuals) / (neighbour - point)[k]
        for k, (neighbour, beside) in enumerate(zip(neighbours(point), around, strict=True))
    ]
    return np.column_stack(columns)


def _step(jacobian: np.ndarray, residuals: np.ndarray, damping: float) -> np.ndarray:
    """The damped Gauss-Newton step, shape (d,)."""
    normal = jacobian.T @ jacobian
    scale = np.diag(normal) + 1e-12 * max(float(np.trace(normal)), 1e-300)
    return np.asarray(np.linalg.solve(normal + damping * np.diag(scale), -jacobian.T @ residuals))


def _sent(search: Generator[list[np.ndarray], list[Residuals], None], residuals: list[Residuals]) -> list[np.ndarray]:
    """Return the next points that a search needs; none if it has ended."""
    try:
        return search.send(residuals)
    except StopIteration:
        return []
