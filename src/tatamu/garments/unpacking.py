"""Bounds of drawings whose parts show other parts, so that a small file may unpack to any number of curves."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable
from typing import TypeVar

from tatamu.errors import InputError
from tatamu.files import MIB

LARGEST_DRAWING = 16 * MIB
"""Largest size of a drawing's file [bytes]."""
MOST_PARTS = 500_000
"""Drawings unpack to no more elements and numbers of paths."""
DEEPEST = 100
"""No element of a drawing lies in more others."""
MOST_CURVES = 5_000
"""Drawings have no more closed curves, and no more open ones."""
Part = TypeVar("Part", bound=Hashable)


def check_unpacked(
    root: Part, parts: Callable[[Part], Iterable[tuple[Part, int]]], own: Callable[[Part], int], most: int = MOST_PARTS
) -> None:
    """Refuse a drawing that unpacks to too much, before it is unpacked.

    Args:
        root: The whole drawing.
        parts: The parts that a part shows, and how many times.
        own: The number of elements of a part itself.
        most: The largest number of elements of the whole drawing.

    Raises:
        InputError: If a part shows itself, lies too deep, or the drawing has too many elements.
    """
    known: dict[Part, int] = {}
    open_parts: set[Part] = set()

    def size(part: Part) -> int:
        if part in known:
            return known[part]
        if part in open_parts:
            raise InputError("outline: one of its parts shows itself")
        if len(open_parts) >= DEEPEST:
            raise InputError(f"outline: must have parts at most {DEEPEST} deep in one another; flatten its groups")
        open_parts.add(part)
        total = own(part) + sum(count * size(shown) for shown, count in parts(part))
        open_parts.discard(part)
        if total > most:
            raise InputError(f"outline: must have at most {most} elements and numbers of paths; simplify it")
        known[part] = total
        return total

    size(root)
