"""Test *fading*: the number of swings until a hanging cloth has slowed down determines the drag of air.

This test is not in the paper. The cloth is held by two corners. A plate that hangs by its edge is slowed by quadratic
drag q_n [kg/m^3]. In each swing, the amplitude A of its lower edge falls by the fraction 2 q_n A / (rho + m_a). Here
rho is the areal density, and m_a is the added mass of air [kg/m^2]. After n swings that start with the amplitude A_0,
the amplitude A is given by

    1 / A = 1 / A_0 + 2 q_n n / (rho + m_a)

The derivation is in docs/theory/air.md. Cloth held by two corners is not a plate, so this formula is only approximate.
The cloth is therefore simulated. q_n is adjusted until the simulated cloth makes the counted number of swings.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from tatamu.calibration.edges import longest_edge
from tatamu.calibration.elongation import HUNG_BY
from tatamu.calibration.entry import Errors, TestEntry
from tatamu.calibration.estimate import Estimate
from tatamu.calibration.fit import Fit
from tatamu.calibration.instruments.oscillation import swings
from tatamu.calibration.laboratory import Laboratory
from tatamu.calibration.parameters import LIMITS, PLACE
from tatamu.calibration.quantity import Length, Lengths
from tatamu.calibration.readings import Reading
from tatamu.calibration.swing import LEAST, Swinging, SwungTest
from tatamu.calibration.test import Changes, Readings, Specimen
from tatamu.garments import Garment
from tatamu.simulation.material import Material
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Scene
from tatamu.simulation.simulators import capabilities

MORE = 1.3
"""Factor from the counted number of swings to the number of simulated swings.

Two further swings are added to the product.
"""
MOST = 200.0
"""Largest number of swings that the simulated reading can have.

If the swings fade more slowly, or not at all, the reading is this number.
"""
WITHIN = 5e-3
"""Largest accepted difference between the simulated and the counted number of swings, as a fraction."""


class FadingReadings(TestEntry):
    """Readings of a cloth that is held by two corners and released from the side, until its swings have faded."""

    edge: str
    """Name of the edge whose two ends are held."""
    aside: Lengths
    """Distance by which the edge opposite to the held edge is pulled aside before its release [m]."""
    to: Length
    """Amplitude of the free edge, to one side, at which the counting of swings ends [m]."""
    count: Annotated[tuple[Annotated[float, Field(gt=0.0, le=100.0)], ...], Field(min_length=1)]
    """Number of swings, there and back, until the amplitude is less than `to`. Half swings are counted too."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        aside = float(np.mean(self.aside))
        if not self.to <= 0.8 * aside:
            raise ValueError(f"to ({self.to:g} m) must be at most 0.8 of aside ({aside:g} m): it has to fade")
        return self

    def readings(self, errors: Errors) -> dict[str, Reading]:
        """Return the readings by their names; see `TestEntry.readings`."""
        return {"count": Reading.of(self.count, errors.swings, "-")}


@dataclass(frozen=True)
class Fading(SwungTest):
    """The test that counts the swings of a hanging cloth until they have faded."""

    to: float
    """Amplitude of the free edge, to one side, at which the counting of swings ends [m]."""
    counted: float
    """Number of swings that were counted. The simulation lasts a little longer."""

    name = "fading"
    title = "Fading: drag of the air q_n"
    parameter = "air_drag_quadratic"
    unit = "-"
    rising = False
    entry = FadingReadings
    needs = ("swing",)
    needs_because = "the air that swings with the cloth has to be slowed as well"
    read = "swings until it has faded"
    words = MappingProxyType({"count": "the number of swings until it has faded"})
    instructions = """\
Count its swings (optional): for cloth that hands move fast.                   [fading] edge, aside, to, count
   Swing the garment as in measurement $swing, with a ruler across it below the far edge. count: the number of swings
   there and back until the edge moves less than `to` to the side. A quarter of `aside` is a good `to`. Half swings
   count too.
"""

    @classmethod
    def of(cls, entry: FadingReadings, specimen: Specimen) -> Self:
        """Return the simulated copy of this measurement; see `CalibrationTest.of`."""
        swinging = Swinging(specimen.garment, entry.edge, float(np.mean(entry.aside)))
        swinging.check(cls.name)
        return cls(swinging, entry.to, float(np.mean(entry.count)))

    @classmethod
    def template(cls, garment: Garment) -> str:
        """Return this test's part of an empty measurements file; see `CalibrationTest.template`."""
        edge = (HUNG_BY.get(garment.name) or [longest_edge(garment)])[0]
        return f"""\
# [fading]               # optional: the same, until it swings less than `to`; tells the drag of the air
# edge = "{edge}"
# aside = 0.10           # how far the far edge is drawn aside
# to = 0.025             # counted until it goes less than this to the side
# count = []             # swings there and back until then; halves count too
"""

    def unusable(self, simulator: str) -> str | None:
        """Return why a simulator cannot do this test; see `CalibrationTest.unusable`."""
        return None if capabilities(simulator).directional_air else "knows no drag by the square of a velocity"

    def scene(self, material: Material) -> Scene:
        """Return the scene of this test; see `CalibrationTest.scene`."""
        return self.swinging.scene(material.model_copy(update={"air_drag": 0.0}), MORE * self.counted + 2.0)

    def reading(self, rollout: Rollout) -> float:
        """Return the number of swings until the amplitude is less than `to` [-], interpolated between swings."""
        signal = self.swinging.signal(rollout)
        found = swings(rollout.times, signal, LEAST * abs(float(signal[0])))
        numbers = np.array([0.0, *(0.75 + 0.5 * k for k in range(len(found)))])
        inverse = np.maximum.accumulate([1.0 / abs(float(signal[0])), *(2.0 / each.amplitude for each in found)])
        if inverse[-1] >= 1.0 / self.to:
            return float(np.interp(1.0 / self.to, inverse, numbers))
        slope = (inverse[-1] - inverse[0]) / max(numbers[-1], 1.0)
        return float(min(numbers[-1] + (1.0 / self.to - inverse[-1]) / max(slope, 1e-9), MOST))

    def guess(self, count: float, material: Material) -> float:
        """Return the quadratic drag of a plate that fades in `count` swings [kg/m^3].

        The drag follows from the formula at the top of the module.
        """
        inverse = 1.0 / self.to - 1.0 / self.swinging.aside
        heavy = material.areal_density + material.air_added_mass
        return float(np.clip(heavy * inverse / (2.0 * count), *LIMITS[self.parameter]))

    def find(self, laboratory: Laboratory, material: Material, readings: Readings) -> tuple[Material, Fit]:
        """Search for the drag at which the simulated cloth fades in the counted number of swings."""
        found, fit = self.matched(laboratory, material, readings["count"], WITHIN)
        # the drag that this test found replaces the assumed drag
        return material.model_copy(update={self.parameter: found.parameter, "air_drag": 0.0}), fit

    def propagate(self, changes: Changes, readings: Readings, fit: Fit) -> None:
        """Add the effects of uncertain readings on the drag q_n to `changes`; see `LaterTest.propagate`.

        The drag is q_n = (rho + m_a) (1 / to - 1 / aside) / 2 n. Here n is the number of swings, `aside` the first
        amplitude and `to` the last amplitude. To estimate the uncertainty, the areal density rho and the added mass m_a
        are assumed to be equally large.
        """
        density, air = (PLACE[name] for name in ("areal_density", "air_added_mass"))
        for change in changes.values():
            change[PLACE[self.parameter]] += 0.5 * (change[density] + change[air])
        measured = readings["count"]
        by_count = 1.0 / fit.slope if fit.slope else -1.0 / measured.value
        changes["count"][PLACE[self.parameter]] += by_count * measured.uncertainty

    def sentence(self, fit: Fit) -> str:
        """Return a sentence on the reading; see `CalibrationTest.sentence`."""
        return (
            f"Swings counted: {fit.measured:.1f} ± {fit.uncertainty:.1f}; simulated: {fit.simulated:.2f}, from "
            f"{1e3 * self.swinging.aside:.0f} to {1e3 * self.to:.0f} mm aside."
        )

    def advice(self, estimate: Estimate, fit: Fit) -> list[str]:
        """Return advice on this test; see `CalibrationTest.advice`."""
        if fit.bound is None:
            return []
        does = "fades sooner even without drag" if fit.bound == "at most" else "goes on longer whatever the drag"
        return [f"fading: {fit.measured:g} swings were counted, but the simulated cloth {does}: was the air still?"]
