"""The named edges by which a garment is held."""

from __future__ import annotations

import numpy as np

from tatamu.base.errors import InputError
from tatamu.garments import Garment


def named_edge(garment: Garment, name: str) -> np.ndarray:
    """Return the indices of the vertices along a named edge of the garment, in order.

    Raises:
        InputError: If the garment has no such edge.
    """
    if name not in garment.edges:
        raise InputError(f"edge: {garment.name} has {', '.join(garment.edges)}, given {name!r}")
    return garment.edges[name]


def longest_edge(garment: Garment) -> str:
    """Return the name of the longest edge at an opening of the garment, such as a hem.

    If no edge is at an opening, return the name of the longest edge.

    Raises:
        InputError: If the garment has no named edges.
    """
    names = [name for name in garment.edges if name in garment.openings] or list(garment.edges)
    if not names:
        raise InputError(f"garment: {garment.name} has no named edges to hold it by")
    flat = garment.vertices
    return max(names, key=lambda name: np.linalg.norm(np.diff(flat[garment.edges[name]], axis=0), axis=1).sum())
