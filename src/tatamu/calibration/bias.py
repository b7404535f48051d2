"""Bias: how much longer the garment is hanging by one corner than lying; what shear stiffness it has.

Not in the paper. Woven cloth is stiff along its yarns and gives way on the bias, where a strip has

    4 / Y(45) = 1 / Y + 1 / Y_weft + 1 / G - 2 nu / sqrt(Y Y_weft)

(docs/theory/membrane.md), so that what hangs by a corner is longer mostly by 1 / G. L1 is read straight down from the
grip to the end farthest from it, L2 is the same distance lying, as in the elongation.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Literal, Self

import numpy as np
from pydantic import model_validator

from tatamu.calibration.drawing import hanging
from tatamu.calibration.edges import longest_edge
from tatamu.calibration.elongation import HUNG_BY, OTHER_GARMENT, Elongation, Grasp
from tatamu.calibration.entry import Errors, TestEntry
from tatamu.calibration.fit import Fit
from tatamu.calibration.laboratory import Laboratory
from tatamu.calibration.parameters import PLACE
from tatamu.calibration.quantity import Lengths
from tatamu.calibration.readings import Reading
from tatamu.calibration.target import Target
from tatamu.calibration.test import POOR, Changes, LaterTest, Readings, Specimen, millimetres
from tatamu.errors import InputError
from tatamu.garments import Garment
from tatamu.material import GRAVITY, Material
from tatamu.rollout import Rollout
from tatamu.scene import Scene
from tatamu.simulators import capabilities

if TYPE_CHECKING:
    from tatamu.calibration.result import Calibration

PINCH = 0.03
"""Width of the grip along the edge [m]."""
PART = 0.5
"""The corner's share of the elongation of a strip on the bias: its upper part is narrow, its lower part carries
little. Where the search begins."""


class BiasReadings(TestEntry):
    """Length of the garment hanging by one corner, and the same lying."""

    edge: str
    """Name of an edge that ends at the corner."""
    end: Literal["start", "end"] = "start"
    """At which of its ends the corner is."""
    L1: Lengths
    """From the corner straight down to the end farthest from it, hanging [m]."""
    L2: Lengths
    """The same two places, lying [m]."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        hung = float(np.mean(self.L1))
        lying = float(np.mean(self.L2))
        if not lying < hung < 1.5 * lying:
            raise ValueError(f"L1 ({hung:g} m, hanging) must be above L2 ({lying:g} m, lying) and below 1.5 L2")
        return self

    def readings(self, errors: Errors) -> dict[str, Reading]:
        """See `TestEntry.readings`."""
        return {"bias_L1": Reading.of(self.L1, errors.length), "bias_L2": Reading.of(self.L2, errors.length)}


@dataclass(frozen=True)
class Bias(LaterTest):
    """The garment hung by a corner."""

    hung: Elongation

    name = "bias"
    title = "Bias: shear stiffness G"
    parameter = "shear_stiffness"
    entry = BiasReadings
    needs = ("elongation",)
    needs_because = "it is longer by the stiffness along its yarns too"
    read = "L1 - L2 by the corner"
    words = MappingProxyType({"bias_L1": "L1 by the corner", "bias_L2": "L2 by the corner"})
    instructions = """\
Hang it by a corner, if you like: for woven cloth, cut along its yarns.           [bias] edge, end, L1, L2
   Pinch the corner, 3 cm wide along the named edge, and let the rest hang. L1: from the grip straight down to the end
   farthest from it. L2: the same two places, lying without a pull.
"""

    @classmethod
    def of(cls, entry: BiasReadings, specimen: Specimen) -> Self:
        """See `CalibrationTest.of`."""
        at = 0.0 if entry.end == "start" else 1.0
        test = cls(Elongation(specimen.garment, (Grasp(edge=entry.edge, at=at, width=PINCH),)))
        lying = float(np.mean(entry.L2))
        if abs(lying / test.hung.length - 1.0) > OTHER_GARMENT:
            raise InputError(
                f"bias: L2 ({lying:g} m) is not of this garment, which lies {test.hung.length:.2f} m long from that "
                "corner to the end farthest from it"
            )
        return test

    @classmethod
    def template(cls, garment: Garment) -> str:
        """See `CalibrationTest.template`."""
        edge = (HUNG_BY.get(garment.name) or [longest_edge(garment)])[0]
        return f"""\
# [bias]                 # optional: hung by one corner; tells the shear stiffness of woven cloth
# edge = "{edge}"
# end = "start"          # at which end of it the corner is: "start" or "end"
# L1 = []                # hanging, from the corner straight down to the farthest end
# L2 = []                # lying
"""

    def unusable(self, simulator: str) -> str | None:
        """See `CalibrationTest.unusable`."""
        return None if capabilities(simulator).orthotropy else "knows no shear stiffness of its own"

    def scene(self, material: Material) -> Scene:
        """See `CalibrationTest.scene`."""
        return self.hung.scene(material.model_copy(update={"compression": 1.0}))

    def reading(self, rollout: Rollout, frame: int = -1) -> float:
        """L1 - L2 of a rollout [m]."""
        return self.hung.reading(rollout, frame)

    def guess(self, longer: float, density: float) -> float:
        """Shear stiffness of a corner that hangs longer by this, of a strip on the bias [N/m]."""
        return PART * density * GRAVITY * self.hung.length**2 / (8.0 * max(longer, 1e-4))

    def target(self, readings: Readings) -> Target:
        """See `ElasticTest.target`."""
        hung, lying = (readings[name] for name in ("bias_L1", "bias_L2"))
        longer = hung.value - lying.value
        error = float(np.hypot(hung.uncertainty, lying.uncertainty))
        return Target(
            test=self,
            parameter=self.parameter,
            measured=longer,
            uncertainty=error,
            bound="at least" if longer < error else None,
            guess=self.guess,
            straight=lambda value: float(np.log(max(value, 1e-6))),
        )

    def find(self, laboratory: Laboratory, material: Material, readings: Readings) -> tuple[Material, Fit]:
        """Search the shear stiffness."""
        target = self.target(readings)
        found = target.matched(laboratory, material, target.start(material.areal_density))
        return material.model_copy(update={self.parameter: found.parameter}), target.fit(found, found.reading)

    def propagate(self, changes: Changes, readings: Readings, fit: Fit) -> None:
        """See `LaterTest.propagate`; of G as rho over the elongation."""
        by_length = 1.0 / fit.slope if fit.slope else -1.0 / max(fit.measured, fit.uncertainty)
        own = {"bias_L1": by_length, "bias_L2": -by_length}
        for name, change in changes.items():
            change[PLACE[self.parameter]] = change[PLACE["areal_density"]]
            if name in own:
                change[PLACE[self.parameter]] += own[name] * readings[name].uncertainty

    def advice(self, calibration: Calibration, fit: Fit) -> list[str]:
        """See `CalibrationTest.advice`."""
        shear = getattr(calibration.material, self.parameter)
        read = f"bias: {millimetres(fit.measured)}"
        if fit.bound:
            return [
                f"{read} is within the error of reading it ({millimetres(fit.uncertainty)}): G is {fit.bound} "
                f"{shear:.3g} N/m. A larger piece of the cloth would hang longer."
            ]
        relative = calibration.relative(self.parameter)
        return (
            [] if relative <= POOR else [f"{read} tells G to {100 * relative:.0f} % only: read L1 and L2 more often."]
        )

    def drawing(self, shape: np.ndarray | None) -> str:
        """See `CalibrationTest.drawing`."""
        return "" if shape is None else hanging(self.hung, shape)
