"""Test *sag* (paper, section IV-C): how far cloth in front of a straight grip hangs down.

The grip is as wide as the cloth in front of it, so this cloth is a strip that is clamped at one end. The ratio of sag
to length depends only on Gamma = rho g d^3 / B, with the free length d.

A mesh also bends behind its foremost held row, over half a cell. This row is therefore half a cell in front of the
grip, so that the bending starts at the front of the grip (docs/reference/checks.md, `clamp`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np
from pydantic import model_validator
from scipy.special import logit

from tatamu.base.curves import length
from tatamu.base.errors import InputError
from tatamu.calibration.elongation import longest_edge, named_edge
from tatamu.calibration.estimate import Estimate
from tatamu.calibration.loop import HEIGHT, LIFT
from tatamu.calibration.readings import Lengths, TestEntry
from tatamu.calibration.test import CLOTH, ElasticTest, Readings, Specimen, Target, dash, strip_profile, textbook_spread
from tatamu.garments import Garment
from tatamu.show.drawing import Drawing
from tatamu.show.shapes import Box
from tatamu.simulation.heavy_strip import slowest_frequency, tip
from tatamu.simulation.material import GRAVITY, Material, settling
from tatamu.simulation.mesh.meshing import staggered_rectangle
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Cloth, Gripper, Scene

COLUMNS, WIDE_COLUMNS = 8, 12
"""Columns of the mesh, and columns if the mesh spacing is given. Some simulators give vertices at the border the mass
of inner vertices, so a strip with few columns weighs too much."""
GAMMAS = np.geomspace(1e-2, 1e3, 101)
"""Values of Gamma that a ruler can distinguish."""
STIFFEST, LIMPEST = 0.02, 0.96
"""Minimum and maximum ratio of sag to free length that determines the bending rigidity. Others only bound it."""
BEST = 1.8
"""Ratio of free length to bending length that is proposed: the sag is about half of the free length."""
MIN_FREE = 0.025
"""Minimum free length that can be measured with a ruler [m]."""
STEP = 0.005
"""Step of the free lengths that are proposed to the user [m]."""
EDGE = {"towel": "bottom", "tshirt": "hem", "trousers": "waist"}
"""Edge at which each of these garments sags, by its name. Other garments sag at their longest edge."""


class SagReadings(TestEntry):
    """Readings of the sag of cloth in front of a straight grip (paper, section IV-C, Fig. 3)."""

    taken: ClassVar = {"free_length": ("free_length", "length"), "sag": ("sag", "length")}

    edge: str
    """Name of the edge next to which the cloth is held."""
    free_length: Lengths
    """Length along the cloth from the front of the grip to the edge [m]."""
    sag: Lengths
    """Vertical distance from the grip down to the edge, which is the lowest point [m]."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        free = float(np.mean(self.free_length))
        for sag in self.sag:
            if sag >= free:
                raise ValueError(
                    f"sag ({sag:g} m) must be less than free_length ({free:g} m), because the cloth cannot sag by more "
                    "than its free length"
                )
        if free < 0.01:
            raise ValueError(f"free_length must be at least 0.01 m, given {free:g} m")
        return self


@dataclass(frozen=True)
class Sag(ElasticTest):
    """The sag test: a strip of free length d in front of a horizontal grip."""

    free_length: float
    """Free length d from the front of the grip to the edge [m]."""
    spacing: float | None = None
    """Edge length of the strip's mesh [m]; None for a mesh with 12 rows."""

    name = "sag"
    parameter = "bending_rigidity"
    entry = SagReadings
    reads: ClassVar = {"sag": 1.0}
    size = "free_length"

    @classmethod
    def of(cls, entry: SagReadings, specimen: Specimen) -> Self:
        test = cls(float(np.mean(entry.free_length)), specimen.spacing)
        garment = specimen.garment
        along = length(garment.vertices[named_edge(garment, entry.edge), :2])
        least = 1.5  # edge over free length
        if along < least * test.free_length:
            raise InputError(
                f"sag: free_length ({test.free_length:g} m) must be at most {along / least:.2f} m for edge "
                f"{entry.edge}, which is {along:.2f} m long; choose a longer edge"
            )
        return test

    @classmethod
    def blanks(cls, garment: Garment) -> dict[str, str]:
        free = max(MIN_FREE, STEP * round(BEST * garment.material.bending_length / STEP))
        return {"edge": EDGE.get(garment.name) or longest_edge(garment), "free": f"{free:g}"}

    @cached_property
    def mesh(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The strip's points [m], shape (n, 3), its triangles, and its held vertices. The edge is at x = 0."""
        wanted = 12 if self.spacing is None else self.free_length / (np.sqrt(0.75) * self.spacing) - 0.5
        cells = int(np.clip(round(wanted), 3, 24))
        row = self.free_length / (cells + 0.5)
        rows = cells + 3  # the last ones are held
        rows += rows % 2
        columns = COLUMNS if self.spacing is None else WIDE_COLUMNS
        edge = row / np.sqrt(0.75)
        vertices, faces = staggered_rectangle(columns * edge, rows * row, edge)
        # the mesh chooses the distance between its rows, so the mesh is stretched until this distance is `row`
        own = np.unique(vertices[:, 0].round(9))
        along = np.searchsorted(own, vertices[:, 0].round(9))
        vertices[:, 0] = along * row
        return vertices, faces, np.flatnonzero(along >= cells)

    def scene(self, material: Material) -> Scene:
        vertices, faces, held = self.mesh
        gamma = material.areal_density * GRAVITY * self.free_length**3 / max(material.bending_rigidity, 1e-12)
        rate = slowest_frequency(gamma, self.free_length, GRAVITY)
        shortest = float(np.linalg.norm(vertices[faces] - vertices[np.roll(faces, 1, axis=1)], axis=2).min())
        thin = min(material.thickness, 0.25 * shortest)  # neighbouring triangles do not touch
        return Scene(
            cloth=Cloth(vertices=vertices, faces=faces),
            material=settling(material, rate).model_copy(update={"thickness": thin}),
            grippers=[Gripper(vertices=held.tolist(), times=[0.0], displacements=np.zeros((1, 3)))],
            duration=16.0 / rate,  # until the slowest motion has died out
            frame_rate=30.0,
        )

    def reading(self, rollout: Rollout, frame: int = -1) -> float:
        return float(-rollout.positions[frame, self.mesh[0][:, 0] < 1e-9, 2].mean())

    def guess(self, sag: float, material: Material) -> float:
        gamma = np.exp(np.interp(sag / self.free_length, [tip(gamma)[1] for gamma in GAMMAS], np.log(GAMMAS)))
        return material.areal_density * GRAVITY * self.free_length**3 / float(gamma)

    def bound(self, measured: float, error: float) -> str | None:
        # cloth that hangs straight down gives "at most", cloth that stands out horizontally gives "at least"
        if measured + error > LIMPEST * self.free_length:
            return "at most"
        return "at least" if measured - error < STIFFEST * self.free_length else None

    def straight(self, reading: float) -> float:
        return float(logit(np.clip(reading / self.free_length, 1e-4, 1.0 - 1e-4)))

    def target(self, readings: Readings) -> Target:
        target = super().target(readings)
        free_length = readings["free_length"]
        by_length = textbook_spread(lambda free, material: Sag(free).guess(target.read.value, material), free_length)
        return replace(target, spread=float(np.hypot(target.spread, by_length)))

    def advice_values(self, estimate: Estimate) -> dict[str, Any]:
        length = estimate.material.bending_length
        better = BEST * length
        if better >= MIN_FREE:
            remedy = "longer"
        else:  # the free length is too short to hold, but a loop can be read
            remedy = "too_short" if "height" in estimate.readings else "loop_instead"
        values = {
            "better": 100 * better,
            "expected": 1e3 * better * tip(BEST**3)[1],
            "height": 1e3 * (HEIGHT * length + LIFT * estimate.material.thickness),
        }
        return {
            **values,
            "length": 100 * length,
            "free_length": 1e3 * estimate.readings["free_length"].value,
            "remedy": self.texts[remedy].format(**values),
        }

    def drawing(self, shape: np.ndarray) -> str:
        rows = np.unique(self.mesh[0][:, 0].round(6))
        side = strip_profile(self.mesh[0][:, 0], shape)
        end, low = side[0]
        front = self.free_length
        back = rows[-1] + 0.25 * front
        thick = 0.07 * front
        corners = [(front, thick), (back, -thick), side.min(axis=0), (end - 0.3 * front, 0.2 * front)]
        drawing = Drawing.around(np.concatenate([side, corners]), 320.0, 220.0)
        for sign in (1.0, -1.0):
            drawing.add(Box(np.array([front, 0.0]), np.array([back, sign * thick]), "grip", "muted"))
        drawing.line(side, CLOTH, 3.5)
        dash(drawing, [(front, 0.0), (end - 0.2 * front, 0.0)])
        drawing.dimension((end - 0.12 * front, 0.0), (end - 0.12 * front, low), "sag")
        lifted = side[rows <= front] + [0.0, 0.1 * front]
        drawing.arrow([*lifted, (front, 0.1 * front)], "reading", 1.2, both=True)
        drawing.label((0.72 * front, 0.16 * front), "free_length", "reading")
        drawing.label(((front + back) / 2, -0.22 * front), "grip", "muted")
        return drawing.svg()
