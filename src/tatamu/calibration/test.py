"""A calibration test: a measurement, its simulated copy, and the parameter that the test determines.

Each test is one module, and texts/NAME.toml has what the user is told to do, writes down, and is told of the result.

- `ElasticTest`: a length at rest. The parameters of these tests are found together, because each length depends on
  stretch stiffness, bending rigidity and friction of bending.
- `LaterTest`: a test that finds its parameter when these three are known, in the order of `measurements.TESTS`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, ClassVar, Literal, Self

import numpy as np

from tatamu.base.errors import SimulationError
from tatamu.base.files import read_toml
from tatamu.calibration.estimate import Estimate, Fit, Samples
from tatamu.calibration.laboratory import Laboratory
from tatamu.calibration.match import Match, match
from tatamu.calibration.parameters import KNOWN, LIMITS, PLACE
from tatamu.calibration.readings import Reading, TestEntry
from tatamu.garments import Garment
from tatamu.show.drawing import Drawing
from tatamu.show.quantity import factor
from tatamu.simulation.material import Material
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Scene
from tatamu.simulation.simulators import capabilities

CLOTH = "plot"
"""Name of the colour with which drawings show cloth."""
POOR = 0.25
"""Maximum relative standard uncertainty of a parameter of which the user is not told."""
Readings = Mapping[str, Reading]
"""Readings by their names."""
Changes = dict[str, np.ndarray]
"""By reading: the changes of the logarithms of all `PARAMETERS` by one standard uncertainty of the reading."""


@dataclass(frozen=True)
class Specimen:
    """The simulated copy of the garment that was measured."""

    garment: Garment
    base: Material
    """Material before the calibration."""
    spacing: float | None
    """Mesh spacing [m]; None for meshes so fine that it does not matter."""


class CalibrationTest(ABC):
    """Base class of all calibration tests."""

    name: ClassVar[str]
    """Name of the test, and of its table in the measurements file."""
    parameter: ClassVar[str]
    """Field of a material that the test determines."""
    entry: ClassVar[type[TestEntry]]
    """Class of the test's table in the measurements file."""
    needs: ClassVar[tuple[str, ...]] = ()
    """Tests whose results this test needs."""
    yields_to: ClassVar[tuple[str, ...]] = ()
    """Tests that replace this test, because no material can have both parameters."""
    asks: ClassVar[str | None] = None
    """Capability that a simulator needs for this test; None for none."""
    samples: ClassVar[Literal["reading", "speed"]] = "reading"
    """What each simulation gives: the reading, or the speed of the cloth [m/s]."""

    @classmethod
    @abstractmethod
    def of(cls, entry: Any, specimen: Specimen) -> Self:
        """Make the simulated copy of a measurement from the test's table in the measurements file.

        Raises:
            InputError: If the specimen cannot have these readings.
        """

    @classmethod
    def blanks(cls, garment: Garment) -> dict[str, str]:
        """Return what the text `template` has, the test's part of a measurements file, for each `$name`."""
        return {}

    @abstractmethod
    def scene(self, material: Material) -> Scene:
        """Return the simulated scene of this test with a material."""

    @abstractmethod
    def drawing(self, shape: np.ndarray) -> str:
        """Return a drawing of the test as SVG, from the positions of its cloth at rest [m], shape (n, 3)."""

    def record(self) -> dict[str, float]:
        """Return additional entries for the table [calibration] of the material's file."""
        return {}

    @property
    def texts(self) -> dict[str, Any]:
        """What the user is told of this test, by the names of the texts."""
        return texts(self.name)

    def unusable(self, simulator: str) -> str | None:
        """Return why a simulator cannot do this test; None if it can."""
        able = self.asks is None or getattr(capabilities(simulator), self.asks)
        return None if able else str(self.texts["without"])

    def sentence(self, fit: Fit) -> str:
        """Return a sentence on the measured and the simulated reading."""
        read = self.texts["read"]
        return (
            f"{read[0].upper()}{read[1:]} measured: {1e3 * fit.measured:.1f} ± {1e3 * fit.uncertainty:.1f} "
            f"mm; simulated: {1e3 * fit.simulated:.2f} mm."
        )

    def fit(self, read: Reading, simulated: float, bound: str | None, samples: Samples, **more: Any) -> Fit:
        """Return the result of this test for a measured reading. `more` are other fields of a `Fit`."""
        made: dict[str, Any] = {
            "measured": read.value,
            "uncertainty": read.uncertainty,
            "aim": read.value,
            "unit": read.unit,
            **more,
        }
        return Fit(self.name, self.parameter, simulated=simulated, bound=bound, samples=samples, **made)

    def advice(self, estimate: Estimate, fit: Fit) -> list[str]:
        """Return advice to the user: the text `at_most`, `at_least` or `bound` if this test only bounds the parameter.

        If the relative uncertainty of the parameter is large, it is the text `poor`. In a text, `value`, and `alone` by
        this test alone, are the parameter in its unit for readers.
        """
        known = self.texts
        relative = estimate.relative(self.parameter)
        if fit.bound:
            text = known.get(fit.bound.replace(" ", "_")) or known["bound"]
        else:
            text = known.get("poor", "") if relative > POOR else ""
        scale = factor(KNOWN[self.parameter].unit)
        value = getattr(estimate.material, self.parameter)
        general = {
            "measured": millimetres(fit.measured),
            "error": millimetres(fit.uncertainty),
            "reading": fit.measured,
            "bound": fit.bound,
            "value": scale * value,
            "alone": scale * (fit.alone or value),
            "percent": 100 * relative,
            "simulator": estimate.simulator,
        }
        return [text.format(**general, **self.advice_values(estimate))] if text else []

    def advice_values(self, estimate: Estimate) -> dict[str, Any]:
        """Return what only the texts of this test have for a `{name}`."""
        return {}

    def remark(self, estimate: Estimate, fit: Fit) -> list[str]:
        """Return sentences that are printed after all advice."""
        return []


class RestTest(CalibrationTest):
    """A test whose reading is a length of cloth at rest."""

    reads: ClassVar[Mapping[str, float]]
    """Factor of each reading in the measured length, which is their sum."""
    rising: ClassVar[bool] = False
    """Whether the length rises with the parameter; otherwise it falls."""

    @abstractmethod
    def reading(self, rollout: Rollout, frame: int = -1) -> float:
        """Return the length that a ruler would read on the simulated cloth [m]."""

    @abstractmethod
    def guess(self, reading: float, material: Material, /) -> float:
        """Return the parameter by a textbook formula, from the reading [m] and the other parameters of a material."""

    def bound(self, measured: float, error: float) -> str | None:
        """Return "at least" or "at most" if a length with an error [m] only bounds the parameter; otherwise None."""
        return "at least" if measured < error else None

    def straight(self, reading: float) -> float:
        """Return a function of the length that is nearly linear in the logarithm of the parameter."""
        return float(np.log(max(reading, 1e-6)))

    def target(self, readings: Readings) -> Target:
        """Return what the simulation must reproduce: the measured length, and whether it only bounds the parameter."""
        length = sum(factor * readings[name].value for name, factor in self.reads.items())
        error = float(np.hypot.reduce([readings[name].uncertainty for name in self.reads]))
        read = Reading(length, error)
        return Target(self, read, self.bound(length, error), textbook_spread(self.guess, read))


class ElasticTest(RestTest):
    """A test whose length at rest depends on stretch stiffness and bending, and determines one of these parameters."""

    weighs: ClassVar[bool] = True
    """Whether the length depends on the cloth's own weight."""
    size: ClassVar[str | None] = None
    """Name of the reading to which all lengths of the simulated test are proportional, if any."""
    step: ClassVar[float] = 0.1
    """Step of a parameter's logarithm for numerical derivatives of the length."""

    def chance(self, shapes: Sequence[np.ndarray]) -> float:
        """Return the standard uncertainty of the length due to random folds [m], from all shapes that were tried."""
        return 0.0


class LaterTest(CalibrationTest):
    """A test that finds its parameter after the stretch stiffness and the bending parameters are known."""

    @abstractmethod
    def find(self, laboratory: Laboratory, material: Material, readings: Readings) -> tuple[Material, Fit]:
        """Return the material with the parameter that the test found, and the result of the test."""

    @abstractmethod
    def derivatives(self, readings: Readings, fit: Fit) -> tuple[dict[str, float], dict[str, float]]:
        """Return the derivatives of this parameter's logarithm: by those of other parameters, and by each reading."""

    def propagate(self, changes: Changes, readings: Readings, fit: Fit) -> None:
        """Add the effects of uncertain readings on this test's parameter to `changes`."""
        by_parameter, by_reading = self.derivatives(readings, fit)
        for name, change in changes.items():
            moved = sum(by * change[PLACE[other]] for other, by in by_parameter.items())
            if name in by_reading:
                moved += by_reading[name] * readings[name].uncertainty
            change[PLACE[self.parameter]] += moved


UNIT = Material(areal_density=1.0, stretch_stiffness=1.0, bending_rigidity=1.0)
"""Cloth for relative uncertainties by textbook formulas, which are proportional to the density."""


@dataclass(frozen=True)
class Target:
    """The reading of one test, and the parameter that this reading determines."""

    test: RestTest
    read: Reading
    """The measured length [m]."""
    bound: str | None
    """Bound of the parameter, "at least" or "at most"; None if the reading determines the value of the parameter."""
    spread: float = 1.0
    """Standard uncertainty of the parameter's logarithm by the textbook formula. It weights tests of one parameter."""

    @property
    def parameter(self) -> str:
        """Field of a material that the reading determines."""
        return self.test.parameter

    @property
    def aim(self) -> float:
        """Length that the simulation must reproduce [m]: the reading, shifted by its uncertainty if it only bounds."""
        towards = {None: 0.0, "at least": 1.0, "at most": -1.0}[self.bound] * (-1.0 if self.test.rising else 1.0)
        return self.read.value + towards * self.read.uncertainty

    def start(self, material: Material) -> float:
        """Return the parameter by the textbook formula, within `LIMITS`. The search starts with this value."""
        return float(np.clip(self.test.guess(max(self.aim, 1e-5), material), *LIMITS[self.parameter]))

    def matched(self, laboratory: Laboratory, material: Material, start: float) -> Match:
        """Search for the parameter at which the simulated reading equals `aim`.

        Raises:
            SimulationError: If the simulator fails for every value of the parameter.
        """

        def reading(value: float) -> float:
            return laboratory.reading(self.test, material.model_copy(update={self.parameter: value}))

        within = max(laboratory.options.within * self.aim, laboratory.options.finest)
        test = self.test
        found = match(reading, self.aim, start, LIMITS[self.parameter], within, test.straight, test.rising)
        if not np.isfinite(found.reading):
            raise SimulationError(f"{self.test.name}: {laboratory.simulator} gave up: {laboratory.failure}")
        return found

    def bound_by(self, found: Match) -> str | None:
        """Return the bound that the test gives, also because the simulator did not reach the reading; or None."""
        if self.bound is not None or found.reached or abs(found.reading - self.aim) <= self.read.uncertainty:
            return self.bound
        return "at most" if (found.reading < self.aim) != self.test.rising else "at least"

    def fit(self, found: Match, simulated: float, shared: bool = False) -> Fit:
        """Return the result of the test. `shared` is true if other tests also determined the parameter."""
        alone = found.parameter if shared else None
        return self.test.fit(self.read, simulated, self.bound_by(found), found.samples, aim=self.aim, alone=alone)


def textbook_spread(guess: Callable[[float, Material], float], reading: Reading) -> float:
    """Return the standard uncertainty of a parameter's logarithm, from that of a reading by the textbook formula.

    The formula `guess` gives the parameter from a reading and the other parameters of a material.
    """
    if not reading.value > reading.uncertainty:
        return 1.0  # only its order of magnitude is known
    more, less = (guess(reading.value + step, UNIT) for step in (reading.uncertainty, -reading.uncertainty))
    if not (more > 0.0 and less > 0.0):
        return 1.0  # only its order of magnitude is known
    return max(0.5 * abs(float(np.log(more / less))), 1e-6)


@cache
def texts(name: str) -> dict[str, Any]:
    """Return the texts of a test, or of the guide to all tests, by their names.

    Of a test, `read` is the reading in one or two words, and `words` has a name of each reading in the file.
    `needs_because` and `yields_because` follow the words "because" and "as", and `without` the name of a simulator.
    """
    return dict(read_toml(Path(__file__).parent / "texts" / f"{name}.toml"))


def millimetres(length: float) -> str:
    """Return a length [m] as text in millimetres."""
    return f"{1e3 * length:.1f} mm"


def dash(drawing: Drawing, points: Any) -> None:
    """Draw a thin dashed line through points [m], shape (k, 2)."""
    drawing.line(points, "muted", 1.0, dash=4.0)


def strip_profile(along: np.ndarray, positions: np.ndarray) -> np.ndarray:
    """Return the side view of a strip: the mean position of each row of vertices [m], shape (rows, 2).

    Args:
        along: Coordinate of each vertex along the unfolded strip [m], shape (n,).
        positions: Positions [m], shape (n, 3).
    """
    along = along.round(6)
    return np.array([positions[along == row][:, [0, 2]].mean(axis=0) for row in np.unique(along)])
