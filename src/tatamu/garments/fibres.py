"""Computes the direction of the warp in each triangle of a garment whose panels have different warp directions.

If the UV map of a mesh file is the sewing pattern, the warp is along +v of every panel, because patterns are drawn
along the grain. A garment cut from one outline has its warp along +x.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from tatamu.simulation.mesh.topology import facing_down


def along_v(uv: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Return the direction of a UV map's +v axis in triangles of a garment, as unit vectors, shape (m, 3).

    The triangles have the corners `uv` in the pattern, shape (m, 3, 2), and `corners` in the garment, shape (m, 3, 3).
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
    """Return the warp in each triangle of a new mesh of the same flat garment, shape (k, 3).

    It is that of the nearest old triangle in the same layer.
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
