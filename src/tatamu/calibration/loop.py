"""Test *loop*: the height of the crease of folded cloth determines the bending rigidity.

It works even for cloth that is too limp for the test *sag*, and gives the bending rigidity at the large curvature of a
fold, which may differ from that at a small curvature in real cloth and in Blender's old bending model.

A strip is laid over itself without friction, and its ends are held. The height of the loop of minimum energy depends
only on the ratio of bending rigidity to weight.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Self

import numpy as np
from pydantic import model_validator

from tatamu.base.errors import InputError
from tatamu.calibration.readings import Lengths, TestEntry
from tatamu.calibration.test import CLOTH, ElasticTest, Specimen, dash, strip_profile
from tatamu.show.drawing import Drawing
from tatamu.simulation.material import GRAVITY, Material, settling
from tatamu.simulation.mesh.meshing import staggered_rectangle
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Cloth, Gripper, Scene, Table

HEIGHT, LIFT = 0.906, 1.1
"""Factors in the height of the loop's top above the table, 0.906 l_b + 1.1 thickness (`tests/physics/chain.py`)."""
HELD_ROWS = 2
LINKS = 200


class LoopReadings(TestEntry):
    """Readings of the height of the crease of folded cloth."""

    taken: ClassVar = {"height": ("height", "length")}

    height: Lengths
    """Height of the top of the loop above the table [m]."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if max(self.height) > 0.3:
            raise ValueError(
                f"height ({max(self.height):g} m) must be at most 0.3 m, because no fold of cloth stands "
                "higher; check that the height is in metres"
            )
        return self


@dataclass(frozen=True)
class Loop(ElasticTest):
    """The test of a strip that is folded over itself."""

    height: float
    """The measured height [m]. It determines the length of the simulated strip."""
    thickness: float
    """Thickness of the cloth [m]."""
    spacing: float | None = None
    """Edge length of the strip's mesh [m]; None for a fixed fraction of the height."""

    name = "loop"
    parameter = "bending_rigidity"
    entry = LoopReadings
    reads: ClassVar = {"height": 1.0}
    rising = True

    @classmethod
    def of(cls, entry: LoopReadings, specimen: Specimen) -> Self:
        test = cls(float(np.mean(entry.height)), specimen.base.thickness, specimen.spacing)
        if test.height <= 2.0 * test.thickness:
            raise InputError(
                f"loop: height ({test.height:g} m) must exceed the thickness of two layers ({2.0 * test.thickness:g} "
                "m); check that `thickness` is for one layer"
            )
        return test

    @property
    def bending_length(self) -> float:
        """Bending length l_b of an ideal strip whose loop has the measured height [m]."""
        return max(self.height - LIFT * self.thickness, 0.1 * self.height) / HEIGHT

    @property
    def edge(self) -> float:
        """Edge length of the mesh [m]. Triangles must be larger than the thickness of the cloth."""
        return self.spacing or max(0.2 * self.height, 2.0 * self.thickness)

    @cached_property
    def mesh(self) -> tuple[np.ndarray, np.ndarray]:
        """Points of the unfolded strip [m], shape (n, 3), along x from x = 0, and its triangles."""
        row = np.sqrt(0.75) * self.edge
        # 3.85 heights of the loop on either side of the crease act like infinite length
        rows = 2 * int(np.ceil(4.0 * self.height / row)) + 2 * HELD_ROWS
        vertices, faces = staggered_rectangle(6 * self.edge, rows * row, self.edge)
        return vertices - [vertices[:, 0].min(), 0.0, 0.0], faces

    def scene(self, material: Material) -> Scene:
        flat, faces = self.mesh
        row = np.sqrt(0.75) * self.edge
        length = float(flat[:, 0].max())
        chain = wide_loop(length, self.bending_length, material.thickness)
        arc = np.linspace(0.0, length, len(chain))
        x, z = (np.interp(flat[:, 0], arc, chain[:, k]) for k in (0, 1))
        ends = [flat[:, 0] < (HELD_ROWS - 0.5) * row, flat[:, 0] > length - (HELD_ROWS - 0.5) * row]
        lower, upper = (np.flatnonzero(end).tolist() for end in ends)
        down = 1.5 * material.thickness - float(z[ends[1]].mean())
        rate = float(np.sqrt(GRAVITY / self.bending_length))
        duration = 20.0 / rate  # until the slowest motion has died out
        plain = settling(material, rate).model_copy(update={"friction_table": 0.0, "friction_cloth": 0.0})
        return Scene(
            cloth=Cloth(vertices=np.column_stack([x, flat[:, 1], z]), faces=faces, rest_vertices=flat),
            material=plain,
            table=Table(),
            grippers=[
                Gripper(vertices=lower, times=[0.0], displacements=np.zeros((1, 3))),
                Gripper(vertices=upper, times=[0.0, 0.3 * duration], displacements=np.array([[0, 0, 0], [0, 0, down]])),
            ],
            duration=duration,
            frame_rate=30.0,
        )

    def reading(self, rollout: Rollout, frame: int = -1) -> float:
        return self.height_of(rollout.positions[frame])

    def height_of(self, positions: np.ndarray) -> float:
        """Return the mean height of the highest row of vertices [m]."""
        rows = np.unique(self.mesh[0][:, 0].round(6), return_inverse=True)[1]
        return float((np.bincount(rows, positions[:, 2]) / np.bincount(rows)).max()) + 0.5 * self.thickness

    def guess(self, height: float, material: Material) -> float:
        return material.areal_density * GRAVITY * (max(height - LIFT * self.thickness, 0.1 * height) / HEIGHT) ** 3

    def bound(self, measured: float, error: float) -> str | None:
        return "at most" if measured - error < 2.0 * self.thickness else None

    def straight(self, reading: float) -> float:
        return float(np.log(max(reading - self.thickness, 1e-4)))

    def drawing(self, shape: np.ndarray) -> str:
        side = strip_profile(self.mesh[0][:, 0], shape)
        height = self.height_of(shape)
        reach = side[:, 0].max()
        side = side[side[:, 0] > reach - 3.2 * height]
        left, right = side[:, 0].min(), reach + 0.9 * height
        drawing = Drawing.around(np.concatenate([side, [(left, 0.0), (right, 1.15 * height)]]), 320.0, 220.0)
        drawing.line([(left, 0.0), (right, 0.0)], "muted", 3.0)
        half = side[:, 0].argmax()
        for part in (side[: half + 1], side[half:]):
            drawing.line(part, CLOTH, max(2.0, self.thickness * drawing.scale * 0.8))
        read = reach + 0.35 * height
        dash(drawing, [(side[side[:, 1].argmax(), 0], height), (read, height)])
        drawing.dimension((read, 0.0), (read, height), "height")
        return drawing.svg()


def wide_loop(length: float, bending_length: float, thickness: float) -> np.ndarray:
    """Return the nodes of a half circle between two level parts, x and z [m], shape (LINKS + 1, 2)."""
    link = length / bending_length / LINKS
    total = LINKS * link
    radius = min(1.0, 0.2 * total)
    slope = np.clip(((np.arange(LINKS) + 0.5) * link - (total - np.pi * radius) / 2) / radius, 0.0, np.pi)
    x, z = (np.concatenate([[0.0], np.cumsum(link * part)]) for part in (np.cos(slope), np.sin(slope)))
    return np.column_stack([x, z]) * bending_length + np.array([0.0, thickness / 2])
