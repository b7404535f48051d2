"""Push: how far the far edge moves when cloth on a table is pushed by its near one; what compression it resists.

Not in the paper. A sheet wrinkles where it is pushed and the far edge stays; a stiffer one slides as a whole. With
friction mu rho g per area, the cloth from the ruler to a far edge that moves is shorter by

    s - p = mu rho g L^2 / (2 c Y)

for a push s after which the edge has moved by p over a length L (the pressure grows evenly from the far edge). The
part c of the stretch stiffness Y that resists compression is what a mesh lacks that is coarser than the wrinkles.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tatamu.garments.towel import staggered_rectangle
from tatamu.material import GRAVITY, Material
from tatamu.rollout import Rollout
from tatamu.scene import Cloth, Gripper, Scene, Table

CELL, COLUMNS = 0.02, 4
"""Edge length of the strip's mesh [m], and its width in cells."""
ROWS = 12
"""The strip has at least so many rows."""
SPEED = 0.02
"""Mean speed of the ruler [m/s]; at 0.05 m/s the cloth quivers and is a fifth less shortened."""
KNOTS = 41
REST = 0.5
"""From the end of the push to the reading [s]."""


@dataclass(frozen=True)
class Push:
    """The test of a cloth pushed along a table."""

    length: float
    """L, of the cloth ahead of the ruler [m]."""
    pushed: float
    """s, how far the ruler was pushed [m]."""
    spacing: float | None = None
    """Edge length of the strip's mesh [m]; None: `CELL`, or less for a short cloth."""
    name: str = "push"

    @cached_property
    def mesh(self) -> tuple[np.ndarray, np.ndarray]:
        """The strip on z = 0, lengthwise from x = 0 [m], shape (n, 3), and its triangles."""
        edge = self.spacing or min(CELL, self.length / (ROWS * np.sqrt(0.75)))
        vertices, faces = staggered_rectangle(COLUMNS * edge, self.length, edge)
        return vertices - [vertices[:, 0].min(), 0.0, vertices[:, 2].min()], faces

    def scene(self, material: Material) -> Scene:
        """The strip on the table, its first row held and pushed."""
        flat, faces = self.mesh
        u = np.linspace(0.0, 1.0, KNOTS)
        seconds = self.pushed / SPEED
        way = np.outer(u * u * (3.0 - 2.0 * u), [self.pushed, 0.0, 0.0])
        held = np.flatnonzero(flat[:, 0] < 1e-9).tolist()
        return Scene(
            cloth=Cloth(vertices=flat + np.array([0.0, 0.0, 0.5 * material.thickness]), faces=faces),
            material=material.model_copy(update={"air_drag": 0.0}),
            table=Table(),
            grippers=[Gripper(vertices=held, times=(seconds * u).tolist(), displacements=way)],
            duration=seconds + REST,
            frame_rate=30.0,
        )

    def reading(self, rollout: Rollout, frame: int = -1) -> float:
        """How far the far edge has moved [m]."""
        return float((rollout.positions[frame] - rollout.positions[0])[self._far, 0].mean())

    @cached_property
    def _far(self) -> np.ndarray:
        along = self.mesh[0][:, 0]
        return along > along.max() - 1e-9

    def guess(self, moved: float, material: Material) -> float:
        """Compression by the formula above."""
        weight = material.friction_table * material.areal_density * GRAVITY
        return weight * self.length**2 / (2.0 * material.stretch_stiffness * max(self.pushed - moved, 1e-4))
