"""The layout of vertices in memory, with which forces are computed over long contiguous runs of numbers.

A processor computes eight or sixteen numbers together if they are neighbours in memory. Therefore vertices that form a
lattice (`lattice`) are stored row by row, and all rows have the same length in memory. Even rows and odd rows are
stored separately. Triangles that follow one another along a row, and have the same orientation, then have the vertices
a + j, b + j and c + j for j = 0, 1, ... Such a run of triangles is a *band*.

A *slot* is the memory position of a vertex. Slots without a vertex, and positions in a band without a triangle, are
fillers with zero mass and zero stiffness. Some elements (triangles or hinges) fit in no band. For these elements, their
vertices are copied to neighbouring places in memory. Then these elements form one more band, so the compiled functions
only process bands.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tatamu.simulation.native.memory.lattice import patches

BLOCK = 528
"""Number of elements of a band that are computed together. Intermediate values then stay in the nearest cache.

The number is not a power of two, because rows whose distance is a power of two would use the same cache lines.
"""
SHORTEST_BAND = 24
"""Smallest number of elements (triangles or hinges) that form a band.

From each element of a band to the next, the memory positions of all vertices increase by one."""
FULLEST = 2.0
"""Largest ratio of slots to vertices [-].

If rows would need more slots, because many slots would be empty, vertices are not arranged in rows."""


@dataclass(frozen=True)
class Bands:
    """Elements with k vertices each, ordered by band."""

    table: np.ndarray
    """Table with one row for each of the b bands, shape (b, 2 + k).

    A row contains the first element, the length, and the first slot of each of the k vertices."""
    element: np.ndarray
    """Number of the mesh element at each of the e places of the bands, shape (e,); -1 for a filler."""
    copied: np.ndarray
    """The c slots whose values are copied behind the last slot before forces are computed, shape (c,).

    Forces on the copies are added to these slots afterwards."""

    @property
    def size(self) -> int:
        """Number of places in all bands. Fillers are included."""
        return len(self.element)

    def spread(self, values: np.ndarray) -> np.ndarray:
        """Return an array of values per mesh element, rearranged in the order of the places in memory.

        Fillers get zero. The last axis of `values` belongs to the mesh elements.
        """
        out = np.zeros((*values.shape[:-1], self.size))
        filled = self.element >= 0
        out[..., filled] = values[..., self.element[filled]]
        return out

    @property
    def place(self) -> np.ndarray:
        """Place in memory of each mesh element, shape (elements,)."""
        filled = np.flatnonzero(self.element >= 0)
        out = np.empty(len(filled), dtype=np.int64)
        out[self.element[filled]] = filled
        return out


def slots(rest: np.ndarray, hinges: np.ndarray) -> tuple[np.ndarray, int]:
    """Return the slot of each of the n vertices, shape (n,), and the number of slots.

    Args:
        rest: Unstrained positions [m], shape (n, 3).
        hinges: The h inner edges with their opposite vertices, shape (h, 4).
    """
    count = len(rest)
    found = patches(rest, hinges)
    if not found:
        return np.arange(count), count
    width = max(int(patch.column.max()) + 1 for patch in found)
    pairs = [int(patch.row.max()) // 2 + 1 for patch in found]  # pairs of rows; the last pair may have one row only
    half = sum(pairs) * width
    slot = np.full(count, -1)
    first = 0
    for patch, length in zip(found, pairs, strict=True):
        slot[patch.vertices] = (patch.row % 2) * half + (first + patch.row // 2) * width + patch.column
        first += length
    loose = np.flatnonzero(slot < 0)
    slot[loose] = 2 * half + np.arange(len(loose))
    total = 2 * half + len(loose)
    return (slot, total) if total <= FULLEST * count else (np.arange(count), count)


def turned(faces: np.ndarray, slot: np.ndarray) -> np.ndarray:
    """Return triangles whose corners begin with the corner in the lowest slot.

    The order around a triangle stays the same. As a result, triangles whose slots differ by a constant number form one
    band.
    """
    first = np.argmin(slot[faces], axis=1)
    return np.take_along_axis(faces, (first[:, None] + np.arange(3)) % 3, axis=1)


def turned_hinges(hinges: np.ndarray, slot: np.ndarray) -> np.ndarray:
    """Return hinges whose first vertex has a lower slot than their second vertex.

    The first two of its four vertices are the ends of this edge, and the last two are the opposite corners of the
    triangles. If the first end has the higher slot, the two ends are swapped, and the two corners as well. As a result,
    hinges whose slots differ by a constant number form one band.
    """
    back = slot[hinges[:, 0]] > slot[hinges[:, 1]]
    return np.where(back[:, None], hinges[:, [1, 0, 3, 2]], hinges)


def bands(elements: np.ndarray, total: int) -> Bands:
    """Arrange e elements in bands.

    `elements` contains the slots of the k vertices of each element, shape (e, k). Copies of vertices are placed behind
    the last of the `total` slots.
    """
    count, width = elements.shape
    if not count:  # a single triangle has no hinge
        return Bands(np.zeros((0, 2 + width), np.int64), np.zeros(0, np.int64), np.zeros(0, np.int64))
    offsets = elements - elements[:, :1]
    _, group = np.unique(offsets, axis=0, return_inverse=True)
    group = group.ravel()
    table: list[list[int]] = []
    order: list[np.ndarray] = []
    loose = np.ones(count, dtype=bool)
    for g in np.flatnonzero(np.bincount(group) >= SHORTEST_BAND):
        members = np.flatnonzero(group == g)
        first = elements[members, 0]
        low = int(first.min())
        span = int(first.max()) - low + 1
        if span > 2 * FULLEST * len(members) or len(np.unique(first)) < len(members):
            continue
        places = np.full(span, -1)
        places[first - low] = members
        table.append([sum(map(len, order)), span, *(offsets[members[0]] + low)])
        order.append(places)
        loose[members] = False
    rest = np.flatnonzero(loose)
    if len(rest):
        begin = [total + k * len(rest) for k in range(width)]
        table.append([sum(map(len, order)), len(rest), *begin])
        order.append(rest)
    return Bands(np.array(table, dtype=np.int64), np.concatenate(order), elements[rest].T.ravel())


def blocks(table: np.ndarray) -> int:
    """Return the number of blocks in the bands of a table. A block has at most BLOCK elements of one band."""
    return int((-(-table[:, 1] // BLOCK)).sum())
