"""Computes the direction of the warp in each triangle of a garment whose panels have different warp directions.

The warp is the direction of the threads along the length of a fabric. A garment cut from one outline has its warp along
its length, +x, in all triangles. A mesh file may have a UV map that is the sewing pattern of the garment. If the file
has such a UV map, the warp is along +v of every panel, because patterns are drawn along the grain.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from tatamu.simulation.mesh.topology import facing_down


def along_v(uv: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Return the direction of a UV map's +v axis in each of m triangles of a garment, as unit vectors, shape (m, 3).

    Args:
        uv: Corners of the triangles in the pattern, shape (m, 3, 2).
        corners: Corners of the triangles in the garment [m], shape (m, 3, 3).
    """
    first, second = (uv[:, k] - uv[:, 0] for k in (1, 2))
    one, other = (corners[:, k] - corners[:, 0] for k in (1, 2))
    # a and b solve first * b + second * a = (0, det), with det the cross product of first and second
    along = first[:, :1] * other - second[:, :1] * one
    turned = np.sign(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])[:, None]
    return turned * along / np.linalg.norm(along, axis=1, keepdims=True)


def carried(
    fibre: np.ndarray,
    points: np.ndarray,
    faces: np.ndarray,
    new_points: np.ndarray,
    new_faces: np.ndarray,
) -> np.ndarray:
    """Return the warp direction in each of the k triangles of a new mesh, copied from an old mesh, shape (k, 3).

    Both meshes are of the same flat garment. Each new triangle has the direction of the nearest old triangle in the
    same layer.

    Args:
        fibre: Warp direction in each of the m triangles of the old mesh, shape (m, 3).
        points: Vertices of the old mesh of the flat garment [m], shape (n, 3).
        faces: Triangles of the old mesh, shape (m, 3).
        new_points: Vertices of the new mesh [m].
        new_faces: Triangles of the new mesh, shape (k, 3).
    """
    out = np.empty((len(new_faces), 3))
    down, new_down = facing_down(points, faces), facing_down(new_points, new_faces)
    for side in (False, True):
        old, new = np.flatnonzero(down == side), np.flatnonzero(new_down == side)
        if not len(new):
            continue
        middles, new_middles = (
            mesh[triangles].mean(axis=1)[:, :2]
            for mesh, triangles in ((points, faces[old]), (new_points, new_faces[new]))
        )
        out[new] = fibre[old[cKDTree(middles).query(new_middles)[1]]]
    return out
