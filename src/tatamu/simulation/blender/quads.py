"""Triangles joined to quadrilaterals, for the linear bending model that Blender had at the time of the ICMA 2019 paper.

On triangles, a strip that hangs over an edge droops as if it had no bending stiffness, and it is stretched up to ten
times as much (measured with Blender 5.0.1).
"""

from __future__ import annotations

import numpy as np

from tatamu.simulation.mesh.topology import Topology

ROWS = 0.2
"""Penalty on the skewness of pairs with a shared edge along y [-], which decides between equally rectangular pairs."""


def joined(points: np.ndarray, faces: np.ndarray) -> list[list[int]]:
    """Return the faces of a mesh, with pairs of triangles joined to quadrilaterals, the most nearly rectangular first.

    Among equally rectangular pairs, those with sides along y come first, because garments have rows along y.
    """
    topology = Topology(faces)
    inner = np.flatnonzero(topology.faces_per_edge == 2)
    owners = _owners(topology, inner)
    corners = topology.hinges[:, [0, 3, 1, 2]]  # in order around the quadrilateral
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
    """Return the two triangles at each inner edge, shape (k, 2)."""
    edges, face = topology.face_edges.ravel(), np.repeat(np.arange(len(topology.faces)), 3)
    order = np.argsort(edges, kind="stable")
    shared = order[np.isin(edges[order], inner)]
    return face[shared].reshape(-1, 2)


def _skewness(corners: np.ndarray) -> np.ndarray:
    """Return the maximum cosine at a corner of each quadrilateral, shape (k,), from corners of the shape (k, 4, 3)."""
    ahead = np.roll(corners, -1, axis=1) - corners
    ahead /= np.linalg.norm(ahead, axis=2, keepdims=True)
    return np.asarray(np.abs(np.einsum("kij,kij->ki", ahead, np.roll(ahead, 1, axis=1))).max(axis=1))
