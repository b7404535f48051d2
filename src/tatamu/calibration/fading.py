"""Test *fading*: the number of swings until a hanging cloth has slowed down determines the drag of air.

A plate that hangs by its edge is slowed by quadratic drag q_n. After n swings, the amplitude A of its lower edge is
given by

    1 / A = 1 / A_0 + 2 q_n n / (rho + m_a)

The derivation is in docs/theory/air.md. Cloth held by two corners is no plate, so q_n is adjusted until the simulated
cloth makes the counted number of swings.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from pydantic import model_validator

from tatamu.calibration.estimate import Fit
from tatamu.calibration.parameters import LIMITS
from tatamu.calibration.readings import Counts, Length, Lengths, TestEntry
from tatamu.calibration.swing import SwungTest
from tatamu.calibration.test import Readings, Specimen
from tatamu.simulation.material import Material
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Scene


class FadingReadings(TestEntry):
    """Readings of a cloth that is held by two corners and released from the side, until its swings have faded."""

    taken: ClassVar = {"count": ("count", "swings")}

    edge: str
    """Name of the edge whose two ends are held."""
    aside: Lengths
    """Distance by which the edge opposite to the held edge is pulled aside before its release [m]."""
    to: Length
    """Amplitude of the free edge, to one side, at which the counting of swings ends [m]."""
    count: Counts
    """Number of swings, there and back, until the amplitude is less than `to`. Half swings are counted too."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        aside = float(np.mean(self.aside))
        if not self.to <= 0.8 * aside:
            raise ValueError(
                f"`to` ({self.to:g} m) must be at most 0.8 times `aside` ({aside:g} m); count until the swings "
                "are smaller"
            )
        return self


@dataclass(frozen=True)
class Fading(SwungTest):
    """The test that counts the swings of a hanging cloth until they have faded."""

    to: float
    """Amplitude of the free edge, to one side, at which the counting of swings ends [m]."""
    counted: float
    """Number of swings that were counted. The simulation lasts a little longer."""

    name = "fading"
    parameter = "air_drag_quadratic"
    rising = False
    within = 5e-3
    replaces: ClassVar = {"air_drag": 0.0}  # the drag that was assumed
    entry = FadingReadings
    needs = ("swing",)
    asks = "directional_air"

    @classmethod
    def of(cls, entry: FadingReadings, specimen: Specimen) -> Self:
        return cls(specimen.garment, entry.edge, float(np.mean(entry.aside)), entry.to, float(np.mean(entry.count)))

    def scene(self, material: Material) -> Scene:
        return self.released(material.model_copy(update={"air_drag": 0.0}), 1.3 * self.counted + 2.0)

    def reading(self, rollout: Rollout) -> float:
        first, found = self.swings(rollout)
        numbers = np.array([0.0, *(0.75 + 0.5 * k for k in range(len(found)))])
        inverse = np.maximum.accumulate([1.0 / first, *(2.0 / each.amplitude for each in found)])
        if inverse[-1] >= 1.0 / self.to:
            return float(np.interp(1.0 / self.to, inverse, numbers))
        slope = (inverse[-1] - inverse[0]) / max(numbers[-1], 1.0)
        ends = numbers[-1] + (1.0 / self.to - inverse[-1]) / max(slope, 1e-9)
        return float(min(ends, 200.0))  # the most, for swings that do not fade, too

    def guess(self, count: float, material: Material) -> float:
        inverse = 1.0 / self.to - 1.0 / self.aside
        heavy = material.areal_density + material.air_added_mass
        return float(np.clip(heavy * inverse / (2.0 * count), *LIMITS[self.parameter]))

    def derivatives(self, readings: Readings, fit: Fit) -> tuple[dict[str, float], dict[str, float]]:
        # The drag is q_n = (rho + m_a) (1 / to - 1 / aside) / 2 n. Here n is the number of swings, `aside` the first
        # amplitude and `to` the last one. The areal density rho and the added mass m_a are taken as equally large.
        by_count = 1.0 / fit.slope if fit.slope else -1.0 / readings["count"].value
        return {"areal_density": 0.5, "air_added_mass": 0.5}, {"count": by_count}

    def sentence(self, fit: Fit) -> str:
        return (
            f"Swings counted: {fit.measured:.1f} ± {fit.uncertainty:.1f}; simulated: {fit.simulated:.2f}, from "
            f"{1e3 * self.aside:.0f} to {1e3 * self.to:.0f} mm aside."
        )
