"""Test *plate*: the drape of a disc of cloth over a round plate determines the bending rigidity.

This test is not in the paper. A disc of cloth hangs over a smaller plate, in folds, and is seen from above. The drape
coefficient is

    DC = (A_outline - A_plate) / (A_disc - A_plate)

It compares three areas, all seen from above: the area in the cloth's outline, the plate, and the flat disc. The
simulation must reproduce the radius of the circle that has the same area as the outline.

The coefficient grows with the bending length l_b divided by the overhang a, the width of the cloth outside the plate.
The relation is about DC / (1 - DC) = (l_b / a / 0.255)^2.95. The search starts from this formula. The formula was
fitted to simulations in which the disc was 1.7 or 2 times as wide as the plate, and the stretch stiffness was 300 N/m.

The positions of the folds are random. Therefore two discs are simulated side by side, and the mean of their results is
used. The differences between the two discs, in all simulations, are counted in the uncertainty.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Annotated, Any, Self

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from tatamu.calibration.entry import Errors, TestEntry
from tatamu.calibration.estimate import Estimate
from tatamu.calibration.fit import Fit
from tatamu.calibration.instruments.drapemeter import Drapemeter
from tatamu.calibration.instruments.outline import PlanOutline
from tatamu.calibration.picture import CLOTH, DASH
from tatamu.calibration.quantity import Length
from tatamu.calibration.readings import Reading, uncertainty
from tatamu.calibration.target import Target, textbook_spread
from tatamu.calibration.test import ElasticTest, Readings, Specimen
from tatamu.garments import Garment
from tatamu.show.drawing import Drawing
from tatamu.simulation.material import GRAVITY, Material
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Cloth, Gripper, Scene

HALF, POWER = 0.2545, 2.95
"""The two numbers in the formula at the top of the module.

The first number is the ratio of bending length to overhang at which the drape coefficient is 1/2. The second number is
the exponent of this ratio.
"""
DISCS = 2
"""Number of discs that are simulated side by side."""
APART = 2.6
"""Distance between the centres of the two discs, in radii of the discs."""
CELL = 0.45
"""Edge length of the mesh divided by the bending length, which follows from the formula at the top of the module."""
FINEST, COARSEST = 0.06, 0.2
"""Smallest and largest edge length of the mesh divided by the overhang."""
ANGLES = 180
"""Number of points of a disc's outline, at equal angles around the centre of the plate."""
SETTLING = 4.0
"""Time from the end of the plate's rise to the reading [s]."""
LIMPEST, STIFFEST = 0.08, 0.93
"""Smallest and largest drape coefficient that determines the bending rigidity. Other coefficients only give a bound."""
STEP = 0.4
"""Step of a parameter's logarithm for numerical derivatives of the reading.

The step is large, so that the differences of readings exceed their random scatter.
"""
FOLDS = 2
"""Largest accepted difference between the counted and the simulated number of folds.

The user is told about a larger difference.
"""


def _coefficients(value: Any) -> tuple[float, ...]:
    given = value if isinstance(value, list | tuple) else [value]
    if not given:
        raise ValueError("must hold at least one reading, given none")
    for each in given:
        if isinstance(each, bool) or not isinstance(each, int | float) or not 0.0 < each < 1.0:
            hint = (
                f": if that was in per cent, write {each / 100:g}" if isinstance(each, int | float) and each > 1 else ""
            )
            raise ValueError(f"must be between 0 and 1, given {each!r}{hint}")
    return tuple(float(each) for each in given)


Coefficients = Annotated[tuple[float, ...], BeforeValidator(_coefficients)]


class PlateReadings(TestEntry):
    """Readings of a disc of cloth over a plate, as seen from above."""

    disc: Length
    """Diameter of the disc of cloth [m]."""
    plate: Length
    """Diameter of the plate [m]."""
    drape_coefficient: Coefficients
    """Drape coefficient [-].

    It is the area of the cloth outside the plate, seen from above, divided by this area of the flat disc.
    """
    nodes: tuple[Annotated[int, Field(ge=0, le=60)], ...] = ()
    """Number of folds at the edge of the cloth.

    The number is compared with the simulated number, but does not determine a parameter.
    """

    @model_validator(mode="after")
    def _check(self) -> Self:
        if not 1.3 <= self.disc / self.plate <= 2.5:
            raise ValueError(
                f"disc ({self.disc:g} m) must be 1.3 to 2.5 times plate ({self.plate:g} m), given "
                f"{self.disc / self.plate:.2f}: diameters, not radii"
            )
        return self

    def readings(self, errors: Errors) -> dict[str, Reading]:
        """Return the readings by their names; see `TestEntry.readings`."""
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
    title = "Plate: bending rigidity B"
    parameter = "bending_rigidity"
    entry = PlateReadings
    read = "mean radius of the hem"
    words = MappingProxyType({"hem": "the drape coefficient"})
    reads = MappingProxyType({"hem": 1.0})
    step = STEP
    instructions = """\
Drape it (optional): a disc of the same cloth, such as a napkin.    [plate] disc, plate, drape_coefficient, nodes
   Take a round plate, half to two thirds as wide as the disc, and a can to stand it on. Centre the disc on the plate
   while that lies on the table, and press it flat. Lift both onto the can and let the cloth come to rest. Photograph it
   straight from above, with a ruler beside it at the height of the plate. `tatamu measure --drape PHOTO ..` reads the
   coefficient and the number of folds (nodes). Turn the disc over and repeat, because it folds differently each time.
"""

    @classmethod
    def of(cls, entry: PlateReadings, specimen: Specimen) -> Self:
        """Return the simulated copy of this measurement; see `CalibrationTest.of`."""
        folds = float(np.mean(entry.nodes)) if entry.nodes else None
        mean = float(np.mean(entry.drape_coefficient))
        return cls(0.5 * entry.disc, 0.5 * entry.plate, mean, folds, specimen.spacing)

    @classmethod
    def template(cls, garment: Garment) -> str:
        """Return this test's part of an empty measurements file; see `CalibrationTest.template`."""
        return """\
# [plate]                # optional: a disc of the cloth over a round plate, from above; tells B too
# disc = 0.30            # diameter of the cloth
# plate = 0.18           # diameter of the plate
# drape_coefficient = [] # between 0 and 1: `tatamu measure --drape PHOTO ..` reads it
# nodes = []             # folds of the hem
"""

    @property
    def overhang(self) -> float:
        """Overhang a: the width of the cloth outside the plate's rim [m]."""
        return self.disc - self.plate

    @cached_property
    def discs(self) -> list[Drapemeter]:
        """The simulated discs of cloth, each on its plate."""
        cell = CELL * self.overhang * length_share(self.coefficient)
        edge = self.spacing or float(np.clip(cell, FINEST * self.overhang, COARSEST * self.overhang))
        return [Drapemeter(self.disc, self.plate, edge, DISCS * self.seed + number) for number in range(DISCS)]

    def scene(self, material: Material) -> Scene:
        """Return the scene of this test. Two discs are raised side by side and come to rest."""
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
                "duration": first.grippers[0].times[-1] + SETTLING,
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
                ANGLES,
            )
            for number, disc in enumerate(self.discs)
        ]

    def reading(self, rollout: Rollout, frame: int = -1) -> float:
        """Return the radius of the circle that has the mean area of the simulated outlines [m]."""
        areas = [outline.area for outline in self.outlines(rollout.positions[frame])]
        return float(np.sqrt(np.mean(areas) / np.pi))

    def chance(self, shapes: Sequence[np.ndarray]) -> float:
        """Return the uncertainty due to the random positions of folds; see `ElasticTest.chance`."""
        radii = np.sqrt([[outline.area / np.pi for outline in self.outlines(shape)] for shape in shapes])
        return float(np.sqrt(radii.var(axis=1, ddof=1).mean() / DISCS))

    def coefficient_of(self, radius: float) -> float:
        """Return the drape coefficient of an outline with this mean radius [m]."""
        return (radius**2 - self.plate**2) / (self.disc**2 - self.plate**2)

    def guess(self, radius: float, material: Material) -> float:
        """Return the bending rigidity for this mean radius [N m], by the formula at the top of the module."""
        return material.areal_density * GRAVITY * (self.overhang * length_share(self.coefficient_of(radius))) ** 3

    def target(self, readings: Readings) -> Target:
        """Return what the simulated reading must reach; see `RestTest.target`."""
        hem = readings["hem"]
        low, high = (self.coefficient_of(hem.value + sign * hem.uncertainty) for sign in (-1.0, 1.0))
        return Target(
            test=self,
            parameter=self.parameter,
            measured=hem.value,
            uncertainty=hem.uncertainty,
            bound="at most" if low < LIMPEST else "at least" if high > STIFFEST else None,
            guess=self.guess,
            straight=lambda radius: float(np.log(length_share(self.coefficient_of(radius)))),
            rising=True,
            spread=textbook_spread(self.guess, hem),
        )

    def sentence(self, fit: Fit) -> str:
        """Return a sentence on the reading; see `CalibrationTest.sentence`."""
        measured, simulated = (100.0 * self.coefficient_of(radius) for radius in (fit.measured, fit.simulated))
        error = 100.0 * fit.uncertainty * 2.0 * fit.measured / (self.disc**2 - self.plate**2)
        return f"Drape coefficient measured: {measured:.1f} ± {error:.1f} %; simulated: {simulated:.1f} %."

    def advice(self, estimate: Estimate, fit: Fit) -> list[str]:
        """Return advice on this test; see `CalibrationTest.advice`."""
        if fit.bound is None:
            return []
        side, other = ("limp", "smaller") if fit.bound == "at most" else ("stiff", "larger")
        return [
            f"plate: the cloth is too {side} for this plate to tell B, which is {fit.bound} "
            f"{1e6 * estimate.material.bending_rigidity:.2g} µN m; a disc with {other} overhang would tell."
        ]

    def remark(self, estimate: Estimate, fit: Fit) -> list[str]:
        """Return a note if the real and the simulated cloth have different numbers of folds."""
        shape = estimate.shapes.get(self.name)
        if shape is None or self.folds is None:
            return []
        simulated = float(np.mean([outline.nodes for outline in self.outlines(shape)]))
        if abs(simulated - self.folds) <= FOLDS:
            return []
        return [
            f"plate: {self.folds:g} folds were counted, the simulated cloth has {simulated:g}: warp and weft may "
            "differ in bending, or the cloth may shear more easily than is assumed."
        ]

    def drawing(self, shape: np.ndarray | None) -> str:
        """Draw the disc on its plate, as seen from above."""
        if shape is None:
            return ""
        turn = np.linspace(0.0, 2.0 * np.pi, 181)
        circle = np.column_stack([np.cos(turn), np.sin(turn)])
        drawing = Drawing.around(np.array([[-1.05, -1.25], [1.05, 1.05]]) * self.disc, 300.0, 260.0)
        drawing.line(self.disc * circle, "muted", 1.0, dash=DASH)
        drawing.line(self.outlines(shape)[0].curve, CLOTH, 2.5, fill="cloth")
        drawing.line(self.plate * circle, "muted", 1.5, fill="grip")
        drawing.dimension(np.array([-self.plate, 0.0]), np.array([self.plate, 0.0]), "plate")
        low = -1.15 * self.disc
        drawing.dimension(np.array([-self.disc, low]), np.array([self.disc, low]), "disc")
        return drawing.svg()


def length_share(coefficient: float) -> float:
    """Return the bending length divided by the overhang, for a drape coefficient.

    The result follows from the formula at the top of the module.
    """
    inside = float(np.clip(coefficient, 0.01, 0.99))
    return float(HALF * (inside / (1.0 - inside)) ** (1.0 / POWER))
