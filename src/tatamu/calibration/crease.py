"""Test *crease*: the angle of a fold that remains in pressed cloth determines the friction of bending.

A band of cloth is the hinge of two light boards, like the spine of a book, which is closed under a weight and released.
It keeps the curvature at which the friction of bending HB balances the moment B k (docs/theory/hysteresis.md), so that
a small remaining angle is about HB / B * gap.

Without boards, cloth also bends outside its crease while it opens, and by how much depends on the way in which it is
released. The hinge stands upright, so the simulation has no gravity.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Self

import numpy as np
from pydantic import model_validator

from tatamu.calibration.estimate import Fit
from tatamu.calibration.readings import Angles, Errors, Length, Reading, TestEntry, uncertainty
from tatamu.calibration.test import CLOTH, ElasticTest, Specimen, dash, strip_profile
from tatamu.show.drawing import Drawing
from tatamu.simulation.material import GRAVITY, Material, settling
from tatamu.simulation.mesh.meshing import ROW, staggered_rectangle
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Cloth, Gripper, Scene

ARM = 0.03
"""Radius of the arc as which the remaining angle is read [m], because the readings of elastic tests are lengths."""
CELLS = 12
"""Mesh rows between the held ends. The cloth also bends over half a row at each end, so the gap is 13 rows."""
HELD_ROWS = 2
MIN_GAP = 1.5
"""Minimum length of the band, in thicknesses of both boards, around which the band goes."""


class CreaseReadings(TestEntry):
    """Readings of a hinge of cloth between two boards, which was closed under a weight and released."""

    gap: Length
    """Length of cloth between the boards [m]."""
    board: Length
    """Thickness of one board [m]."""
    angle: Angles
    """Angle by which the hinge remains bent [degrees]; 0 if the boards lie in one plane."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        least = 2.0 * MIN_GAP * self.board
        if not least <= self.gap <= 0.1:
            raise ValueError(
                f"gap must be from {least:g} to 0.1 m, given {self.gap:g} m; the minimum is {2.0 * MIN_GAP:g} times "
                "the thickness of a board"
            )
        return self

    def readings(self, errors: Errors) -> dict[str, Reading]:
        per_degree = ARM * np.pi / 180.0
        error = uncertainty(self.angle, errors.angle)
        return {"angle": Reading(per_degree * float(np.mean(self.angle)), per_degree * error, len(self.angle))}


@dataclass(frozen=True)
class PressedCrease(ElasticTest):
    """The test of a hinge of cloth that is closed under a weight and released."""

    gap: float
    """Length of the band of cloth between the two boards [m]."""
    apart: float
    """Distance between the band's ends while the hinge is closed [m]."""
    usual: float
    """Bending length of the garment's material before the calibration [m], for the first guess."""

    name = "crease"
    parameter = "bending_hysteresis"
    entry = CreaseReadings
    needs = ("sag",)
    asks = "hysteresis"
    reads: ClassVar = {"angle": 1.0}
    rising = True
    weighs = False

    @classmethod
    def of(cls, entry: CreaseReadings, specimen: Specimen) -> Self:
        return cls(entry.gap, 2.0 * entry.board + specimen.base.thickness, specimen.base.bending_length)

    @cached_property
    def mesh(self) -> tuple[np.ndarray, np.ndarray]:
        """Mesh of the unfolded band: points [m], shape (n, 3), and triangles. The length of the band is along x."""
        row = self.gap / (CELLS + 1)
        edge = row / ROW
        return staggered_rectangle(6 * edge, (CELLS + 2 * HELD_ROWS) * row, edge)

    @cached_property
    def _rows(self) -> np.ndarray:
        """Index of the mesh row to which each of the n vertices belongs, shape (n,)."""
        return np.asarray(np.unique(self.mesh[0][:, 0].round(9), return_inverse=True)[1])

    def _folded(self) -> np.ndarray:
        """Return the band as a half circle between two level ends [m], shape (n, 3)."""
        flat, _ = self.mesh
        links = CELLS + 2 * HELD_ROWS
        row = np.ptp(flat[:, 0]) / links
        slope = np.pi * np.clip((np.arange(links) + 0.5 - HELD_ROWS) / CELLS, 0.0, 1.0)
        x, z = (np.concatenate([[0.0], np.cumsum(row * part)]) for part in (np.cos(slope), np.sin(slope)))
        return np.column_stack([x[self._rows], flat[:, 1], z[self._rows]])

    def scene(self, material: Material) -> Scene:
        flat, faces = self.mesh
        folded = self._folded()
        last = int(self._rows.max())
        lower, upper = self._rows <= HELD_ROWS, self._rows >= last - HELD_ROWS
        down = self.apart - float(np.ptp(folded[:, 2]))
        # the lowest angular frequency of a strip that is clamped at one end
        rate = 3.52 * float(np.sqrt(material.bending_rigidity / material.areal_density)) / self.gap**2
        thin = min(material.thickness, 0.25 * self.gap / (CELLS + 1))  # so that the layers do not touch
        return Scene(
            cloth=Cloth(vertices=folded, faces=faces, rest_vertices=flat),
            material=settling(material, rate).model_copy(update={"thickness": thin}),
            grippers=[
                Gripper(vertices=np.flatnonzero(lower).tolist(), times=[0.0], displacements=np.zeros((1, 3))),
                Gripper(
                    vertices=np.flatnonzero(upper).tolist(),
                    times=[0.0, 10.0 / rate],  # closed
                    displacements=np.array([[0, 0, 0], [0, 0, down]]),
                    opens=15.0 / rate,  # released
                ),
            ],
            gravity=0.0,
            duration=40.0 / rate,  # at rest
            frame_rate=rate,
        )

    def reading(self, rollout: Rollout, frame: int = -1) -> float:
        return ARM * self.angle_of(rollout.positions[frame])

    def angle_of(self, positions: np.ndarray) -> float:
        """Return the direction of the band's free end relative to the flat band [rad]."""
        before, end = self.side(positions)[-2:]
        along, up = end - before
        return float(np.arctan2(up, along))

    def side(self, positions: np.ndarray) -> np.ndarray:
        """Return the band as seen from the side: the mean position of each mesh row [m], shape (rows, 2)."""
        return strip_profile(self.mesh[0][:, 0], positions)

    def guess(self, arc: float, material: Material) -> float:
        return arc / ARM / self.gap * material.areal_density * GRAVITY * self.usual**3

    def bound(self, measured: float, error: float) -> str | None:
        widest = ARM * np.radians(120.0)  # a larger angle only bounds the friction of bending
        return "at most" if measured < error else "at least" if measured > widest else None

    def sentence(self, fit: Fit) -> str:
        measured, error, simulated = (
            float(np.degrees(arc / ARM)) for arc in (fit.measured, fit.uncertainty, fit.simulated)
        )
        return f"Remaining angle: measured {measured:.1f} ± {error:.1f}°, simulated {simulated:.1f}°."

    def drawing(self, shape: np.ndarray) -> str:
        side = self.side(shape)
        board = 2.0 * self.gap
        first, last = (side[near] - side[next_] for near, next_ in ((0, 1), (-1, -2)))
        middle = side[-1]
        outer = [at + board * way / np.linalg.norm(way) for at, way in ((side[0], first), (middle, last))]
        flat = middle - board * first / np.linalg.norm(first)
        drawing = Drawing.around(np.concatenate([side, outer, [flat - [0.0, 0.2 * board]]]), 320.0, 200.0)
        dash(drawing, [middle - [self.gap, 0.0], flat])
        for at, far in zip((side[0], middle), outer, strict=True):
            drawing.line([at, far], "muted", 7.0)
        drawing.line(side, CLOTH, 3.5)
        turn = np.linspace(0.0, self.angle_of(shape), 24)
        drawing.line(middle + 0.8 * board * np.column_stack([np.cos(turn), np.sin(turn)]), "reading", 1.2)
        half = 0.5 * turn[-1]
        drawing.label(middle + 0.95 * board * np.array([np.cos(half), np.sin(half)]), "angle", "reading")
        drawing.label(0.5 * (side[0] + middle) - [0.0, 0.25 * board], "gap", "ink")
        return drawing.svg()
