"""Test *swing*: the time of ten swings of a cloth held by two corners determines the added mass of air.

A plate of length L that hangs by its edge swings with the period T = 2 pi sqrt(2 L (rho + m_a) / (3 g rho)), because
the air that it moves adds inertia but no weight (docs/theory/air.md). Cloth held by two corners is no plate, so m_a is
adjusted until the simulated cloth has the measured period.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Self

import numpy as np
from pydantic import model_validator

from tatamu.base.errors import InputError
from tatamu.calibration.elongation import HUNG_BY, Elongation, Grasp, longest_edge
from tatamu.calibration.estimate import Fit
from tatamu.calibration.instruments.oscillation import FreeSwing, swings
from tatamu.calibration.laboratory import Laboratory
from tatamu.calibration.match import match
from tatamu.calibration.parameters import LIMITS
from tatamu.calibration.readings import Lengths, TestEntry, Times
from tatamu.calibration.test import CLOTH, LaterTest, Readings, Specimen, dash
from tatamu.garments import Garment
from tatamu.show.drawing import Drawing
from tatamu.simulation.material import GRAVITY, Material
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Scene

SIMULATED = 4
"""Number of simulated swings, whose mean period is used."""
MIN_AMPLITUDE = 0.004
"""Smallest amplitude of a swing that counts, as a fraction of the distance by which the cloth is pulled aside."""


class SwingReadings(TestEntry):
    """Readings of a cloth that is held by two corners and released from the side, and makes ten swings."""

    taken: ClassVar = {"ten_swings": ("ten_swings", "time")}

    edge: str
    """Name of the edge whose two ends are held."""
    aside: Lengths
    """Distance by which the edge opposite to the held edge is pulled aside before its release [m]."""
    ten_swings: Times
    """Time of ten swings, each there and back [s]."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        for seconds in self.ten_swings:
            if not 3.0 <= seconds <= 40.0:
                raise ValueError(
                    f"ten_swings must be from 3 to 40 s, given {seconds:g} s; give the time of ten swings, each there "
                    "and back"
                )
        return self


@dataclass(frozen=True)
class SwungTest(LaterTest):
    """A test of the swings of a garment that is held by the two ends of an edge, pulled aside and released."""

    garment: Garment
    edge: str
    aside: float
    """Distance by which the edge opposite to the held edge is pulled aside [m]."""

    rising: ClassVar[bool]
    """Whether the reading rises with the parameter; otherwise it falls."""
    within: ClassVar[float]
    """Relative accuracy with which the reading is reproduced."""
    replaces: ClassVar[Mapping[str, float]] = {}
    """Other fields of the material, with the values that they have beside the parameter that was found."""

    def __post_init__(self) -> None:
        if self.aside > 0.7 * self.hung.length:
            hangs = f"the length of the cloth below the held edge ({self.hung.length:.2f} m)"
            raise InputError(f"{self.name}: `aside` ({self.aside:g} m) must be at most 0.7 times {hangs}")

    @classmethod
    def blanks(cls, garment: Garment) -> dict[str, str]:
        return {"edge": (HUNG_BY.get(garment.name) or [longest_edge(garment)])[0]}

    @cached_property
    def hung(self) -> Elongation:
        """Test of the same garment, hanging still from the same two grips."""
        return Elongation(self.garment, tuple(Grasp(edge=self.edge, at=at, width=0.03) for at in (0.0, 1.0)))

    def released(self, material: Material, periods: float) -> Scene:
        """Return a scene in which the cloth starts as an inclined plane, for about `periods` periods of a plate."""
        scene = self.hung.scene(material)
        angle = np.arcsin(self.aside / self.hung.length)
        start = scene.cloth.vertices.copy()
        down = start[:, 2].copy()
        start[:, 0] -= np.sin(angle) * down
        start[:, 2] = np.cos(angle) * down
        air = material.air_added_mass / material.areal_density
        period = 2.0 * np.pi * np.sqrt(2.0 * self.hung.length * (1.0 + air) / (3.0 * GRAVITY))
        return scene.model_copy(
            update={
                "cloth": scene.cloth.model_copy(update={"vertices": start}),
                "material": material,
                "duration": float((periods + 0.5) * period),
                "frame_rate": 60.0,
            }
        )

    def swings(self, rollout: Rollout) -> tuple[float, list[FreeSwing]]:
        """Return the first displacement of the cloth's free edge to the side [m], and the edge's swings."""
        signal = np.asarray(rollout.positions[:, self.hung.end, 0].mean(axis=1))
        first = abs(float(signal[0]))
        return first, swings(rollout.times, signal, MIN_AMPLITUDE * first)

    def drawing(self, shape: np.ndarray) -> str:
        start = self.released(self.garment.material, 1.0).cloth.vertices
        length = self.hung.length
        x, z = start[self.hung.end].mean(axis=0)[[0, 2]]
        corners = np.array([[-0.35 * length, 0.05 * length], [1.2 * x + 0.1 * length, -1.12 * length]])
        drawing = Drawing.around(corners, 260.0, 260.0)
        drawing.line([(0.0, 0.0), (x, z)], CLOTH, 4.0)
        dash(drawing, [(0.0, 0.0), (0.0, -length)])
        drawing.line([(0.0, 0.0), (-0.9 * x, z)], "mesh", 2.0)
        drawing.line([(-0.06 * length, 0.0), (0.06 * length, 0.0)], "muted", 7.0)
        drawing.dimension((0.0, -1.06 * length), (x, -1.06 * length), "aside")
        return drawing.svg()

    @abstractmethod
    def reading(self, rollout: Rollout) -> float:
        """Return the reading of a simulated motion."""

    @abstractmethod
    def guess(self, reading: float, material: Material) -> float:
        """Return the parameter with which a rigid plate has this reading."""

    def find(self, laboratory: Laboratory, material: Material, readings: Readings) -> tuple[Material, Fit]:
        (measured,) = (readings[name] for name in self.entry.taken)

        def reading(value: float) -> float:
            changed = material.model_copy(update={self.parameter: value})
            return self.reading(laboratory.run(self.scene(changed), self.name))

        found = match(
            reading,
            measured.value,
            self.guess(measured.value, material),
            LIMITS[self.parameter],
            self.within * measured.value,
            lambda value: float(np.log(max(value, 1e-3))),
            self.rising,
        )
        beyond = "at most" if (found.reading > measured.value) == self.rising else "at least"
        fit = self.fit(measured, found.reading, None if found.reached else beyond, found.samples)
        return material.model_copy(update={self.parameter: found.parameter, **self.replaces}), fit


@dataclass(frozen=True)
class TenSwings(SwungTest):
    """The test that times ten swings of a cloth that is held by two corners."""

    drag: float | None
    """Quadratic drag that is assumed [kg/m^3], because air that adds mass also slows down; None for the material's."""

    name = "swing"
    parameter = "air_added_mass"
    rising = True
    within = 2e-3
    entry = SwingReadings
    asks = "directional_air"

    @classmethod
    def of(cls, entry: SwingReadings, specimen: Specimen) -> Self:
        drag = None if specimen.base.air_drag_quadratic else 0.7
        return cls(specimen.garment, entry.edge, float(np.mean(entry.aside)), drag)

    def scene(self, material: Material) -> Scene:
        drag = material.air_drag_quadratic if self.drag is None else self.drag
        own = material.model_copy(update={"air_drag_quadratic": drag, "air_drag": 0.0})
        return self.released(own, SIMULATED)

    def reading(self, rollout: Rollout) -> float:
        found = self.swings(rollout)[1][: 2 * SIMULATED - 2]
        return float(10 * np.mean([each.period for each in found])) if found else float("nan")

    def guess(self, seconds: float, material: Material) -> float:
        return float(np.clip(material.areal_density * (self.heavier(seconds) - 1.0), *LIMITS[self.parameter]))

    def heavier(self, seconds: float) -> float:
        """Return 1 + m_a / rho of a plate that swings ten times in this time."""
        return float((seconds / 10 / (2.0 * np.pi)) ** 2 * 3.0 * GRAVITY / (2.0 * self.hung.length))

    def derivatives(self, readings: Readings, fit: Fit) -> tuple[dict[str, float], dict[str, float]]:
        # The period of the swings depends on m_a / rho, where rho is the areal density.
        seconds = readings["ten_swings"].value
        heavier = self.heavier(seconds)  # without a slope, the derivative is that of a plate
        by_time = 1.0 / fit.slope if fit.slope else float(2.0 * heavier / max(heavier - 1.0, 0.02) / seconds)
        return {"areal_density": 1.0}, {"ten_swings": by_time}

    def sentence(self, fit: Fit) -> str:
        return f"Ten swings measured: {fit.measured:.1f} ± {fit.uncertainty:.1f} s; simulated: {fit.simulated:.2f} s."
