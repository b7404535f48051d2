"""Edges, hinges and borders of a triangle mesh, and a check whether the mesh can be a cloth."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np


@dataclass(frozen=True)
class Topology:
    """Neighbourhood of vertices, edges and triangles in a triangle mesh."""

    faces: np.ndarray

    @cached_property
    def _sides(self) -> tuple[np.ndarray, np.ndarray]:
        """All 3m directed sides as sorted pairs, and the vertex opposite each side. Side s belongs to face s % m."""
        corners = [(1, 2, 0), (2, 0, 1), (0, 1, 2)]
        pairs = np.concatenate([self.faces[:, [i, j]] for i, j, _ in corners])
        opposite = np.concatenate([self.faces[:, k] for _, _, k in corners])
        return np.sort(pairs, axis=1), opposite

    @cached_property
    def _grouped(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        count = self.faces.max() + 1
        numbers, which, times = np.unique(self._sides[0] @ [count, 1], return_inverse=True, return_counts=True)
        return np.column_stack(np.divmod(numbers, count)), which, times

    @property
    def edges(self) -> np.ndarray:
        """All edges as sorted pairs, shape (e, 2), in lexical order."""
        return self._grouped[0]

    @property
    def faces_per_edge(self) -> np.ndarray:
        """Number of triangles that share each edge, shape (e,)."""
        return self._grouped[2]

    @cached_property
    def border(self) -> np.ndarray:
        """The edges that belong to only one triangle, shape (b, 2)."""
        return self.edges[self.faces_per_edge == 1]

    @cached_property
    def face_edges(self) -> np.ndarray:
        """Edge opposite each corner of each triangle, as an index into `edges`, shape (m, 3)."""
        return self._grouped[1].reshape(3, -1).T

    @cached_property
    def _inner(self) -> np.ndarray:
        """The two sides at each inner edge, in the order of `edges`, shape (h, 2)."""
        order = np.argsort(self._grouped[1].ravel(), kind="stable")
        return order[np.repeat(self.faces_per_edge, self.faces_per_edge) == 2].reshape(-1, 2)

    @property
    def inner_edges(self) -> np.ndarray:
        """The edges that two triangles share, shape (h, 2)."""
        return self.edges[self.faces_per_edge == 2]

    @cached_property
    def neighbours(self) -> np.ndarray:
        """The two triangles at each of the `inner_edges`, shape (h, 2)."""
        return self._inner % len(self.faces)

    @cached_property
    def hinges(self) -> np.ndarray:
        """Inner edges (x0, x1) in the order of `edges` and opposite vertices (x2, x3), shape (h, 4).

        The triangle (x0, x1, x2) has the same orientation as in `faces`.
        """
        _, opposite = self._sides
        inner = self._inner
        corner, face = np.divmod(inner[:, 0], len(self.faces))  # the ends are in the order of this triangle's corners
        ends = [self.faces[face, (corner + k) % 3] for k in (1, 2)]
        return np.column_stack([*ends, opposite[inner[:, 0]], opposite[inner[:, 1]]])


def among(pairs: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return whether each of k pairs of vertices is among others, in either order, shape (k,)."""
    count = max(pairs.max(initial=0), others.max(initial=0)) + 1
    return np.isin(np.sort(pairs, axis=1) @ [count, 1], np.sort(others, axis=1) @ [count, 1])


def areas(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the area of each triangle, shape (m,)."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def principal_stretches(points: np.ndarray, rest: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the maximum stretch of each triangle in any direction [-], shape (m,)."""
    (a, b, c), (u, v, w) = (_metric(each, faces) for each in (points, rest))
    with np.errstate(all="ignore"):  # the stretch of a triangle without an area is not defined
        area = u * w - v * v
        half_trace = 0.5 * (a * w - 2.0 * b * v + c * u) / area
        split = np.maximum(half_trace**2 - (a * c - b * b) / area, 0.0)
        return np.asarray(np.sqrt(half_trace + np.sqrt(split)))


def _metric(points: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return s.s, s.t and t.t of each triangle, with its two sides s and t at its first corner, shapes (m,)."""
    s, t = (points[faces[:, k]] - points[faces[:, 0]] for k in (1, 2))
    return (s * s).sum(axis=1), (s * t).sum(axis=1), (t * t).sum(axis=1)


def twice_areas(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return twice the area of each triangle in the plane, shape (m,), negative if it is clockwise."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    return (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]


def facing_down(flat: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return whether the normal of each triangle points down, as in the lower layer of a garment that lies flat."""
    return twice_areas(flat, faces) < 0.0


def edge_lengths(points: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Return the length of each edge, shape (e,)."""
    return np.asarray(np.linalg.norm(points[edges[:, 1]] - points[edges[:, 0]], axis=1))


def longest_sides(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the length of the longest side of each triangle, shape (m,)."""
    return np.max([edge_lengths(points, faces[:, [i - 1, i]]) for i in range(3)], axis=0)


def lumped(weight: np.ndarray, faces: np.ndarray, count: int) -> np.ndarray:
    """Return weights of vertices, shape (count,): each triangle shares its weight equally among its corners."""
    return np.bincount(faces.ravel(), np.repeat(weight / 3.0, 3), minlength=count)


def connected(pairs: np.ndarray, count: int) -> np.ndarray:
    """Return the index of the connected part to which each of `count` things belongs, from pairs of neighbours."""
    from scipy.sparse import csr_array  # scenes need neither of the two imports
    from scipy.sparse.csgraph import connected_components

    joined = csr_array((np.ones(len(pairs)), pairs.T), shape=(count, count))
    return np.asarray(connected_components(joined, directed=False)[1])


def check_mesh(rest: np.ndarray, faces: np.ndarray, seams: np.ndarray) -> None:
    """Raise ValueError, which names the fault, if a mesh cannot be a cloth."""
    count = len(rest)
    if not len(faces):
        raise ValueError("faces must contain at least one triangle, given none")
    if faces.min() < 0 or faces.max() >= count:
        wrong = int(np.argmax((faces < 0).any(1) | (faces >= count).any(1)))
        raise ValueError(
            f"faces must be vertex indices from 0 to {count - 1}, given {faces[wrong].tolist()} in triangle {wrong}"
        )
    area = areas(rest, faces)
    flat = area < 1e-6 * longest_sides(rest, faces) ** 2
    if flat.any() or not area.min() > 1e-12:
        wrong = int(np.argmax(flat | (area <= 1e-12)))
        raise ValueError(f"faces must have an area above 0, but triangle {wrong} {faces[wrong].tolist()} has none")
    loose = np.setdiff1d(np.arange(count), faces)
    if len(loose):
        raise ValueError(f"vertices must each belong to a triangle, but vertex {loose[0]} belongs to none")
    topology = Topology(faces)
    if topology.faces_per_edge.max() > 2:
        crowded = int(np.argmax(topology.faces_per_edge))
        raise ValueError(
            "faces must form a manifold, with at most 2 triangles at each edge, given "
            f"{topology.faces_per_edge[crowded]} at edge {topology.edges[crowded].tolist()}"
        )
    around, most = np.bincount(faces.ravel()), 1000  # the memory for contact around a vertex grows with the square
    if around.max() > most:
        raise ValueError(
            f"faces must have at most {most} triangles at each vertex, given {around.max()} at vertex "
            f"{int(around.argmax())}"
        )
    apart = ~among(seams, topology.inner_edges)
    if apart.any():
        raise ValueError(f"seams must be edges shared by two triangles, given {seams[apart.argmax()].tolist()}")
