"""Joins triangles to quadrilaterals, for Blender's linear bending model.

When the ICMA 2019 paper was written, Blender had only the linear bending model. This model needs quadrilaterals. On
triangles, a strip that hangs over an edge droops as if it had no bending stiffness. In addition, it is stretched up to
ten times as much as on quadrilaterals (measured with Blender 5.0.1).
"""

from __future__ import annotations

import numpy as np

from tatamu.simulation.mesh.topology import Topology

ROWS = 0.2
"""Penalty for joining two triangles whose shared edge is along y [-].

Pairs of triangles are joined to quadrilaterals in the order of their skewness, the largest cosine at a corner. The
penalty is added to the skewness. It decides between pairs that are equally rectangular."""


def joined(points: np.ndarray, faces: np.ndarray) -> list[list[int]]:
    """Return the faces of a mesh, with pairs of triangles joined to quadrilaterals.

    The pair that is most nearly rectangular is joined first. Among equally rectangular pairs, pairs with sides along y
    come first, because the vertices of garments lie in rows along y. A triangle stays a triangle if all its neighbours
    are already joined.

    Args:
        points: Unstrained positions [m], shape (n, 3).
        faces: Triangles, shape (m, 3).
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
    """Return the two triangles at each of the k inner edges, shape (k, 2)."""
    edges, face = topology.face_edges.ravel(), np.repeat(np.arange(len(topology.faces)), 3)
    order = np.argsort(edges, kind="stable")
    shared = order[np.isin(edges[order], inner)]
    return face[shared].reshape(-1, 2)


def _skewness(corners: np.ndarray) -> np.ndarray:
    """Return the largest cosine at a corner of each of k quadrilaterals, shape (k,).

    The value is 0 for a rectangle. `corners` contains the positions of the corners, shape (k, 4, 3).
    """
    ahead = np.roll(corners, -1, axis=1) - corners
    ahead /= np.linalg.norm(ahead, axis=2, keepdims=True)
    return np.asarray(np.abs(np.einsum("kij,kij->ki", ahead, np.roll(ahead, 1, axis=1))).max(axis=1))
