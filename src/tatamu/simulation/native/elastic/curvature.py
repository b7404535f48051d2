"""Curvatures of a triangle from the dihedral angles at its edges, and its stiffness (docs/theory/bending.md).

    Q   = a C + (1 - a) R^-1                    from the three angles of triangle T to its curvatures (k_uu, k_vv, k_uv)
    K_T = A_T Q' D Q                            D = B diag(1, 1, 2), or diag(B, B_weft, twist) along the fibres

R maps the curvatures of a quadratic deflection of the triangle and its three neighbours to the three angles. R^-1 is
exact for it, but on irregular meshes, the forces of a constant moment do not cancel, and cloth is too soft.

C sums the turning at the three edges, k = sum_e l_e s_e theta_e n_e n_e' / A, with the length l_e of edge e and the
direction n_e across it, as the basic shell triangle with s_e = 1/2 (Onate and Zarate 2000). Here s_e = d / (d + d'),
with the heights of the triangle and its neighbour over the edge. The forces of a constant moment then cancel on any
mesh, but the curvature is not exact, and cloth is too stiff.

The mean of C and R^-1 is more accurate than either. A border or a seam carries no moment, so the curvature across it is
zero.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tatamu.simulation.material import Material
from tatamu.simulation.mesh.topology import Topology, areas


class CurvatureMaps(NamedTuple):
    """Matrices from dihedral angles to curvatures, for all t triangles with an edge that carries a moment (hinge)."""

    Q: np.ndarray
    """From the measures g to curvatures [1/m], shape (t, 3 curvatures, 3 hinges); zero for an edge without a moment."""
    area: np.ndarray
    """Area of each triangle [m^2], shape (t,)."""
    hinges: np.ndarray
    """Hinges of each triangle, shape (t, 3); another one stands in the place of an edge without a moment."""


def rigidities(material: Material) -> np.ndarray:
    """Return D from curvatures (k_uu, k_vv, k_uv), with u along the warp, to moments [N m], shape (3, 3)."""
    if not material.orthotropic_bending:
        return material.bending_rigidity * np.diag([1.0, 1.0, 2.0])
    return np.diag([material.bending_rigidity, material.weft_rigidity, material.twist_rigidity])


def _feet(rest: np.ndarray, hinges: np.ndarray, apex: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the foot of a vertex on each hinge's edge, as a fraction of it, and its height [m], both of shape (h,)."""
    x0, x1, x2 = rest[hinges[:, 0]], rest[hinges[:, 1]], rest[hinges[:, apex]]
    edge = x1 - x0
    t = np.einsum("ij,ij->i", x2 - x0, edge) / np.einsum("ij,ij->i", edge, edge)
    return t, np.linalg.norm(x2 - x0 - t[:, None] * edge, axis=1)


def _operators(
    rest: np.ndarray, faces: np.ndarray, frames: np.ndarray, hinges: np.ndarray, at: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return R, shape (m, 3 edges, 3 curvatures), and C, shape (m, 3 curvatures, 3 edges), of each triangle.

    If an edge is not a hinge (`at` is negative), its row in R gives the curvature across it, and its column in C is
    zero.
    """
    feet = [_feet(rest, hinges, 2), _feet(rest, hinges, 3)]
    rows = np.zeros((len(faces), 3, 3))
    columns = np.zeros((len(faces), 3, 3))
    area = areas(rest, faces)
    for q in range(3):
        i, j = (q + 1) % 3, (q + 2) % 3
        side = frames[:, j] - frames[:, i]
        length = np.linalg.norm(side, axis=1)
        normal = np.column_stack([side[:, 1], -side[:, 0]]) / length[:, None]
        nn = np.column_stack([normal[:, 0] ** 2, normal[:, 1] ** 2, normal[:, 0] * normal[:, 1]])
        none = np.flatnonzero(at[:, q] < 0)
        has = np.flatnonzero(at[:, q] >= 0)
        rows[none, q] = nn[none] * [1.0, 1.0, 2.0]
        h = at[has, q]
        face = faces[has]
        own_second = hinges[h, 2] != face[:, q]  # this triangle contains x3 and not x2
        forward = hinges[h, 0] == face[:, i]
        sign = np.where(own_second == forward, -1.0, 1.0)
        t_own, l_own, t_far, l_far = (
            np.where(own_second, feet[1 - s][p][h], feet[s][p][h]) for s in (0, 1) for p in (0, 1)
        )
        t_own, t_far = (np.where(forward, t, 1 - t) for t in (t_own, t_far))
        share = l_own / (l_own + l_far)
        columns[has, :, q] = (-sign * length[has] * share / area[has])[:, None] * nn[has]
        p = frames[has, i]
        far = p + t_far[:, None] * side[has] + l_far[:, None] * normal[has]
        points = (p, frames[has, j], frames[has, q], far)
        weights = ((1 - t_own) / l_own + (1 - t_far) / l_far, t_own / l_own + t_far / l_far, -1 / l_own, -1 / l_far)
        for x, w in zip(points, weights, strict=True):
            u, v = x.T
            rows[has, q] += (sign * w)[:, None] * np.column_stack([u * u / 2, v * v / 2, u * v])
    return rows, columns


def curvatures(R: np.ndarray, C: np.ndarray, angle_sum_part: float) -> np.ndarray:
    """Return Q = a C + (1 - a) R^-1 of each triangle, shape (m, 3, 3), with a = `angle_sum_part`.

    On some meshes of few triangles, the six vertices lie on a conic. Then a deflection turns no edge, so R has no
    inverse, and Q = C.
    """
    regular = (np.linalg.cond(R) < 1e6)[:, None, None]  # on meshes of garments it is below 1e3
    inverse = np.linalg.inv(np.where(regular, R, np.eye(3)))
    return np.asarray(np.where(regular, angle_sum_part * C + (1.0 - angle_sum_part) * inverse, C))


def maps(
    rest: np.ndarray, topology: Topology, frames: np.ndarray, free: np.ndarray, angle_sum_part: float
) -> CurvatureMaps:
    """Return the curvature maps of all triangles that have a hinge.

    `frames` are the corners of each triangle in its own plane [m], shape (m, 3, 2). A hinge that is `free`, as at a
    seam, carries no moment.
    """
    number = np.full(len(topology.edges), -1)
    inner = np.flatnonzero(topology.faces_per_edge == 2)
    number[inner] = np.where(free, -1, np.arange(len(inner)))
    at = number[topology.face_edges]  # (m, 3)
    lacking = at < 0
    R, C = _operators(rest, topology.faces, frames, topology.hinges, at)
    Q = np.where(lacking[:, None, :], 0.0, curvatures(R, C, angle_sum_part))
    some = ~lacking.all(axis=1)
    hinges = np.where(lacking, at.max(axis=1)[:, None], at)
    return CurvatureMaps(Q[some], areas(rest, topology.faces)[some], hinges[some])


def stiffness(curved: CurvatureMaps, D: np.ndarray) -> np.ndarray:
    """Return the stiffness K_T = A_T Q' D Q of each triangle [N m], shape (t, 3, 3)."""
    return np.asarray(curved.area[:, None, None] * (curved.Q.transpose(0, 2, 1) @ D @ curved.Q))
