"""Test *plate*: the drape of a disc of cloth over a round plate determines the bending rigidity.

Seen from above, the drape coefficient is

    DC = (A_outline - A_plate) / (A_disc - A_plate)

The simulation must reproduce the radius of the circle that has the area of the outline. The search starts from
DC / (1 - DC) = (l_b / a / 0.255)^2.95, with the overhang a, which was fitted to simulations of discs that are 1.7 or 2
times as wide as the plate, with Y = 300 N/m.

Folds begin at random places, so two discs are simulated side by side, and their differences enter the uncertainty.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from tatamu.base.arrays import is_finite_number
from tatamu.calibration.estimate import Estimate, Fit
from tatamu.calibration.instruments.drapemeter import Drapemeter
from tatamu.calibration.instruments.outline import PlanOutline
from tatamu.calibration.readings import Errors, Length, Reading, TestEntry, uncertainty
from tatamu.calibration.test import CLOTH, ElasticTest, Specimen, dash
from tatamu.show.drawing import Drawing
from tatamu.simulation.material import GRAVITY, Material
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Cloth, Gripper, Scene

DISCS = 2
"""Number of discs that are simulated side by side."""
APART = 2.6
"""Distance between the centres of the two discs, in radii of the discs."""


def _coefficients(value: Any) -> tuple[float, ...]:
    given = value if isinstance(value, list | tuple) else [value]
    if not given:
        raise ValueError("must contain at least one reading, given none")
    for each in given:
        if not is_finite_number(each) or not 0.0 < each < 1.0:
            hint = (
                f"; if the coefficient is in per cent, write {each / 100:g}"
                if is_finite_number(each) and each > 1
                else ""
            )
            raise ValueError(f"must be between 0 and 1, given {each!r}{hint}")
    return tuple(float(each) for each in given)


class PlateReadings(TestEntry):
    """Readings of a disc of cloth over a plate, as seen from above."""

    disc: Length
    """Diameter of the disc of cloth [m]."""
    plate: Length
    """Diameter of the plate [m]."""
    drape_coefficient: Annotated[tuple[float, ...], BeforeValidator(_coefficients)]
    """Drape coefficient [-]."""
    nodes: tuple[Annotated[int, Field(ge=0, le=60)], ...] = ()
    """Number of folds at the edge of the cloth, which is compared but determines no parameter."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if not 1.3 <= self.disc / self.plate <= 2.5:
            raise ValueError(
                f"disc ({self.disc:g} m) must be 1.3 to 2.5 times as wide as plate ({self.plate:g} m), given "
                f"{self.disc / self.plate:.2f} times; give diameters, not radii"
            )
        return self

    def readings(self, errors: Errors) -> dict[str, Reading]:
        ring = 0.25 * (self.disc**2 - self.plate**2)
        mean = float(np.mean(self.drape_coefficient))
        radius = float(np.sqrt(0.25 * self.plate**2 + mean * ring))
        error = uncertainty(self.drape_coefficient, errors.drape) * ring / (2.0 * radius)
        return {"hem": Reading(radius, error, len(self.drape_coefficient))}


@dataclass(frozen=True)
class Plate(ElasticTest):
    """The test of a disc of cloth over a plate."""

    disc: float
    """Radius of the disc of cloth [m]."""
    plate: float
    """Radius of the plate [m]."""
    coefficient: float
    """The measured drape coefficient. It determines the edge length of the mesh."""
    folds: float | None = None
    """Mean number of folds that were counted; None if folds were not counted."""
    spacing: float | None = None
    """Edge length of the mesh [m]; None for a fixed fraction of the bending length."""
    seed: int = 0
    """Random seed of the discs' unevenness."""

    name = "plate"
    parameter = "bending_rigidity"
    entry = PlateReadings
    reads: ClassVar = {"hem": 1.0}
    rising = True
    step = 0.4  # so large that differences exceed the random scatter

    @classmethod
    def of(cls, entry: PlateReadings, specimen: Specimen) -> Self:
        folds = float(np.mean(entry.nodes)) if entry.nodes else None
        mean = float(np.mean(entry.drape_coefficient))
        return cls(0.5 * entry.disc, 0.5 * entry.plate, mean, folds, specimen.spacing)

    @property
    def overhang(self) -> float:
        """Overhang a: the width of the cloth outside the plate's rim [m]."""
        return self.disc - self.plate

    @cached_property
    def discs(self) -> list[Drapemeter]:
        """The simulated discs of cloth, each on its plate."""
        # in bending lengths by the formula at the top of the module
        cell = 0.45 * self.overhang * length_share(self.coefficient)
        edge = self.spacing or float(np.clip(cell, 0.06 * self.overhang, 0.2 * self.overhang))
        return [Drapemeter(self.disc, self.plate, edge, DISCS * self.seed + number) for number in range(DISCS)]

    def scene(self, material: Material) -> Scene:
        scenes = [disc.scene(material) for disc in self.discs]
        aside = [np.array([number * APART * self.disc, 0.0, 0.0]) for number in range(DISCS)]
        vertices, rest = (
            np.concatenate([getattr(scene.cloth, kind) + shift for scene, shift in zip(scenes, aside, strict=True)])
            for kind in ("vertices", "rest")
        )
        grippers = [
            Gripper(vertices=[start + v for v in hand.vertices], times=hand.times, displacements=hand.displacements)
            for scene, start in zip(scenes, self._starts, strict=False)
            for hand in scene.grippers
        ]
        faces = [scene.cloth.faces + start for scene, start in zip(scenes, self._starts, strict=False)]
        first = scenes[0]
        return first.model_copy(
            update={
                "cloth": Cloth(vertices=vertices, faces=np.concatenate(faces), rest_vertices=rest),
                "grippers": grippers,
                "duration": first.grippers[0].times[-1] + 4.0,  # settles after the rise
                "frame_rate": 4.0,
            }
        )

    @cached_property
    def _starts(self) -> list[int]:
        """Index of the first vertex of each disc, and finally the number of all vertices."""
        return [0, *np.cumsum([len(disc.mesh[0]) for disc in self.discs]).tolist()]

    def outlines(self, positions: np.ndarray) -> list[PlanOutline]:
        """Return each disc's outline as seen from above, from the positions of all n vertices [m], shape (n, 3)."""
        return [
            PlanOutline.of(
                positions[self._starts[number] : self._starts[number + 1]],
                disc.mesh[1],
                np.array([number * APART * self.disc, 0.0]),
                180,
            )
            for number, disc in enumerate(self.discs)
        ]

    def reading(self, rollout: Rollout, frame: int = -1) -> float:
        areas = [outline.area for outline in self.outlines(rollout.positions[frame])]
        return float(np.sqrt(np.mean(areas) / np.pi))

    def chance(self, shapes: Sequence[np.ndarray]) -> float:
        radii = np.sqrt([[outline.area / np.pi for outline in self.outlines(shape)] for shape in shapes])
        return float(np.sqrt(radii.var(axis=1, ddof=1).mean() / DISCS))

    def coefficient_of(self, radius: float) -> float:
        """Return the drape coefficient of an outline with this mean radius [m]."""
        return (radius**2 - self.plate**2) / (self.disc**2 - self.plate**2)

    def guess(self, radius: float, material: Material) -> float:
        return material.areal_density * GRAVITY * (self.overhang * length_share(self.coefficient_of(radius))) ** 3

    def bound(self, measured: float, error: float) -> str | None:
        low, high = (self.coefficient_of(measured + sign * error) for sign in (-1.0, 1.0))
        return "at most" if low < 0.08 else "at least" if high > 0.93 else None

    def straight(self, reading: float) -> float:
        return float(np.log(length_share(self.coefficient_of(reading))))

    def sentence(self, fit: Fit) -> str:
        measured, simulated = (100.0 * self.coefficient_of(radius) for radius in (fit.measured, fit.simulated))
        error = 100.0 * fit.uncertainty * 2.0 * fit.measured / (self.disc**2 - self.plate**2)
        return f"Drape coefficient measured: {measured:.1f} ± {error:.1f} %; simulated: {simulated:.1f} %."

    def remark(self, estimate: Estimate, fit: Fit) -> list[str]:
        shape = estimate.shapes.get(self.name)
        if shape is None or self.folds is None:
            return []
        simulated = float(np.mean([outline.nodes for outline in self.outlines(shape)]))
        remark = self.texts["remark"].format(counted=self.folds, simulated=simulated)
        return [] if abs(simulated - self.folds) <= 2 else [remark]

    def drawing(self, shape: np.ndarray) -> str:
        turn = np.linspace(0.0, 2.0 * np.pi, 181)
        circle = np.column_stack([np.cos(turn), np.sin(turn)])
        drawing = Drawing.around(np.array([[-1.05, -1.25], [1.05, 1.05]]) * self.disc, 300.0, 260.0)
        dash(drawing, self.disc * circle)
        drawing.line(self.outlines(shape)[0].curve, CLOTH, 2.5, fill="cloth")
        drawing.line(self.plate * circle, "muted", 1.5, fill="grip")
        drawing.dimension((-self.plate, 0.0), (self.plate, 0.0), "plate")
        drawing.dimension((-self.disc, -1.15 * self.disc), (self.disc, -1.15 * self.disc), "disc")
        return drawing.svg()


def length_share(coefficient: float) -> float:
    """Return l_b / a for a drape coefficient, by the formula at the top of the module."""
    inside = float(np.clip(coefficient, 0.01, 0.99))
    return float(0.2545 * (inside / (1.0 - inside)) ** (1.0 / 2.95))
