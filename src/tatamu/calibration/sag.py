"""Sag (paper, section IV-C): how far cloth in front of a straight grip hangs down.

The grip is level, parallel to the edge and as wide as the cloth in front of it, so that this cloth is a strip clamped
at one end: its sag depends on bending over weight alone, and on nothing behind the grip. A mesh bends behind its last
held row too, so that row stands half a cell behind the front of the grip (docs/validation.md, `clamp`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tatamu.calibration.settling import settling
from tatamu.garments.towel import staggered_rectangle
from tatamu.heavy_strip.cantilever import tip
from tatamu.material import GRAVITY, Material
from tatamu.rollout import Rollout
from tatamu.scene import Cloth, Gripper, Scene

CELLS = 12
"""Rows of the mesh in front of the grip."""
FEWEST, MOST = 3, 24
HELD_ROWS = 3
COLUMNS, WIDE_COLUMNS = 8, 12
"""Columns of the mesh, and of one whose spacing is given: some simulators give border vertices the mass of inner ones,
so that a narrow strip would weigh more than the garment it stands for."""
THIN = 0.25
"""Largest thickness of the strip over its shortest edge."""
RELAXATIONS = 16.0
GAMMAS = np.geomspace(1e-2, 1e3, 101)
"""Range of weight over bending, Gamma = rho g d^3 / B, in which a ruler could tell."""


@dataclass(frozen=True)
class Sag:
    """The sag test: a strip of free length d in front of a level grip."""

    free_length: float
    """d: from the front of the grip to the edge [m]."""
    spacing: float | None = None
    """Edge length of the strip's mesh [m]; None: so that it has `CELLS` rows."""
    name: str = "sag"

    @cached_property
    def mesh(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Points of the strip [m], shape (n, 3), edge at x = 0 and grip at larger x; triangles; held vertices."""
        wanted = CELLS if self.spacing is None else self.free_length / (np.sqrt(0.75) * self.spacing) - 0.5
        cells = int(np.clip(round(wanted), FEWEST, MOST))
        row = self.free_length / (cells + 0.5)
        rows = cells + HELD_ROWS
        rows += rows % 2
        columns = COLUMNS if self.spacing is None else WIDE_COLUMNS
        edge = row / np.sqrt(0.75)
        vertices, faces = staggered_rectangle(columns * edge, rows * row, edge)
        # the mesh has rows of its own choice: stretch it so that its rows stand `row` apart
        own = np.unique(vertices[:, 0].round(9))
        along = np.searchsorted(own, vertices[:, 0].round(9))
        vertices[:, 0] = along * row
        return vertices, faces, np.flatnonzero(along >= cells)

    def scene(self, material: Material) -> Scene:
        """The strip starts level and settles."""
        vertices, faces, held = self.mesh
        gamma = self.gamma(material)
        rate = float(max(3.52 / np.sqrt(gamma), 1.2) * np.sqrt(GRAVITY / self.free_length))
        return Scene(
            cloth=Cloth(vertices=vertices, faces=faces),
            material=settling(material, rate).model_copy(update={"thickness": self._thin(material)}),
            grippers=[Gripper(vertices=held.tolist(), times=[0.0], displacements=np.zeros((1, 3)))],
            duration=RELAXATIONS / rate,
            frame_rate=30.0,
        )

    def _thin(self, material: Material) -> float:
        """A thickness that keeps neighbouring triangles from touching; the strip touches nothing else."""
        vertices, faces, _ = self.mesh
        shortest = float(np.linalg.norm(vertices[faces] - vertices[np.roll(faces, 1, axis=1)], axis=2).min())
        return min(material.thickness, THIN * shortest)

    def reading(self, rollout: Rollout, frame: int = -1) -> float:
        """The sag of a rollout [m]: below the grip, of the edge's mean."""
        return float(-rollout.positions[frame, self.mesh[0][:, 0] < 1e-9, 2].mean())

    def gamma(self, material: Material) -> float:
        """Gamma = rho g d^3 / B."""
        return material.areal_density * GRAVITY * self.free_length**3 / max(material.bending_rigidity, 1e-12)

    def guess(self, sag: float, density: float) -> float:
        """Bending rigidity of an ideal strip of this sag, by the heavy elastica [N m]."""
        return density * GRAVITY * self.free_length**3 / gamma_of(sag / self.free_length)


def gamma_of(share: float) -> float:
    """Gamma of a cantilever whose sag is this share of its length, within `GAMMAS`."""
    return float(np.exp(np.interp(share, [tip(gamma)[1] for gamma in GAMMAS], np.log(GAMMAS))))
