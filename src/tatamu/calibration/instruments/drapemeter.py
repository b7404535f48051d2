"""Makes the scene of a drapemeter, an instrument in which a disc of cloth hangs over a round plate.

At first, the specimen lies flat. Its middle is on the plate, and the rest is on a table at the same height. Then the
plate rises. The scene fixes the cloth on the plate. It also fixes half a row of the mesh outside the plate's rim, so
the cloth is level where it leaves the plate.

The mesh is a ring of concentric rows. A perfectly flat disc would not buckle. Therefore small random heights are added,
which represent the unevenness of real fabric.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tatamu.base.curves import minimum_jerk
from tatamu.simulation.material import GRAVITY, Material
from tatamu.simulation.mesh.meshing import ROW, delaunay
from tatamu.simulation.scene import Cloth, Gripper, Scene, Table

RISING = 2.0
"""Time in which the plate rises [s]."""


@dataclass(frozen=True)
class Drapemeter:
    """A round specimen of cloth on a round plate."""

    specimen: float
    """Radius of the cloth [m]."""
    plate: float
    """Radius of the plate [m]."""
    spacing: float
    """Edge length of the mesh [m]."""
    seed: int = 0
    """Random seed of the unevenness, and of the angles at which the rows of the mesh begin."""

    @property
    def rows(self) -> int:
        """Number of rows of the mesh that are not fixed."""
        return max(4, round((self.specimen - self.plate) / (self.spacing * ROW)))

    @property
    def row(self) -> float:
        """Distance between two neighbouring rows of the mesh [m]."""
        return (self.specimen - self.plate) / (self.rows + 0.5)

    @cached_property
    def mesh(self) -> tuple[np.ndarray, np.ndarray]:
        """Points of the ring-shaped mesh [m], shape (n, 2), and its triangles. The points of fixed rows come first."""
        random = np.random.default_rng(self.seed)
        radii = self.plate + self.row * (np.arange(-1, self.rows + 1) + 0.5)
        rings = [_ring(radius, self.spacing, random.uniform()) for radius in radii]
        points = np.concatenate(rings)
        faces = delaunay(points)
        middle = np.hypot(*points[faces].mean(axis=1).T)
        return points, faces[middle > radii[0]]

    @cached_property
    def held(self) -> np.ndarray:
        """Numbers of the fixed vertices, which are on the plate and half a row outside its rim."""
        return np.flatnonzero(np.hypot(*self.mesh[0].T) < self.plate + self.row)

    @property
    def unstrained(self) -> np.ndarray:
        """Positions of the vertices in unstrained cloth [m], shape (n, 3). The fixed part is level."""
        points, _ = self.mesh
        return np.column_stack([points, np.zeros(len(points))])

    def scene(self, material: Material) -> Scene:
        """Return a scene in which the plate rises. The table has no friction, and the air's damping is critical."""
        points, faces = self.mesh
        random = np.random.default_rng([self.seed, 1])
        height = 0.02 * self.spacing * np.abs(random.standard_normal(len(points)))
        height[self.held] = 0.0
        flat = np.column_stack([points, 0.5 * material.thickness + height])
        u = np.linspace(0.0, 1.0, 21)
        path = np.outer(minimum_jerk(u), [0.0, 0.0, 0.1])  # farther than the cloth hangs down
        # such a large drag does no harm, because only the shape at rest is read
        drag = float(2.0 * material.areal_density * np.sqrt(1.5 * GRAVITY / (self.specimen - self.plate)))
        return Scene(
            cloth=Cloth(vertices=flat, faces=faces, rest_vertices=self.unstrained),
            material=material.model_copy(update={"friction_table": 0.0, "air_drag": drag}),
            table=Table(),
            grippers=[Gripper(vertices=self.held.tolist(), times=(RISING * u).tolist(), displacements=path)],
            duration=RISING + 2.0,
            frame_rate=10.0,
        )


def _ring(radius: float, spacing: float, turn: float) -> np.ndarray:
    """Return points at equal distances on a circle [m], shape (k, 2).

    The points are rotated by the fraction `turn` of the angle between two points.
    """
    count = max(6, round(2.0 * np.pi * radius / spacing))
    angles = 2.0 * np.pi * (np.arange(count) + turn) / count
    return radius * np.column_stack([np.cos(angles), np.sin(angles)])
