"""Limits the size of drawings whose parts include other parts, so a small file may unpack to very many curves."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable
from typing import TypeVar

from tatamu.base.errors import InputError
from tatamu.base.files import MIB

LARGEST_DRAWING = 16 * MIB
"""Largest size of a drawing's file [bytes]."""
MOST_PARTS = 500_000
"""Maximum number of elements and of numbers in paths, each included part counted as its own."""
DEEPEST = 100
"""Maximum depth to which parts include other parts."""
MOST_CURVES = 5_000
"""Maximum number of closed curves, and of open curves."""
Part = TypeVar("Part", bound=Hashable)


def check_unpacked(
    root: Part, parts: Callable[[Part], Iterable[tuple[Part, int]]], own: Callable[[Part], int], most: int = MOST_PARTS
) -> None:
    """Refuse a drawing that would have too many elements if each included part were replaced by its elements.

    Args:
        root: The whole drawing.
        parts: Function that returns the parts that a part includes, and how often.
        own: Function that returns the number of elements of a part, without included parts.
        most: Maximum number of elements of the whole drawing.

    Raises:
        InputError: If a part includes itself, parts are nested too deeply, or the drawing has too many elements.
    """
    known: dict[Part, int] = {}
    open_parts: set[Part] = set()

    def size(part: Part) -> int:
        if part in known:
            return known[part]
        if part in open_parts:
            raise InputError("outline: must not contain a part that shows itself")
        if len(open_parts) >= DEEPEST:
            raise InputError(f"outline: must have groups nested at most {DEEPEST} deep; flatten the groups")
        open_parts.add(part)
        total = own(part) + sum(count * size(shown) for shown, count in parts(part))
        open_parts.discard(part)
        if total > most:
            raise InputError(f"outline: must have at most {most} elements and numbers of paths; simplify the drawing")
        known[part] = total
        return total

    size(root)
