"""Elastic constants of a sheet of Blender's springs and hinges, as functions of the direction.

k is the spring constant of every edge [N/m], A the area of the cloth, L the rest length of an edge and n its direction.
H_a and H_b are the heights of the two triangles over a shared edge, and theta is the angle between them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from tatamu.simulation.mesh.topology import Topology, areas, edge_lengths
from tatamu.simulation.scene import Cloth

DIRECTIONS = np.linspace(0.0, np.pi, 24, endpoint=False)
"""Directions over which elastic constants are averaged, as angles [rad], shape (d,)."""


class Springs:
    """The springs and hinges that Blender builds from a mesh of triangles."""

    def __init__(self, cloth: Cloth) -> None:
        self.rest = cloth.rest
        self.faces = cloth.faces
        self.topology = Topology(cloth.faces)
        self.area = float(areas(self.rest, self.faces).sum())
        self.lengths = edge_lengths(self.rest, self.topology.edges)

    @cached_property
    def _directions(self) -> np.ndarray:
        """Sides of each triangle in its plane [m], shape (m, 3, 2), with the same axes everywhere in flat cloth.

        The first axis is the scene's x, or y if the plane is nearly normal to x, projected into the plane.
        """
        corners = self.rest[self.faces]
        sides = corners[:, [2, 0, 1]] - corners[:, [1, 2, 0]]
        normals = np.cross(sides[:, 0], sides[:, 1])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        axis = np.where(np.abs(normals[:, :1]) > 0.9, [[0.0, 1.0, 0.0]], [[1.0, 0.0, 0.0]])
        first = axis - (axis * normals).sum(1, keepdims=True) * normals
        first /= np.linalg.norm(first, axis=1, keepdims=True)
        second = np.cross(normals, first)
        second *= np.where(second.sum(1, keepdims=True) < 0.0, -1.0, 1.0)
        return np.stack([np.einsum("mkx,mx->mk", sides, frame) for frame in (first, second)], axis=2)

    @cached_property
    def tensor(self) -> np.ndarray:
        """C/k = (1/A) sum L^2 nn (x) nn over all edges, with C for the strains (xx, yy, xy), shape (3, 3)."""
        weight = 1.0 / self.topology.faces_per_edge[self.topology.face_edges]
        x, y = self._directions[:, :, 0], self._directions[:, :, 1]
        strain = np.stack([x * x, y * y, x * y])
        return np.einsum("amk,bmk,mk->ab", strain, strain, weight / (x * x + y * y)) / self.area

    @property
    def moduli(self) -> np.ndarray:
        """Ratio Y/k of the tensile stiffness Y of a strip to the spring constant, shape (d,)."""
        c, s = np.cos(DIRECTIONS), np.sin(DIRECTIONS)
        stress = np.stack([c * c, s * s, c * s])
        return 1.0 / np.einsum("ad,ab,bd->d", stress, np.linalg.inv(self.tensor), stress)

    @cached_property
    def _hinges(self) -> Hinges:
        hinges = self.topology.hinges
        a, b, c, d = (self.rest[hinges[:, k]] for k in range(4))
        along = b - a
        length = np.linalg.norm(along, axis=1)
        feet = [np.einsum("hx,hx->h", p - a, along) / length for p in (c, d)]
        heights = [np.linalg.norm(np.cross(along, p - a), axis=1) / length for p in (c, d)]
        return Hinges(hinges, length, np.array(feet), np.array(heights))

    @property
    def rigidities(self) -> np.ndarray:
        """Ratio B/b of the bending rigidity B to Blender's bending stiffness b, shape (d,).

        Blender pushes each vertex opposite an edge with the force b L theta / 30 (measured: docs/theory/blender.md), so
        a hinge has the stiffness b L (H_a + H_b) / 60. B follows from the energy per area of a sheet bent to a
        cylinder.
        """
        hinges = self._hinges
        angles = np.zeros(len(self.topology.edges))  # from the first axis of one of the triangles at each edge [rad]
        angles[self.topology.face_edges] = np.arctan2(self._directions[:, :, 1], self._directions[:, :, 0])
        inner = angles[self.topology.faces_per_edge == 2]
        theta = np.stack([hinges.angle(direction - inner) for direction in DIRECTIONS], axis=1)
        height = hinges.heights.mean(0)
        energy = (hinges.length * height / 30.0) @ theta**2
        return np.asarray(energy / max((hinges.length * height / 1.5).sum() / 2.0, 1e-30))

    def bending_frequency(self) -> float:
        """Return the maximum angular frequency of the hinges [1/Blender's time] if b and all masses are 1.

        The force b L theta / 30 acts on each vertex opposite an edge, and the opposite force on each end of the edge.
        """
        hinges = self._hinges
        if not len(hinges.length):
            return 0.0
        push = np.array([1.0, 1.0, -1.0, -1.0]) * hinges.length[:, None] / 30.0
        rows, columns = np.arange(len(push)).repeat(4), hinges.vertices.ravel()
        shape = (len(push), len(self.rest))
        theta = sparse.csr_array((-hinges.coefficients.ravel(), (rows, columns)), shape=shape)
        force = sparse.csr_array((push.ravel(), (rows, columns)), shape=shape).T.tocsr()
        vector, value = np.cos(1.7 * np.arange(len(self.rest)) ** 1.3), 0.0
        for _ in range(200):  # power iteration finds the maximum eigenvalue of the product of both matrices
            vector /= np.linalg.norm(vector)
            vector = force @ (theta @ vector)
            value = float(np.linalg.norm(vector))
        return float(np.sqrt(value))


@dataclass(frozen=True)
class Hinges:
    """The h inner edges, each from (0, 0) to (L, 0) in a plane with both of its triangles."""

    vertices: np.ndarray
    """Both ends of each edge and the two vertices opposite it, shape (h, 4)."""
    length: np.ndarray
    """Length L of each edge [m], shape (h,)."""
    feet: np.ndarray
    """Distances along the edge from its start to the foot of each opposite vertex [m], shape (2, h)."""
    heights: np.ndarray
    """Heights H_a and H_b of the opposite vertices over the edge [m], shape (2, h)."""

    @property
    def coefficients(self) -> np.ndarray:
        """Derivatives of theta with respect to the heights of the four vertices over the plane [1/m], shape (h, 4)."""
        share, inverse = self.feet / self.length, 1.0 / self.heights
        first, second = ((1.0 - share) * inverse).sum(0), (share * inverse).sum(0)
        return np.stack([-first, -second, inverse[0], inverse[1]], axis=1)

    def angle(self, direction: np.ndarray) -> np.ndarray:
        """Return theta of each hinge on a cylinder with the curvature 1/m [rad], shape (h,).

        `direction` is the angle from each edge to the direction in which the cylinder is curved [rad], shape (h,).
        """
        zero = np.zeros_like(self.length)
        along = np.stack([zero, self.length, self.feet[0], self.feet[1]], axis=1)
        aside = np.stack([zero, zero, self.heights[0], -self.heights[1]], axis=1)
        elevation = 0.5 * (along * np.cos(direction)[:, None] + aside * np.sin(direction)[:, None]) ** 2
        return np.asarray((self.coefficients * elevation).sum(1))
