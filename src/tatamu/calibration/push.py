"""Test *push*: the motion of a pushed cloth's far edge determines the resistance to compression.

A soft sheet wrinkles where it is pushed, and its far edge does not move, while a stiffer sheet slides as a whole. The
ruler pushes the near edge by s, and the far edge moves by p. Friction shortens the cloth by

    s - p = mu rho g L^2 / (2 c Y)

The factor c is the fraction of Y that resists compression. A factor below 1 represents wrinkles that are too small for
a coarse mesh.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Self

import numpy as np
from pydantic import model_validator

from tatamu.base.errors import InputError
from tatamu.calibration.estimate import Estimate, Fit
from tatamu.calibration.laboratory import Laboratory
from tatamu.calibration.parameters import PLACE
from tatamu.calibration.readings import Distances, Errors, Lengths, Reading, TestEntry
from tatamu.calibration.test import (
    CLOTH,
    DASH,
    Changes,
    LaterTest,
    Readings,
    RestTest,
    Specimen,
    Target,
    millimetres,
    strip_profile,
)
from tatamu.show.drawing import Drawing
from tatamu.show.shapes import Box
from tatamu.simulation.material import GRAVITY, Material
from tatamu.simulation.mesh.meshing import staggered_rectangle
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Cloth, Gripper, Scene, Table


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
                    f"moved ({moved:g} m) must be at most pushed ({pushed:g} m), because the far edge cannot move "
                    "farther than the ruler; check that nothing pulled the cloth"
                )
        if pushed > 0.3 * length:
            raise ValueError(
                f"pushed ({pushed:g} m) must be at most 0.3 times length ({length:g} m), because cloth buckles when "
                "pushed farther"
            )
        return self

    def readings(self, errors: Errors) -> dict[str, Reading]:
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
    """Edge length of the strip's mesh [m]; None for 2 cm, or less if the cloth is short."""

    name = "push"
    title = "Push: compression c"
    parameter = "compression"
    entry = PushReadings
    needs = ("elongation", "friction")
    needs_because = "the resistance to a push depends on both"
    yields_to = ("bias",)
    yields_because = (
        "cloth with a shear stiffness of its own, which bias gives it, resists compression as it does tension"
    )
    asks = ("compression", "knows no compression: its cloth resists it as it does tension")
    rising = True
    read = "moved"
    words: ClassVar = {
        "push_length": "the length of the cloth ahead of the ruler",
        "pushed": "how far the ruler was pushed",
        "moved": "how far the far edge moved",
    }

    @classmethod
    def of(cls, entry: PushReadings, specimen: Specimen) -> Self:
        if specimen.base.orthotropic_membrane:
            raise InputError(
                "push: must be left out for a material with a weft or shear stiffness, because such a cloth resists "
                "compression as much as tension"
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
        return Target(self, moved.value, error, self.bound(moved.value, error))

    def find(self, laboratory: Laboratory, material: Material, readings: Readings) -> tuple[Material, Fit]:
        # If the reading gives only a lower bound of c, and the material already satisfies this bound, the material is
        # kept. A sheet that slides as a whole gives only a lower bound, because its motion does not show at which c it
        # would wrinkle.
        target = self.target(readings)
        found = target.matched(laboratory, material, target.start(material))
        if target.bound_by(found) == "at least" and found.parameter < material.compression:
            return material, target.fit(found, laboratory.reading(self, material), shared=True)
        return material.model_copy(update={"compression": found.parameter}), target.fit(found, found.reading)

    def propagate(self, changes: Changes, readings: Readings, fit: Fit) -> None:
        # The factor is c = mu rho g L^2 / 2 Y (s - p), with the coefficient of friction mu, the areal density rho, the
        # acceleration of gravity g, the length L and the stretch stiffness Y. The ruler moves by s, the far edge by p.
        shorter = max(readings["pushed"].value - readings["moved"].value, readings["pushed"].uncertainty)
        own = {"push_length": 2.0 / readings["push_length"].value, "pushed": -1.0 / shorter, "moved": 1.0 / shorter}
        density, stretch, friction = (PLACE[name] for name in ("areal_density", "stretch_stiffness", "friction_table"))
        for name, change in changes.items():
            moved = change[density] - change[stretch] + change[friction]
            if name in own:
                moved += own[name] * readings[name].uncertainty
            change[PLACE[self.parameter]] = moved

    def advice_on_bound(self, estimate: Estimate, fit: Fit) -> str:
        compression = estimate.material.compression
        error = millimetres(fit.uncertainty)
        if fit.bound == "at most":
            return (
                f"push: the far edge did not move by more than {error}, so c is at most {compression:.2g}, which is "
                "enough for folding. A shorter cloth or a longer push would tell more."
            )
        return (
            f"push: within {error}, the cloth slid as a whole, so c is at least {fit.alone or compression:.2g}, and "
            f"{compression:.2g} is used. A longer cloth would tell more."
        )

    def drawing(self, shape: np.ndarray) -> str:
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
