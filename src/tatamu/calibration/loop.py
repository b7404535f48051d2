"""Test *loop*: the height of the crease of folded cloth determines the bending rigidity.

This test is not in the paper. It works even for cloth that is too limp for the test *sag*. It gives the bending
rigidity at the large curvature of a fold. This rigidity may differ from the rigidity at a small curvature. Such a
difference exists in real cloth and in Blender's old bending model.

A strip is laid over itself without friction, and its ends are held. The strip then takes the shape of minimum energy,
which is a loop. The height of the loop depends only on the ratio of bending rigidity to weight.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Self

import numpy as np
from pydantic import model_validator

from tatamu.base.errors import InputError
from tatamu.calibration.entry import Errors, TestEntry
from tatamu.calibration.estimate import Estimate
from tatamu.calibration.fit import Fit
from tatamu.calibration.picture import CLOTH, DASH, strip_profile
from tatamu.calibration.quantity import Lengths
from tatamu.calibration.readings import Reading
from tatamu.calibration.target import Target, textbook_spread
from tatamu.calibration.test import ElasticTest, Readings, Specimen, millimetres
from tatamu.garments import Garment
from tatamu.show.drawing import Drawing
from tatamu.simulation.heavy_strip.chain import start
from tatamu.simulation.material import GRAVITY, Material
from tatamu.simulation.mesh.meshing import staggered_rectangle
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Cloth, Gripper, Scene, Table
from tatamu.simulation.settling import settling

HEIGHT, LIFT = 0.906, 1.1
"""Factors in the height of the loop's top above the table: 0.906 l_b + 1.1 thickness.

l_b is the bending length of the cloth. The height was computed with a chain that bends under its own weight
(`heavy_strip.chain`).
"""
LIES = 4.0
"""Length of cloth on either side of the crease, divided by the height of the loop [-].

In a computation with a chain that bends under its own weight (`heavy_strip.chain`), a length of 3.85 heights gives the
same loop as an infinite length.
"""
CELL = 0.2
"""Edge length of the mesh divided by the height of the loop."""
COLUMNS = 6
HELD_ROWS = 2
LAYS = 0.3
"""Duration of the motion that lays the strip's upper end on its lower end, as a fraction of the simulated time."""
RELAXATIONS = 20.0
HIGHEST_LOOP = 0.3
"""Largest height of a fold [m]. A higher fold is refused, because only cardboard, and no cloth, would fold like
this."""


class LoopReadings(TestEntry):
    """Readings of the height of the crease of folded cloth."""

    height: Lengths
    """Height of the top of the loop above the table [m]."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if max(self.height) > HIGHEST_LOOP:
            raise ValueError(
                f"height ({max(self.height):g} m) is more than a fold of cloth stands, {HIGHEST_LOOP:g} m: "
                "was it read in centimetres or millimetres?"
            )
        return self

    def readings(self, errors: Errors) -> dict[str, Reading]:
        """Return the readings by their names; see `TestEntry.readings`."""
        return {
            "height": Reading.of(self.height, errors.length),
        }


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
    title = "Loop: bending rigidity B"
    parameter = "bending_rigidity"
    entry = LoopReadings
    read = "height of the loop"
    words = MappingProxyType({"height": "the height of the loop"})
    reads = MappingProxyType({"height": 1.0})
    instructions = """\
Make a loop (optional): for cloth that hangs straight down in measurement $sag.                    [loop] height
   Fold one layer over itself on the table without pressing it, with parallel edges; of a T-shirt, use the hem of one
   side. Each side should be four times as long as the loop is high. height: distance from the table to the top of the
   loop. Sag and loop together determine bending better than either alone. If they disagree, the cloth bends
   differently in a fold.
"""

    @classmethod
    def of(cls, entry: LoopReadings, specimen: Specimen) -> Self:
        """Return the simulated copy of this measurement; see `CalibrationTest.of`."""
        test = cls(float(np.mean(entry.height)), specimen.base.thickness, specimen.spacing)
        if test.height <= 2.0 * test.thickness:
            raise InputError(
                f"loop: height ({test.height:g} m) must be more than two layers, {2.0 * test.thickness:g} m: was the "
                "loop pressed flat, or is the garment's thickness (of one layer) less?"
            )
        return test

    @classmethod
    def template(cls, garment: Garment) -> str:
        """Return this test's part of an empty measurements file; see `CalibrationTest.template`."""
        return """\
# [loop]                 # optional: cloth folded over itself; tells B too
# height = []            # from the table to the top of the loop
"""

    @property
    def bending_length(self) -> float:
        """Bending length l_b of an ideal strip whose loop has the measured height [m]."""
        return max(self.height - LIFT * self.thickness, 0.1 * self.height) / HEIGHT

    @property
    def edge(self) -> float:
        """Edge length of the mesh [m]. Triangles must be larger than the thickness of the cloth."""
        return self.spacing or max(CELL * self.height, 2.0 * self.thickness)

    @cached_property
    def mesh(self) -> tuple[np.ndarray, np.ndarray]:
        """Points of the unfolded strip [m], shape (n, 3), and its triangles.

        The length of the strip is along x, from x = 0.
        """
        row = np.sqrt(0.75) * self.edge
        rows = 2 * int(np.ceil(LIES * self.height / row)) + 2 * HELD_ROWS
        vertices, faces = staggered_rectangle(COLUMNS * self.edge, rows * row, self.edge)
        return vertices - [vertices[:, 0].min(), 0.0, 0.0], faces

    def scene(self, material: Material) -> Scene:
        """Return the scene of this test: a wide loop whose upper end is laid onto its lower end.

        The loop then comes to rest.
        """
        flat, faces = self.mesh
        row = np.sqrt(0.75) * self.edge
        length = float(flat[:, 0].max())
        chain = start(length, self.bending_length, material.thickness)
        arc = np.linspace(0.0, length, len(chain))
        x, z = (np.interp(flat[:, 0], arc, chain[:, k]) for k in (0, 1))
        ends = [flat[:, 0] < (HELD_ROWS - 0.5) * row, flat[:, 0] > length - (HELD_ROWS - 0.5) * row]
        lower, upper = (np.flatnonzero(end).tolist() for end in ends)
        down = 1.5 * material.thickness - float(z[ends[1]].mean())
        rate = float(np.sqrt(GRAVITY / self.bending_length))
        duration = RELAXATIONS / rate
        plain = settling(material, rate).model_copy(update={"friction_table": 0.0, "friction_cloth": 0.0})
        return Scene(
            cloth=Cloth(vertices=np.column_stack([x, flat[:, 1], z]), faces=faces, rest_vertices=flat),
            material=plain,
            table=Table(),
            grippers=[
                Gripper(vertices=lower, times=[0.0], displacements=np.zeros((1, 3))),
                Gripper(
                    vertices=upper, times=[0.0, LAYS * duration], displacements=np.array([[0, 0, 0], [0, 0, down]])
                ),
            ],
            duration=duration,
            frame_rate=30.0,
        )

    def reading(self, rollout: Rollout, frame: int = -1) -> float:
        """Return the simulated height of the loop's top above the table [m]."""
        return self.height_of(rollout.positions[frame])

    def height_of(self, positions: np.ndarray) -> float:
        """Return the height of the loop's top [m], from the positions of all n vertices [m], shape (n, 3).

        This height is the mean height of the highest row of vertices.
        """
        rows = np.unique(self.mesh[0][:, 0].round(6), return_inverse=True)[1]
        return float((np.bincount(rows, positions[:, 2]) / np.bincount(rows)).max()) + 0.5 * self.thickness

    def guess(self, height: float, material: Material) -> float:
        """Return the bending rigidity of an ideal strip with a loop of this height: rho g l_b^3 [N m].

        rho is the areal density [kg/m^2], g the acceleration of gravity, and l_b the bending length [m].
        """
        return material.areal_density * GRAVITY * (max(height - LIFT * self.thickness, 0.1 * height) / HEIGHT) ** 3

    def target(self, readings: Readings) -> Target:
        """Return what the simulated reading must reach; see `RestTest.target`."""
        height = readings["height"]
        layers = 2.0 * self.thickness
        return Target(
            test=self,
            parameter=self.parameter,
            measured=height.value,
            uncertainty=height.uncertainty,
            bound="at most" if height.value - height.uncertainty < layers else None,
            guess=self.guess,
            straight=lambda value: float(np.log(max(value - 0.5 * layers, 1e-4))),
            rising=True,
            spread=textbook_spread(self.guess, height),
        )

    def advice(self, estimate: Estimate, fit: Fit) -> list[str]:
        """Return advice on this test; see `CalibrationTest.advice`."""
        if fit.bound is None:
            return []
        return [
            f"loop: {millimetres(fit.measured)} is as low as two layers: the cloth has no loop that a ruler could "
            f"read, B is at most {1e6 * estimate.material.bending_rigidity:.2g} µN m."
        ]

    def drawing(self, shape: np.ndarray | None) -> str:
        """Draw the strip that is folded over itself, as seen from the side."""
        if shape is None:
            return ""
        side = strip_profile(self.mesh[0][:, 0], shape)
        height = self.height_of(shape)
        reach = side[:, 0].max()
        side = side[side[:, 0] > reach - 3.2 * height]
        left = side[:, 0].min()
        corners = [[left, 0.0], [reach + 0.9 * height, 1.15 * height]]
        drawing = Drawing.around(np.concatenate([side, corners]), 320.0, 220.0)
        table = np.array([[left, 0.0], [reach + 0.9 * height, 0.0]])
        drawing.line(table, "muted", 3.0)
        half = side[:, 0].argmax()
        for part in (side[: half + 1], side[half:]):
            drawing.line(part, CLOTH, max(2.0, self.thickness * drawing.scale * 0.8))
        read = reach + 0.35 * height
        drawing.line(np.array([[side[side[:, 1].argmax(), 0], height], [read, height]]), "muted", 1.0, dash=DASH)
        drawing.dimension(np.array([read, 0.0]), np.array([read, height]), "height")
        return drawing.svg()
