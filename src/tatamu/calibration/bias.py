"""Test *bias*: the elongation of a hanging strip that is cut at 45 degrees to the yarns gives the shear stiffness.

Woven cloth is stiff along its yarns, and stretches easily at 45 degrees to them (docs/theory/membrane.md):

    4 / Y(45) = 1 / Y + 1 / Y_weft + 1 / G - 2 nu / sqrt(Y Y_weft)

A hanging strip becomes longer by rho g L^2 / 2 Y(45), if its clamped end could become narrower. A whole cloth that
hangs by a corner need not be cut, but its random folds move the lowest corner by one or two millimetres.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Self

import numpy as np
from pydantic import model_validator

from tatamu.calibration.elongation import hanging_scene
from tatamu.calibration.estimate import Fit
from tatamu.calibration.laboratory import Laboratory
from tatamu.calibration.parameters import PLACE
from tatamu.calibration.readings import Length, Lengths, TestEntry
from tatamu.calibration.test import CLOTH, Changes, LaterTest, Readings, RestTest, Specimen
from tatamu.show.drawing import Drawing
from tatamu.show.shapes import Segments
from tatamu.simulation.material import GRAVITY, Material
from tatamu.simulation.mesh.meshing import staggered_rectangle
from tatamu.simulation.mesh.topology import Topology
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Cloth, Scene


class BiasReadings(TestEntry):
    """Lengths of a strip that is cut at 45 degrees to the yarns, hanging and lying."""

    taken: ClassVar = {"bias_L1": ("L1", "length"), "bias_L2": ("L2", "length")}

    width: Length
    """Width of the strip [m]."""
    L1: Lengths
    """Distance from the grip straight down to the end of the hanging strip [m]."""
    L2: Lengths
    """Distance from the grip to the end of the strip when it lies flat [m]."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        hung = float(np.mean(self.L1))
        lying = float(np.mean(self.L2))
        if not lying < hung < 1.5 * lying:
            raise ValueError(f"L1 ({hung:g} m, hanging) must be between 1 and 1.5 times L2 ({lying:g} m, lying)")
        if not 0.02 <= self.width / lying <= 0.34:
            change = "narrower" if self.width > 0.34 * lying else "wider"
            raise ValueError(
                f"width ({self.width:g} m) must be 0.02 to 0.34 times L2 ({lying:g} m); cut a {change} strip"
            )
        return self


@dataclass(frozen=True)
class Bias(LaterTest, RestTest):
    """The test of a strip that is cut at 45 degrees to the yarns and hangs by one end."""

    length: float
    """Length L2 from the grip to the end of the unstrained strip [m]."""
    width: float
    """Width of the strip [m]."""
    spacing: float | None = None
    """Edge length of the mesh [m]; None for a fixed fraction of the strip's width."""

    name = "bias"
    parameter = "shear_stiffness"
    entry = BiasReadings
    needs = ("elongation",)
    asks = "orthotropy"
    reads: ClassVar = {"bias_L1": 1.0, "bias_L2": -1.0}

    @classmethod
    def of(cls, entry: BiasReadings, specimen: Specimen) -> Self:
        return cls(float(np.mean(entry.L2)), entry.width, specimen.spacing)

    @cached_property
    def mesh(self) -> tuple[np.ndarray, np.ndarray]:
        """Points of the strip [m], shape (n, 2), down from the grip and across, and triangles."""
        flat, faces = staggered_rectangle(self.width, self.length, self.spacing or self.width / 6)
        return flat[:, :2] + [0.5 * self.length, 0.0], faces

    def scene(self, material: Material) -> Scene:
        plan, faces = self.mesh
        nothing = np.zeros(len(plan))
        cloth = Cloth(
            vertices=np.column_stack([nothing, plan[:, 1], -plan[:, 0]]),
            rest_vertices=np.column_stack([plan, nothing]),
            faces=faces,
            fibre=np.array([[1.0, 1.0, 0.0]]),
        )
        held = np.flatnonzero(plan[:, 0] < 1e-9)
        return hanging_scene(cloth, [held], self.length, material.model_copy(update={"compression": 1.0}))

    def reading(self, rollout: Rollout, frame: int = -1) -> float:
        end = self.mesh[0][:, 0] > self.length - 1e-9
        return float(-rollout.positions[frame, end, 2].mean()) - self.length

    def guess(self, longer: float, material: Material) -> float:
        return material.areal_density * GRAVITY * self.length**2 / (8.0 * longer)

    def find(self, laboratory: Laboratory, material: Material, readings: Readings) -> tuple[Material, Fit]:
        target = self.target(readings)
        found = target.matched(laboratory, material, target.start(material))
        if len(found.samples) < 2:  # the first value was right; a second value is needed for the slope
            beside = 1.1 * found.parameter
            also = laboratory.reading(self, material.model_copy(update={self.parameter: beside}))
            found = found.after(((beside, also),))
        return material.model_copy(update={self.parameter: found.parameter}), target.fit(found, found.reading)

    def derivatives(self, readings: Readings, fit: Fit) -> tuple[dict[str, float], dict[str, float]]:
        # The elongation e depends on Y / rho and G / rho, with the stretch stiffness Y, the shear stiffness G and the
        # areal density rho. The elongation is about proportional to rho. With s = -de/dln G, a change of the three
        # parameters changes e by
        #
        #     e dln rho - s dln G - (e - s) dln Y
        slope = -fit.slope if fit.slope else max(fit.measured, fit.uncertainty)
        whole = fit.measured / slope
        by_parameter = {"areal_density": whole, "stretch_stiffness": min(1.0 - whole, 0.0)}
        return by_parameter, {"bias_L1": -1.0 / slope, "bias_L2": 1.0 / slope}

    def propagate(self, changes: Changes, readings: Readings, fit: Fit) -> None:
        super().propagate(changes, readings, fit)
        if not any(change[PLACE["stretch_stiffness"]] for change in changes.values()):
            # ln Y has a standard uncertainty of 1 if elongation only bounds Y
            changes["L1"][PLACE[self.parameter]] += self.derivatives(readings, fit)[0]["stretch_stiffness"]

    def drawing(self, shape: np.ndarray) -> str:
        hung = shape[:, 1:]
        lying = self.mesh[0][:, ::-1] * [1.0, -1.0] + [0.45 * self.length, 0.0]
        room = np.array([0.2 * self.length, 0.03 * self.length])
        drawing = Drawing.around(np.concatenate([hung - room, hung + room, lying + room]), 240.0, 300.0)
        edges = Topology(self.mesh[1]).edges
        for view, end, name in ((hung, hung[:, 1].min(), "L1"), (lying, -self.length, "L2")):
            drawing.add(Segments(view[edges], CLOTH, 0.5, opacity=0.6))
            right = view[:, 0].max() + 0.04 * self.length
            drawing.dimension((right, 0.0), (right, end), name)
        half = 0.5 * self.width
        drawing.line([(-half, 0.0), (half, 0.0)], "muted", 7.0)
        middle = self.length * np.array([0.45, -0.5])
        for turn in (1.0, -1.0):
            yarn = 0.8 * half * np.array([1.0, turn])
            drawing.arrow([middle - yarn, middle + yarn], "ink", 1.2, both=True)
        drawing.label(middle - [0.0, 0.9 * half], "yarns", "ink", (0.0, -1.0))
        return drawing.svg()
