"""The layout of vertices in memory, with which forces are computed over long contiguous runs (docs/theory/memory.md).

Vertices that form a lattice are stored row by row, even and odd rows separately, and all rows have the same length.
Triangles that follow one another along a row then have the vertices a + j, b + j and c + j: a *band*. A *slot* is the
memory position of a vertex. Slots without a vertex and places without a triangle are fillers with zero mass and zero
stiffness. Elements that fit in no band form one more band, of copies of their vertices.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tatamu.simulation.native.lattice import patches

BLOCK = 528
"""Number of elements that are computed together, so that intermediate values stay in the nearest cache. It is no power
of two, because rows at such a distance would use the same cache lines."""
FULLEST = 2.0
"""Maximum ratio of slots to vertices [-], above which vertices are not arranged in rows."""


@dataclass(frozen=True)
class Bands:
    """Elements with k vertices each, ordered by band."""

    table: np.ndarray
    """First element, length, and first slot of each of the k vertices of every band, shape (bands, 2 + k)."""
    element: np.ndarray
    """Mesh element at each place of the bands, shape (places,); -1 for a filler."""
    copied: np.ndarray
    """Slots that are copied behind the last slot before forces are computed, and get the forces on the copies."""

    @property
    def size(self) -> int:
        """Number of places, including fillers."""
        return len(self.element)

    def spread(self, values: np.ndarray) -> np.ndarray:
        """Return values per mesh element, the last axis, in the order of the places; zero for fillers."""
        out = np.zeros((*values.shape[:-1], self.size))
        filled = self.element >= 0
        out[..., filled] = values[..., self.element[filled]]
        return out

    @property
    def place(self) -> np.ndarray:
        """Place of each mesh element, shape (elements,)."""
        filled = np.flatnonzero(self.element >= 0)
        out = np.empty(len(filled), dtype=np.int64)
        out[self.element[filled]] = filled
        return out


def slots(rest: np.ndarray, hinges: np.ndarray) -> tuple[np.ndarray, int]:
    """Return the slot of each vertex, shape (n,), and the number of slots."""
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
    """Return triangles that begin with the corner in the lowest slot, so that those of a row form one band."""
    first = np.argmin(slot[faces], axis=1)
    return np.take_along_axis(faces, (first[:, None] + np.arange(3)) % 3, axis=1)


def turned_hinges(hinges: np.ndarray, slot: np.ndarray) -> np.ndarray:
    """Return hinges whose first end has the lower slot, with both ends and both opposite vertices swapped if needed."""
    back = slot[hinges[:, 0]] > slot[hinges[:, 1]]
    return np.where(back[:, None], hinges[:, [1, 0, 3, 2]], hinges)


def bands(elements: np.ndarray, total: int) -> Bands:
    """Arrange elements in bands by the slots of their vertices, shape (e, k); copies come behind `total` slots."""
    count, width = elements.shape
    if not count:  # a single triangle has no hinge
        return Bands(np.zeros((0, 2 + width), np.int64), np.zeros(0, np.int64), np.zeros(0, np.int64))
    offsets = elements - elements[:, :1]
    _, group = np.unique(offsets, axis=0, return_inverse=True)
    group = group.ravel()
    table: list[list[int]] = []
    order: list[np.ndarray] = []
    loose = np.ones(count, dtype=bool)
    for g in np.flatnonzero(np.bincount(group) >= 24):  # fewer elements are not worth a band
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
    """Return the number of blocks, of at most BLOCK elements of one band, in a table."""
    return int((-(-table[:, 1] // BLOCK)).sum())
