"""Triangles joined to quadrilaterals, for Blender's linear bending model.

The linear bending model was the only one when the paper was written, and it needs quadrilaterals. On triangles, a strip
hangs over an edge as if it had no bending stiffness, and stretches up to ten times as far [measured, 5.0.1].
"""

from __future__ import annotations

import numpy as np

from tatamu.topology import Topology

ROWS = 0.2
"""Penalty for joining over an edge along y, as a cosine; it decides between equally rectangular pairs."""


def joined(points: np.ndarray, faces: np.ndarray) -> list[list[int]]:
    """Faces with pairs of triangles joined to quadrilaterals.

    Pairs are joined greedily, the most nearly rectangular first. Among equals, those with sides along y come first,
    like the rows of garments. A triangle whose neighbours are all joined stays a triangle.

    Args:
        points: Unstrained positions [m], shape (n, 3).
        faces: Triangles, shape (m, 3).
    """
    topology = Topology(faces)
    inner = np.flatnonzero(topology.faces_per_edge == 2)
    owners = _owners(topology, inner)
    corners = topology.hinges[:, [0, 3, 1, 2]]  # around the quadrilateral
    across = points[topology.hinges[:, 1]] - points[topology.hinges[:, 0]]
    along_y = np.abs(across[:, 1]) / np.linalg.norm(across, axis=1)
    order = np.argsort(_skewness(points[corners]) + ROWS * along_y, kind="stable")
    taken = np.zeros(len(faces), dtype=bool)
    quads: list[list[int]] = []
    for number in order:
        pair = owners[number]
        if not taken[pair].any():
            taken[pair] = True
            quads.append(corners[number].tolist())
    return quads + faces[~taken].tolist()


def _owners(topology: Topology, inner: np.ndarray) -> np.ndarray:
    """The two triangles at each inner edge, shape (k, 2)."""
    edges, face = topology.face_edges.ravel(), np.repeat(np.arange(len(topology.faces)), 3)
    order = np.argsort(edges, kind="stable")
    shared = order[np.isin(edges[order], inner)]
    return face[shared].reshape(-1, 2)


def _skewness(corners: np.ndarray) -> np.ndarray:
    """Largest cosine at a corner of quadrilaterals, shape (k,), from corners of shape (k, 4, 3)."""
    ahead = np.roll(corners, -1, axis=1) - corners
    ahead /= np.linalg.norm(ahead, axis=2, keepdims=True)
    return np.asarray(np.abs(np.einsum("kij,kij->ki", ahead, np.roll(ahead, 1, axis=1))).max(axis=1))
