"""Curvatures of a triangle from the dihedral angles of its edges, and the resulting stiffness.

    Q   = a C + (1 - a) R^-1                    from the three angles of triangle T to its curvatures (k_uu, k_vv, k_uv)
    K_T = A_T Q' D Q                            D = B diag(1, 1, 2), or diag(B, B_weft, twist) along the fibres

R maps the curvatures of a quadratic deflection to the small dihedral angles of the six-point patch around T. R^-1 is
exact for such a deflection, but on irregular meshes the forces of a constant moment do not cancel, and cloth is too
soft.

C adds up how far the surface has turned at each edge, k = sum_e l_e s_e theta_e n_e n_e' / A (as in the basic shell
triangle of Onate and Zarate 2000, with s_e = 1/2); of theta_e a triangle of height d has the share s_e = d / (d + d'),
which is exact for curvature across the edge. Both shares make 1, so the forces of a constant moment cancel on any mesh;
but the curvature is not exact, and cloth is too stiff.

In regular rows both are equal; elsewhere their mean is more accurate than either. A border or a seam carries no moment,
so the curvature across it is zero. Derived in docs/theory/bending.md.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tatamu.material import Material
from tatamu.topology import Topology, areas

LARGEST_CONDITION = 1e6
"""Largest condition number of R with a useful inverse; those of garments are less than a thousandth of it."""


class CurvatureMaps(NamedTuple):
    """Matrices from dihedral angles to curvatures, for all triangles with a hinge."""

    Q: np.ndarray
    """Curvatures of each triangle from the measures g of its hinges [1/m], shape (t, 3 curvatures, 3 hinges); zero
    where an edge carries no moment."""
    area: np.ndarray
    """Area of each triangle [m^2], shape (t,)."""
    hinges: np.ndarray
    """Hinges of each triangle, shape (t, 3); of an edge that carries no moment, another hinge of the triangle."""


def rigidities(material: Material) -> np.ndarray:
    """D from curvatures (k_uu, k_vv, k_uv), u along the warp, to moments [N m], shape (3, 3)."""
    if not material.orthotropic_bending:
        return material.bending_rigidity * np.diag([1.0, 1.0, 2.0])
    return np.diag([material.bending_rigidity, material.weft_rigidity, material.twist_rigidity])


def _feet(rest: np.ndarray, hinges: np.ndarray, apex: int) -> tuple[np.ndarray, np.ndarray]:
    """Foot of the apex on the edge as a fraction of it, and height over it [m], each shape (h,)."""
    x0, x1, x2 = rest[hinges[:, 0]], rest[hinges[:, 1]], rest[hinges[:, apex]]
    edge = x1 - x0
    t = np.einsum("ij,ij->i", x2 - x0, edge) / np.einsum("ij,ij->i", edge, edge)
    return t, np.linalg.norm(x2 - x0 - t[:, None] * edge, axis=1)


def _operators(
    rest: np.ndarray, faces: np.ndarray, frames: np.ndarray, hinges: np.ndarray, at: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """R, shape (m, 3 edges, 3 curvatures), and C, shape (m, 3 curvatures, 3 edges), of every triangle.

    If an edge is no hinge (at < 0), the row of R is the curvature across it and the column of C is zero.
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
        own_second = hinges[h, 2] != face[:, k]  # this triangle holds x3 rather than x2
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
    """Q = a C + (1 - a) R^-1 of every triangle: its curvatures from its dihedral angles, shape (m, 3, 3).

    If the six points of a patch lie on a conic, as on some meshes of few triangles, a deflection exists that turns no
    edge, and R has no inverse. There Q = C, which always exists.
    """
    regular = (np.linalg.cond(R) < LARGEST_CONDITION)[:, None, None]
    inverse = np.linalg.inv(np.where(regular, R, np.eye(3)))
    return np.asarray(np.where(regular, angle_sum_part * C + (1.0 - angle_sum_part) * inverse, C))


def maps(
    rest: np.ndarray, topology: Topology, frames: np.ndarray, free: np.ndarray, angle_sum_part: float
) -> CurvatureMaps:
    """Curvatures of every triangle that has a hinge.

    Args:
        rest: Unstrained positions [m], shape (n, 3).
        topology: Topology of the mesh, with h hinges.
        frames: Corners of each triangle in its plane [m], shape (m, 3, 2).
        free: Which hinges carry no moment (seams), shape (h,).
        angle_sum_part: a [-].
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
    """K_T = A_T Q' D Q of every triangle [N m], shape (t, 3, 3).

    Args:
        curved: Curvature maps of the mesh.
        D: From curvatures to moments [N m], shape (3, 3).
    """
    return np.asarray(curved.area[:, None, None] * (curved.Q.transpose(0, 2, 1) @ D @ curved.Q))
