"""Divides the sides of a flat garment's mesh into seams and openings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tatamu.garments.outline_sides import MIN_SIDE


@dataclass
class _Part:
    """A sewn or open part of a garment's side, from its `first` to its `last` point."""

    first: int
    last: int
    is_open: bool
    name: str = ""

    @property
    def points(self) -> slice:
        return slice(self.first, self.last + 1)


def divided(
    sides: Mapping[str, np.ndarray], border: np.ndarray, plan: np.ndarray
) -> tuple[dict[str, np.ndarray], tuple[str, ...]]:
    """Divide the sides of a garment into sewn parts and open parts; return all by name, and the names of the open ones.

    The longest sewn part keeps the name of its side. An open part of the side "top" is called "top opening".

    Args:
        sides: Paths of vertices by name; each path begins at the end of the previous path.
        border: Edges of the mesh that belong to a single triangle, shape (b, 2).
        plan: Positions of the vertices [m], shape (n, 2).
    """
    free = {tuple(pair) for pair in border.tolist()}
    around = sum(float(_lengths(plan[path]).sum()) for path in sides.values())
    parted: dict[str, np.ndarray] = {}
    openings = []
    for side, path in sides.items():
        is_open = np.array([tuple(sorted(pair)) in free for pair in pairwise(path.tolist())])
        parts = _parts(is_open, _lengths(plan[path]), MIN_SIDE * around)
        _name(parts, side, {*sides, *parted})
        for part in parts:
            parted[part.name] = path[part.points]
            openings += [part.name] if part.is_open else []
    return parted, tuple(openings)


def _lengths(points: np.ndarray) -> np.ndarray:
    return np.asarray(np.linalg.norm(np.diff(points, axis=0), axis=1))


def _parts(is_open: np.ndarray, lengths: np.ndarray, shortest: float) -> list[_Part]:
    """Return the parts of a side; one shorter than `shortest` [m] is joined with its longer neighbour."""
    kind = is_open.copy()
    while True:
        bounds = [0, *(np.flatnonzero(np.diff(kind)) + 1).tolist(), len(kind)]
        parts = [_Part(first, last, bool(kind[first])) for first, last in pairwise(bounds)]
        sizes = [float(lengths[part.first : part.last].sum()) for part in parts]
        smallest = int(np.argmin(sizes))
        if len(parts) == 1 or sizes[smallest] >= shortest:
            return parts
        part = parts[smallest]
        kind[part.first : part.last] = not part.is_open


def _name(parts: list[_Part], side: str, taken: set[str]) -> None:
    """Name the parts of a side; the longest sewn part, or the only one, gets the name of the side."""
    main = max(parts, key=lambda part: (not part.is_open, part.last - part.first))
    main.name = side
    for part in parts:
        if part is main:
            continue
        wish = f"{side} opening" if part.is_open else side
        numbered = (wish if number == 1 else f"{wish} {number}" for number in range(1, len(parts) + len(taken) + 2))
        part.name = next(name for name in numbered if name not in taken)
        taken.add(part.name)
