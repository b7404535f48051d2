"""Test *push*: the motion of a pushed cloth's far edge determines the resistance to compression.

This test is not in the paper. A soft sheet wrinkles where it is pushed, and its far edge does not move. A stiffer sheet
slides as a whole. The ruler pushes the near edge by the distance s, and the far edge moves by the distance p. If the
far edge moves, the cloth becomes shorter by

    s - p = mu rho g L^2 / (2 c Y)

The friction per area is mu rho g. The pressure in the cloth therefore grows evenly from the far edge to the ruler, and
this pressure shortens the cloth. Here mu is the coefficient of friction, rho the areal density, g the acceleration of
gravity, and L the length of the cloth.

The factor c is the fraction of the stretch stiffness Y that resists compression. A factor below 1 represents wrinkles
that are too small for a coarse mesh.
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
from tatamu.calibration.laboratory import Laboratory
from tatamu.calibration.parameters import PLACE
from tatamu.calibration.picture import CLOTH, DASH, strip_profile
from tatamu.calibration.quantity import Distances, Lengths
from tatamu.calibration.readings import Reading
from tatamu.calibration.target import Target
from tatamu.calibration.test import Changes, LaterTest, Readings, RestTest, Specimen, millimetres
from tatamu.garments import Garment
from tatamu.show.drawing import Drawing
from tatamu.show.shapes import Box
from tatamu.simulation.material import GRAVITY, Material
from tatamu.simulation.mesh.meshing import staggered_rectangle
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Cloth, Gripper, Scene, Table
from tatamu.simulation.simulators import capabilities

CELL, COLUMNS = 0.02, 4
"""Edge length of the strip's mesh [m], and the number of cells across the strip."""
ROWS = 12
"""Smallest number of rows of the strip's mesh."""
SPEED = 0.02
"""Mean speed of the ruler [m/s].

At 0.05 m/s, the simulated cloth trembles, and its shortening is a fifth smaller than at 0.02 m/s.
"""
KNOTS = 41
REST = 0.5
"""Time from the end of the push to the reading [s]."""


class PushReadings(TestEntry):
    """Readings of a cloth on a table whose near edge is pushed by a ruler."""

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
                    f"moved ({moved:g} m) must be at most pushed ({pushed:g} m): the far edge does not go farther than "
                    "the ruler; was the cloth pulled?"
                )
        if pushed > 0.3 * length:
            raise ValueError(
                f"pushed ({pushed:g} m) must be at most 0.3 of length ({length:g} m): cloth heaps up before the ruler"
            )
        return self

    def readings(self, errors: Errors) -> dict[str, Reading]:
        """Return the readings by their names; see `TestEntry.readings`."""
        return {
            "push_length": Reading.of(self.length, errors.length),
            "pushed": Reading.of(self.pushed, errors.length),
            "moved": Reading.of(self.moved, errors.length),
        }


@dataclass(frozen=True)
class Push(LaterTest, RestTest):
    """The test of a cloth that is pushed along a table."""

    length: float
    """Length L of the cloth in front of the ruler [m]."""
    pushed: float
    """Distance s by which the ruler was pushed [m]."""
    spacing: float | None = None
    """Edge length of the strip's mesh [m]; None for `CELL`, or a smaller length if the cloth is short."""

    name = "push"
    title = "Push: compression c"
    parameter = "compression"
    entry = PushReadings
    needs = ("elongation", "friction")
    needs_because = "what resists a push depends on both"
    yields_to = ("bias",)
    yields_because = (
        "cloth with a shear stiffness of its own, which bias gives it, resists compression as it does tension"
    )
    read = "moved"
    words = MappingProxyType(
        {
            "push_length": "the length of the cloth ahead of the ruler",
            "pushed": "how far the ruler was pushed",
            "moved": "how far the far edge moved",
        }
    )
    instructions = """\
Push it (optional): shows whether the cloth wrinkles or slides when hands push it.  [push] length, pushed, moved
   Lay one layer flat on the surface of measurement $friction. Press a ruler onto its whole near edge and push that edge
   5 cm towards the far edge, slowly. length: length of the cloth before the ruler, at the start. pushed: distance that
   the ruler moved. moved: distance that the far edge moved, 0 if it did not move.
"""

    @classmethod
    def of(cls, entry: PushReadings, specimen: Specimen) -> Self:
        """Return the simulated copy of this measurement; see `CalibrationTest.of`."""
        if specimen.base.orthotropic_membrane:
            raise InputError(
                "push: the garment's material has a weft or shear stiffness of its own, and cloth that resists "
                "compression less than tension cannot; give garment.material without, or leave out push"
            )
        return cls(float(np.mean(entry.length)), float(np.mean(entry.pushed)), specimen.spacing)

    @classmethod
    def template(cls, garment: Garment) -> str:
        """Return this test's part of an empty measurements file; see `CalibrationTest.template`."""
        return """\
# [push]                 # optional: cloth pushed along the table by a ruler on its near edge
# length = []            # of the cloth ahead of the ruler
# pushed = []            # how far the ruler went
# moved = []             # how far the far edge did, 0 where it stayed
"""

    def unusable(self, simulator: str) -> str | None:
        """Return why a simulator cannot do this test; see `CalibrationTest.unusable`."""
        if capabilities(simulator).compression:
            return None
        return "knows no compression: its cloth resists it as it does tension"

    @cached_property
    def mesh(self) -> tuple[np.ndarray, np.ndarray]:
        """Points of the strip on z = 0 [m], shape (n, 3), and its triangles.

        The length of the strip is along x, from x = 0.
        """
        edge = self.spacing or min(CELL, self.length / (ROWS * np.sqrt(0.75)))
        vertices, faces = staggered_rectangle(COLUMNS * edge, self.length, edge)
        return vertices - [vertices[:, 0].min(), 0.0, vertices[:, 2].min()], faces

    def scene(self, material: Material) -> Scene:
        """Return the scene of this test: a strip on the table whose first row is held and pushed."""
        flat, faces = self.mesh
        u = np.linspace(0.0, 1.0, KNOTS)
        seconds = self.pushed / SPEED
        path = np.outer(u * u * (3.0 - 2.0 * u), [self.pushed, 0.0, 0.0])
        held = np.flatnonzero(flat[:, 0] < 1e-9).tolist()
        return Scene(
            cloth=Cloth(vertices=flat + np.array([0.0, 0.0, 0.5 * material.thickness]), faces=faces),
            material=material.model_copy(update={"air_drag": 0.0}),
            table=Table(),
            grippers=[Gripper(vertices=held, times=(seconds * u).tolist(), displacements=path)],
            duration=seconds + REST,
            frame_rate=30.0,
        )

    def reading(self, rollout: Rollout, frame: int = -1) -> float:
        """Return the distance by which the far edge has moved [m]."""
        return float((rollout.positions[frame] - rollout.positions[0])[self._far, 0].mean())

    @cached_property
    def _far(self) -> np.ndarray:
        along = self.mesh[0][:, 0]
        return along > along.max() - 1e-9

    def guess(self, moved: float, material: Material) -> float:
        """Return the compression factor c with which the far edge moves by the distance `moved` [m].

        The factor follows from the formula at the top of the module.
        """
        weight = material.friction_table * material.areal_density * GRAVITY
        return weight * self.length**2 / (2.0 * material.stretch_stiffness * max(self.pushed - moved, 1e-4))

    def target(self, readings: Readings) -> Target:
        """Return what the simulated reading must reach; see `RestTest.target`."""
        pushed = readings["pushed"]
        moved = readings["moved"]
        error = float(np.hypot(pushed.uncertainty, moved.uncertainty))
        return Target(
            test=self,
            parameter=self.parameter,
            measured=moved.value,
            uncertainty=error,
            bound="at most" if moved.value < error else "at least" if moved.value > pushed.value - error else None,
            guess=self.guess,
            straight=lambda value: float(-np.log(max(pushed.value - value, 1e-5))),
            rising=True,
        )

    def find(self, laboratory: Laboratory, material: Material, readings: Readings) -> tuple[Material, Fit]:
        """Search for the factor c, the fraction of the stretch stiffness that resists compression.

        If the reading gives only a lower bound of c, and the material already satisfies this bound, the material is
        kept. A sheet that slides as a whole gives only a lower bound, because its motion does not show at which c it
        would wrinkle.
        """
        target = self.target(readings)
        found = target.matched(laboratory, material, target.start(material))
        if target.bound_by(found) == "at least" and found.parameter < material.compression:
            return material, target.fit(found, laboratory.reading(self, material), shared=True)
        return material.model_copy(update={"compression": found.parameter}), target.fit(found, found.reading)

    def propagate(self, changes: Changes, readings: Readings, fit: Fit) -> None:
        """Add the effects of uncertain readings on the factor c to `changes`; see `LaterTest.propagate`.

        The factor is c = mu rho g L^2 / 2 Y (s - p), with the coefficient of friction mu, the areal density rho, the
        acceleration of gravity g, the length L and the stretch stiffness Y. The ruler moves by s, the far edge by p.
        """
        shorter = max(readings["pushed"].value - readings["moved"].value, readings["pushed"].uncertainty)
        own = {"push_length": 2.0 / readings["push_length"].value, "pushed": -1.0 / shorter, "moved": 1.0 / shorter}
        density, stretch, friction = (PLACE[name] for name in ("areal_density", "stretch_stiffness", "friction_table"))
        for name, change in changes.items():
            moved = change[density] - change[stretch] + change[friction]
            if name in own:
                moved += own[name] * readings[name].uncertainty
            change[PLACE[self.parameter]] = moved

    def advice(self, estimate: Estimate, fit: Fit) -> list[str]:
        """Return advice on this test; see `CalibrationTest.advice`."""
        compression = estimate.material.compression
        error = millimetres(fit.uncertainty)
        if fit.bound == "at most":
            return [
                f"push: the far edge stayed where it was to {error}: c is at most {compression:.2g}, and "
                "folding asks for no more. A shorter cloth or a longer push would tell."
            ]
        if fit.bound == "at least":
            return [
                f"push: the cloth slid as a whole, to {error}: c is at least {fit.alone or compression:.2g}, and "
                f"{compression:.2g} is taken. A longer cloth would tell."
            ]
        return []

    def drawing(self, shape: np.ndarray | None) -> str:
        """Draw the strip after the push, as seen from the side, and the positions of its ends before the push."""
        if shape is None:
            return ""
        side = strip_profile(self.mesh[0][:, 0], shape)
        low = 0.12 * self.length
        high = 0.05 * self.length
        right = self.length + max(0.08 * self.length, self.pushed)
        corners = np.array([[-0.08 * self.length, -low], [right, 2.2 * high]])
        drawing = Drawing.around(np.concatenate([side, corners]), 420.0, 220.0)
        drawing.line(np.array([[corners[0, 0], 0.0], [corners[1, 0], 0.0]]), "muted", 3.0)
        drawing.line(side + np.array([0.0, 2.0 / drawing.scale]), CLOTH, 3.5)
        ruler = side[0]
        drawing.add(Box(ruler, ruler + np.array([-0.03 * self.length, 2.0 * high]), "grip", "muted"))
        for start, now, name in ((0.0, side[0, 0], "pushed"), (self.length, side[-1, 0], "moved")):
            drawing.line(np.array([[start, -0.7 * low], [start, 1.6 * high]]), "muted", 1.0, dash=DASH)
            if now - start > 1e-3:
                drawing.dimension(np.array([start, -0.4 * low]), np.array([now, -0.4 * low]), "")
            drawing.label((0.5 * (start + now), -0.9 * low), name, "reading")
        drawing.dimension(np.array([0.0, 1.8 * high]), np.array([self.length, 1.8 * high]), "length")
        return drawing.svg()
