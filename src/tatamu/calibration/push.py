"""Test *push*: the motion of a pushed cloth's far edge determines the resistance to compression.

A soft sheet wrinkles where it is pushed, and its far edge does not move, while a stiffer sheet slides as a whole. The
ruler pushes the near edge by s, and the far edge moves by p. Friction shortens the cloth by

    s - p = mu rho g L^2 / (2 c Y)

The factor c is the fraction of Y that resists compression. A factor below 1 represents wrinkles that are finer
than the mesh.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Self

import numpy as np
from pydantic import model_validator

from tatamu.base.errors import InputError
from tatamu.calibration.estimate import Fit
from tatamu.calibration.laboratory import Laboratory
from tatamu.calibration.readings import Distances, Lengths, Reading, TestEntry
from tatamu.calibration.test import CLOTH, LaterTest, Readings, RestTest, Specimen, Target, dash, strip_profile
from tatamu.show.drawing import Drawing
from tatamu.show.shapes import Box
from tatamu.simulation.material import GRAVITY, Material
from tatamu.simulation.mesh.meshing import staggered_rectangle
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Cloth, Gripper, Scene, Table


class PushReadings(TestEntry):
    """Readings of a cloth on a table whose near edge is pushed by a ruler."""

    taken: ClassVar = {
        "push_length": ("length", "length"),
        "pushed": ("pushed", "length"),
        "moved": ("moved", "length"),
    }

    length: Lengths
    """Length of the cloth in front of the ruler, in the direction of the push [m]."""
    pushed: Lengths
    """Distance by which the ruler was pushed [m]."""
    moved: Distances
    """Distance by which the far edge moved [m]; 0 if it stayed."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        length = float(np.mean(self.length))
        pushed = float(np.mean(self.pushed))
        for moved in self.moved:
            if moved > pushed:
                raise ValueError(
                    f"`moved` ({moved:g} m) must be at most `pushed` ({pushed:g} m), because the far edge cannot move "
                    "farther than the ruler; check that nothing pulled the cloth"
                )
        if pushed > 0.3 * length:
            raise ValueError(
                f"`pushed` ({pushed:g} m) must be at most 0.3 times `length` ({length:g} m), because cloth buckles "
                "when pushed farther"
            )
        return self


@dataclass(frozen=True)
class Push(LaterTest, RestTest):
    """The test of a cloth that is pushed along a table."""

    length: float
    """Length L of the cloth in front of the ruler [m]."""
    pushed: float
    """Distance s by which the ruler was pushed [m]."""
    spacing: float | None = None
    """Edge length of the strip's mesh [m]; None for 2 cm, or less if the cloth is short."""

    name = "push"
    parameter = "compression"
    entry = PushReadings
    needs = ("elongation", "friction")
    yields_to = ("bias",)
    asks = "compression"
    rising = True

    @classmethod
    def of(cls, entry: PushReadings, specimen: Specimen) -> Self:
        if specimen.base.orthotropic_membrane:
            raise InputError(
                "push: must be left out for a material with shear_stiffness or stretch_stiffness_weft, because such a "
                "material is equally stiff in compression and tension"
            )
        return cls(float(np.mean(entry.length)), float(np.mean(entry.pushed)), specimen.spacing)

    @cached_property
    def mesh(self) -> tuple[np.ndarray, np.ndarray]:
        """Points of the strip on z = 0 [m], shape (n, 3), along x from x = 0, and its triangles."""
        edge = self.spacing or min(0.02, self.length / (12 * np.sqrt(0.75)))  # at least 12 rows
        vertices, faces = staggered_rectangle(4 * edge, self.length, edge)
        return vertices - [vertices[:, 0].min(), 0.0, vertices[:, 2].min()], faces

    def scene(self, material: Material) -> Scene:
        flat, faces = self.mesh
        u = np.linspace(0.0, 1.0, 41)
        seconds = self.pushed / 0.02  # at 0.05 m/s the cloth trembles, and its shortening is a fifth smaller
        path = np.outer(u * u * (3.0 - 2.0 * u), [self.pushed, 0.0, 0.0])
        held = np.flatnonzero(flat[:, 0] < 1e-9).tolist()
        return Scene(
            cloth=Cloth(vertices=flat + np.array([0.0, 0.0, 0.5 * material.thickness]), faces=faces),
            material=material.model_copy(update={"air_drag": 0.0}),
            table=Table(),
            grippers=[Gripper(vertices=held, times=(seconds * u).tolist(), displacements=path)],
            duration=seconds + 0.5,  # at rest
            frame_rate=30.0,
        )

    def reading(self, rollout: Rollout, frame: int = -1) -> float:
        along = self.mesh[0][:, 0]
        far = along > along.max() - 1e-9
        return float((rollout.positions[frame] - rollout.positions[0])[far, 0].mean())

    def guess(self, moved: float, material: Material) -> float:
        weight = material.friction_table * material.areal_density * GRAVITY
        return weight * self.length**2 / (2.0 * material.stretch_stiffness * max(self.pushed - moved, 1e-4))

    def bound(self, measured: float, error: float) -> str | None:
        return "at most" if measured < error else "at least" if measured > self.pushed - error else None

    def straight(self, reading: float) -> float:
        return float(-np.log(max(self.pushed - reading, 1e-5)))

    def target(self, readings: Readings) -> Target:
        moved, pushed = readings["moved"], readings["pushed"]
        error = float(np.hypot(pushed.uncertainty, moved.uncertainty))  # of the shortening
        return Target(self, Reading(moved.value, error), self.bound(moved.value, error))

    def find(self, laboratory: Laboratory, material: Material, readings: Readings) -> tuple[Material, Fit]:
        # If the reading gives only a lower bound of c, and the material already satisfies this bound, the material is
        # kept. A sheet that slides as a whole gives only a lower bound, because its motion does not show at which c it
        # would wrinkle.
        target = self.target(readings)
        found = target.matched(laboratory, material, target.start(material))
        if target.bound_by(found) == "at least" and found.parameter < material.compression:
            return material, target.fit(found, laboratory.reading(self, material), shared=True)
        return material.model_copy(update={"compression": found.parameter}), target.fit(found, found.reading)

    def derivatives(self, readings: Readings, fit: Fit) -> tuple[dict[str, float], dict[str, float]]:
        # The factor is c = mu rho g L^2 / 2 Y (s - p), with the coefficient of friction mu, the areal density rho, the
        # acceleration of gravity g, the length L and the stretch stiffness Y. The ruler moves by s, the far edge by p.
        shorter = max(readings["pushed"].value - readings["moved"].value, readings["pushed"].uncertainty)
        by_parameter = {"areal_density": 1.0, "stretch_stiffness": -1.0, "friction_table": 1.0}
        by_reading = {"push_length": 2.0 / readings["push_length"].value, "pushed": -1.0 / shorter}
        return by_parameter, {**by_reading, "moved": 1.0 / shorter}

    def drawing(self, shape: np.ndarray) -> str:
        side = strip_profile(self.mesh[0][:, 0], shape)
        low, high = 0.12 * self.length, 0.05 * self.length
        left, right = -0.08 * self.length, self.length + max(0.08 * self.length, self.pushed)
        drawing = Drawing.around(np.concatenate([side, [(left, -low), (right, 2.2 * high)]]), 420.0, 220.0)
        drawing.line([(left, 0.0), (right, 0.0)], "muted", 3.0)
        drawing.line(side + np.array([0.0, 2.0 / drawing.scale]), CLOTH, 3.5)
        drawing.add(Box(side[0], side[0] + [-0.03 * self.length, 2.0 * high], "grip", "muted"))
        for start, now, name in ((0.0, side[0, 0], "pushed"), (self.length, side[-1, 0], "moved")):
            dash(drawing, [(start, -0.7 * low), (start, 1.6 * high)])
            if now - start > 1e-3:
                drawing.dimension((start, -0.4 * low), (now, -0.4 * low), "")
            drawing.label((0.5 * (start + now), -0.9 * low), name, "reading")
        drawing.dimension((0.0, 1.8 * high), (self.length, 1.8 * high), "length")
        return drawing.svg()
