"""Curvatures of a triangle from the dihedral angles at its edges, and the stiffness of the triangle.

    Q   = a C + (1 - a) R^-1                    from the three angles of triangle T to its curvatures (k_uu, k_vv, k_uv)
    K_T = A_T Q' D Q                            D = B diag(1, 1, 2), or diag(B, B_weft, twist) along the fibres

a is a weight, and A_T the area of the triangle. D contains the rigidities: the bending rigidity B along the warp,
B_weft along the weft, and the rigidity of twist. The triangle and its three neighbours have six vertices. R maps the
curvatures of a quadratic deflection of these vertices to the three dihedral angles, if they are small. R^-1 is exact
for such a deflection. On irregular meshes, however, the forces of a constant moment do not cancel, and cloth is too
soft.

C sums the turning of the surface at the three edges, k = sum_e l_e s_e theta_e n_e n_e' / A. l_e is the length of edge
e, theta_e its dihedral angle, and n_e the direction across it. This is the basic shell triangle of Onate and Zarate
2000, which has s_e = 1/2. Here, a triangle has the share s_e = d / (d + d') of the angle. d is the height of the
triangle over the edge, and d' the height of its neighbour. This is exact for curvature across the edge. Both shares sum
to 1, so the forces of a constant moment cancel on any mesh. However, the curvature is not exact, and cloth is too
stiff.

On a mesh of regular rows, C and R^-1 are equal. On other meshes, their mean is more accurate than C or R^-1 alone. A
border or a seam carries no moment, so the curvature across it is zero. The derivation is in docs/theory/bending.md.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tatamu.simulation.material import Material
from tatamu.simulation.mesh.topology import Topology, areas

LARGEST_CONDITION = 1e6
"""Largest condition number of the matrix R at which its inverse is used [-].

R maps the curvatures of a triangle to its dihedral angles. On meshes of garments, the condition number is below a
thousandth of this limit."""


class CurvatureMaps(NamedTuple):
    """Matrices from dihedral angles to curvatures, for all t triangles with a hinge (an edge that carries a moment)."""

    Q: np.ndarray
    """Matrix of each triangle from the measures g of its dihedral angles to its curvatures [1/m].

    The shape is (t, 3 curvatures, 3 hinges). The column of an edge that carries no moment is zero."""
    area: np.ndarray
    """Area of each triangle [m^2], shape (t,)."""
    hinges: np.ndarray
    """Numbers of the hinges of each triangle, shape (t, 3).

    If an edge carries no moment, the number of another hinge of the triangle stands in its place."""


def rigidities(material: Material) -> np.ndarray:
    """Return the matrix D from curvatures (k_uu, k_vv, k_uv) to moments [N m], shape (3, 3).

    The direction u is along the warp.
    """
    if not material.orthotropic_bending:
        return material.bending_rigidity * np.diag([1.0, 1.0, 2.0])
    return np.diag([material.bending_rigidity, material.weft_rigidity, material.twist_rigidity])


def _feet(rest: np.ndarray, hinges: np.ndarray, apex: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the foot of a vertex on the opposite edge and its height over this edge, for each of h hinges.

    Both arrays have the shape (h,). The foot is the nearest point of the edge, as a fraction of the edge. The height
    has the unit m.
    """
    x0, x1, x2 = rest[hinges[:, 0]], rest[hinges[:, 1]], rest[hinges[:, apex]]
    edge = x1 - x0
    t = np.einsum("ij,ij->i", x2 - x0, edge) / np.einsum("ij,ij->i", edge, edge)
    return t, np.linalg.norm(x2 - x0 - t[:, None] * edge, axis=1)


def _operators(
    rest: np.ndarray, faces: np.ndarray, frames: np.ndarray, hinges: np.ndarray, at: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the matrices R and C of each of the m triangles.

    R maps the curvatures of a quadratic deflection to the dihedral angles at the edges, shape (m, 3 edges, 3
    curvatures). C computes the curvatures as sums over the angles at the edges, shape (m, 3 curvatures, 3 edges). If an
    edge is not a hinge (its number in `at` is negative), its row in R gives the curvature across the edge, and its
    column in C is zero.
    """
    feet = [_feet(rest, hinges, 2), _feet(rest, hinges, 3)]
    rows = np.zeros((len(faces), 3, 3))
    columns = np.zeros((len(faces), 3, 3))
    area = areas(rest, faces)
    for q in range(3):
        i = (q + 1) % 3
        j = (q + 2) % 3
        k = q
        side = frames[:, j] - frames[:, i]
        length = np.linalg.norm(side, axis=1)
        normal = np.column_stack([side[:, 1], -side[:, 0]]) / length[:, None]
        nn = np.column_stack([normal[:, 0] ** 2, normal[:, 1] ** 2, normal[:, 0] * normal[:, 1]])
        none = np.flatnonzero(at[:, q] < 0)
        has = np.flatnonzero(at[:, q] >= 0)
        rows[none, q] = nn[none] * [1.0, 1.0, 2.0]
        h = at[has, q]
        face = faces[has]
        own_second = hinges[h, 2] != face[:, k]  # this triangle contains x3 and not x2
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
        points = (p, frames[has, j], frames[has, k], far)
        weights = (
            (1 - t_own) / l_own + (1 - t_far) / l_far,
            t_own / l_own + t_far / l_far,
            -1 / l_own,
            -1 / l_far,
        )
        for x, w in zip(points, weights, strict=True):
            u = x[:, 0]
            v = x[:, 1]
            rows[has, q] += (sign * w)[:, None] * np.column_stack([u * u / 2, v * v / 2, u * v])
    return rows, columns


def curvatures(R: np.ndarray, C: np.ndarray, angle_sum_part: float) -> np.ndarray:
    """Return the matrix Q = a C + (1 - a) R^-1 of each of the m triangles, shape (m, 3, 3).

    Q maps dihedral angles to curvatures, and a is the weight `angle_sum_part`. On some meshes of few triangles, the six
    vertices of a triangle and its neighbours lie on a conic. Then a deflection exists that turns no edge, and R has no
    inverse. In this case Q = C, because C always exists.
    """
    regular = (np.linalg.cond(R) < LARGEST_CONDITION)[:, None, None]
    inverse = np.linalg.inv(np.where(regular, R, np.eye(3)))
    return np.asarray(np.where(regular, angle_sum_part * C + (1.0 - angle_sum_part) * inverse, C))


def maps(
    rest: np.ndarray, topology: Topology, frames: np.ndarray, free: np.ndarray, angle_sum_part: float
) -> CurvatureMaps:
    """Return the curvature maps (matrices from dihedral angles to curvatures) of all triangles that have a hinge.

    Args:
        rest: Unstrained positions [m], shape (n, 3).
        topology: Topology of the mesh, with h hinges.
        frames: Corners of each triangle in its own plane [m], shape (m, 3, 2).
        free: Whether each hinge carries no moment, for example at a seam, shape (h,).
        angle_sum_part: Weight a of the matrix C in Q = a C + (1 - a) R^-1 [-].
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
    """Return the stiffness K_T = A_T Q' D Q of each of the t triangles [N m], shape (t, 3, 3).

    A_T is the area of a triangle, and Q its matrix from dihedral angles to curvatures.

    Args:
        curved: Curvature maps of the mesh.
        D: Matrix from curvatures to moments [N m], shape (3, 3).
    """
    return np.asarray(curved.area[:, None, None] * (curved.Q.transpose(0, 2, 1) @ D @ curved.Q))
