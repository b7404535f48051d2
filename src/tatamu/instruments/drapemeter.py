"""The drapemeter: a disc of cloth over a round plate.

As in the instrument, the specimen lies flat, its middle on a plate level with a table, and the plate rises. The cloth
on the plate does not move, because the scene fixes it there. The scene also fixes half a row beyond the rim, so that
the cloth leaves the plate level. The mesh is a ring of concentric rows. A flat disc has no reason to buckle: small,
seeded unevenness replaces the fabric's own. For more unevenness, the unstrained cloth itself can be wavy.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tatamu.curves import minimum_jerk
from tatamu.instruments.outline import PlanOutline
from tatamu.material import GRAVITY, Material
from tatamu.meshing import ROW, delaunay
from tatamu.rollout import Rollout
from tatamu.scene import Cloth, Gripper, Scene, Table

RISE = 0.1
"""Height by which the plate rises [m]; more than the cloth hangs down."""
RISING = 2.0
"""Time in which the plate rises [s]."""
SETTLING = 2.0
"""Time from the end of the rise to the reading [s]."""
FINENESS = 0.35
"""Spacing of the mesh in bending lengths."""
UNEVENNESS = 0.02
"""Standard deviation of the flat cloth's height, in spacings of the mesh."""
WAVE = 0.02
"""Length of the waves of unstrained cloth that is wavy [m]: its height is correlated as exp(-d² / (2 WAVE²))."""
WAVES = 200
"""Number of waves that are summed."""
KNOTS = 21


@dataclass(frozen=True)
class Drapemeter:
    """A specimen on its plate; both are round."""

    specimen: float
    """Radius of the cloth [m]."""
    plate: float
    """Radius of the plate [m]."""
    spacing: float
    """Edge length of the mesh [m]."""
    seed: int = 0
    """Random seed of the unevenness, and of the rows' first points."""
    waviness: float = 0.0
    """Standard deviation of the height of the unstrained cloth beyond the plate [m]."""

    @classmethod
    def fine_enough(
        cls, specimen: float, plate: float, material: Material, seed: int = 0, waviness: float = 0.0
    ) -> Drapemeter:
        """Return a drapemeter whose mesh is fine enough for the fabric to bend."""
        spacing = min(FINENESS * material.bending_length, 0.2 * (specimen - plate))
        return cls(specimen, plate, spacing, seed, waviness)

    @property
    def rows(self) -> int:
        """Number of free rows of the mesh."""
        return max(4, round((self.specimen - self.plate) / (self.spacing * ROW)))

    @property
    def row(self) -> float:
        """Distance between rows [m]."""
        return (self.specimen - self.plate) / (self.rows + 0.5)

    @cached_property
    def mesh(self) -> tuple[np.ndarray, np.ndarray]:
        """Points of the ring [m], shape (n, 2), the fixed rows first, and its triangles."""
        random = np.random.default_rng(self.seed)
        radii = self.plate + self.row * (np.arange(-1, self.rows + 1) + 0.5)
        rings = [_ring(radius, self.spacing, random.uniform()) for radius in radii]
        points = np.concatenate(rings)
        faces = delaunay(points)
        middle = np.hypot(*points[faces].mean(axis=1).T)
        return points, faces[middle > radii[0]]

    @cached_property
    def held(self) -> np.ndarray:
        """Vertices on the plate, and those half a row beyond its rim."""
        return np.flatnonzero(np.hypot(*self.mesh[0].T) < self.plate + self.row)

    @property
    def unstrained(self) -> np.ndarray:
        """The cloth without strain [m], shape (n, 3): level where it is fixed, and wavy from one wave beyond on."""
        points, _ = self.mesh
        if not self.waviness:
            return np.column_stack([points, np.zeros(len(points))])
        random = np.random.default_rng([self.seed, 2])
        waves = random.standard_normal((2, WAVES)) / WAVE
        phases = random.uniform(0.0, 2.0 * np.pi, WAVES)
        height = self.waviness * np.sqrt(2.0 / WAVES) * np.cos(points @ waves + phases).sum(axis=1)
        beyond = np.hypot(*points.T) - self.plate - self.row
        return np.column_stack([points, np.clip(beyond / WAVE, 0.0, 1.0) * height])

    def scene(self, material: Material) -> Scene:
        """Return a scene in which the plate rises from a table without friction, in air that damps critically."""
        points, faces = self.mesh
        random = np.random.default_rng([self.seed, 1])
        height = UNEVENNESS * self.spacing * np.abs(random.standard_normal(len(points)))
        height[self.held] = 0.0
        flat = np.column_stack([points, 0.5 * material.thickness + height])
        u = np.linspace(0.0, 1.0, KNOTS)
        path = np.outer(minimum_jerk(u), [0.0, 0.0, RISE])
        return Scene(
            cloth=Cloth(vertices=flat, faces=faces, rest_vertices=self.unstrained),
            material=material.model_copy(update={"friction_table": 0.0, "air_drag": self.damping(material)}),
            table=Table(),
            grippers=[Gripper(vertices=self.held.tolist(), times=(RISING * u).tolist(), displacements=path)],
            duration=RISING + SETTLING,
            frame_rate=10.0,
        )

    def damping(self, material: Material) -> float:
        """Return the air drag that damps the overhang critically [N s/m^3], as only the shape at rest is read."""
        free = self.specimen - self.plate
        return float(2.0 * material.areal_density * np.sqrt(1.5 * GRAVITY / free))

    def outline(self, rollout: Rollout, frame: int = -1) -> PlanOutline:
        """Return the outline from above, the plate's axis at the origin."""
        return PlanOutline.of(rollout.positions[frame], rollout.faces, np.zeros(2))


def _ring(radius: float, spacing: float, turn: float) -> np.ndarray:
    """Return evenly spaced points on a circle [m], shape (k, 2), turned by a part of their spacing."""
    count = max(6, round(2.0 * np.pi * radius / spacing))
    angles = 2.0 * np.pi * (np.arange(count) + turn) / count
    return radius * np.column_stack([np.cos(angles), np.sin(angles)])
