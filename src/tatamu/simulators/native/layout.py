"""Where the vertices lie in memory, so that forces are computed over long contiguous runs.

A processor computes eight or sixteen neighbouring numbers at once, if they are neighbours in memory. The rows of a
staggered mesh are therefore stored with one stride, even rows apart from odd rows: then all triangles of one kind
are (a + j, b + j, c + j) for j = 0, 1, .., a *band*. Slots without a vertex, and band elements without a triangle,
are fillers with zero mass and zero stiffness. Elements that fit in no band are computed on copies of their vertices,
laid out as one more band; so the kernels know bands only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tatamu.topology import Topology

SHORTEST_ROW = 6
SHORTEST_BAND = 24
FULLEST = 2.0
"""Give up on rows when they would need more than this many slots per vertex."""


@dataclass(frozen=True)
class Bands:
    """Elements of k vertices each, ordered by band."""

    table: np.ndarray
    """Per band: first element, length, first slot of each of the k vertices; shape (b, 2 + k)."""
    element: np.ndarray
    """Which element of the mesh fills each place, -1 for a filler; shape (e,)."""
    copied: np.ndarray
    """Slots whose values are copied behind the last slot before, and added back after; shape (c,)."""

    @property
    def size(self) -> int:
        """Number of places, fillers included."""
        return len(self.element)

    def spread(self, values: np.ndarray) -> np.ndarray:
        """Values per mesh element, shape (.., e), as values per place, fillers zero; contiguous."""
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


def slots(count: int, faces: np.ndarray) -> tuple[np.ndarray, int]:
    """Slot of each vertex, shape (n,), and the number of slots."""
    plain = np.arange(count), count
    edges = Topology(faces).edges
    start = _row_starts(count, edges)
    lengths = np.diff(np.append(start, count))
    if np.mean(lengths) < SHORTEST_ROW:
        return plain
    row = np.repeat(np.arange(len(start)), lengths)
    column = np.arange(count) - start[row]
    shift = _row_shifts(row, column, edges)
    column = column + shift[row]
    width = int(column.max()) + 1
    half = (len(start) + 1) // 2
    total = 2 * half * width
    if total > FULLEST * count:
        return plain
    return (row % 2) * half * width + (row // 2) * width + column, total


def _row_starts(count: int, edges: np.ndarray) -> np.ndarray:
    """First vertex of every chain i, i+1, .. joined by edges."""
    joined = np.zeros(count, dtype=bool)
    joined[edges[edges[:, 1] == edges[:, 0] + 1, 1]] = True
    return np.flatnonzero(~joined)


def _row_shifts(row: np.ndarray, column: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Column offset of every row that makes odd rows lean the same way against even ones, at least 0."""
    rows = int(row.max()) + 1
    shift = np.zeros(rows, dtype=np.int64)
    for r in range(1, rows):
        between = edges[(row[edges[:, 0]] == r - 1) & (row[edges[:, 1]] == r)]
        if not len(between):
            continue
        lean = column[between[:, 0]] + shift[r - 1] - column[between[:, 1]]
        values, counts = np.unique(lean, return_counts=True)
        pair = counts + np.where(np.isin(values + 1, values), np.append(counts[1:], 0), 0)
        low = int(values[np.argmax(pair)])
        shift[r] = low if r % 2 else low + 1
    return shift - shift.min()


def bands(elements: np.ndarray, total: int) -> Bands:
    """Arrange elements of k slots, shape (e, k), in bands; copies go behind slot `total`."""
    count, width = elements.shape
    offsets = elements - elements[:, :1]
    _, group = np.unique(offsets, axis=0, return_inverse=True)
    group = group.ravel()
    table: list[list[int]] = []
    order: list[np.ndarray] = []
    loose = np.ones(count, dtype=bool)
    for g in np.flatnonzero(np.bincount(group) >= SHORTEST_BAND):
        members = np.flatnonzero(group == g)
        first = elements[members, 0]
        low, span = int(first.min()), int(first.max() - first.min()) + 1
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
