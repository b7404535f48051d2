"""A calibration test: a measurement, its simulated copy, and the parameter that it determines.

A test is one module: its table of the measurements file (a `TestEntry`), its readings, its scene, the parameter that it
determines with its uncertainty, its advice and its drawing. `registry` lists the modules; all other code uses that
list. Two kinds are matched differently:

- `ElasticTest`: a length at rest that determines stretch stiffness, bending rigidity or its friction. All of them are
  matched together, because each reading depends on all three parameters.
- `LaterTest`: finds its parameter when those are known, in the order of the registry.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, Self

import numpy as np

from tatamu.calibration.entry import TestEntry
from tatamu.calibration.estimate import Estimate
from tatamu.calibration.fit import Fit
from tatamu.calibration.laboratory import Laboratory
from tatamu.calibration.readings import Reading
from tatamu.calibration.target import Target
from tatamu.garments import Garment
from tatamu.material import Material
from tatamu.rollout import Rollout
from tatamu.scene import Scene

POOR = 0.25
"""Relative standard uncertainty above which a reading is reported as insufficient."""
Readings = Mapping[str, Reading]
"""Readings by name."""
Changes = dict[str, np.ndarray]
"""Reading to the change of each parameter's logarithm with one standard uncertainty of it, in the order of
`PARAMETERS`."""


@dataclass(frozen=True)
class Specimen:
    """The simulated garment that was measured."""

    garment: Garment
    base: Material
    """Material before the calibration; parameters that are not measured keep its values."""
    spacing: float | None
    """Mesh spacing [m]; None if each test chooses one so fine that it does not matter."""


class CalibrationTest(ABC):
    """Base of all tests."""

    name: ClassVar[str]
    """Name of the test and of its table in the file."""
    title: ClassVar[str]
    """Heading of its section on the page."""
    parameter: ClassVar[str]
    """Field of a material that the test determines."""
    entry: ClassVar[type[TestEntry]]
    """Class of the test's table in the file."""
    needs: ClassVar[tuple[str, ...]] = ()
    """Tests that this test needs."""
    needs_because: ClassVar[str] = ""
    """The reason, to be read after "as"."""
    yields_to: ClassVar[tuple[str, ...]] = ()
    """Tests that replace this test, because a material cannot have the parameters of both."""
    yields_because: ClassVar[str] = ""
    """The reason, to be read after "as"."""
    instructions: ClassVar[str]
    """Instructions for measuring; `$NAME` is the number of that test in the guide."""
    read: ClassVar[str]
    """The reading, in a word or two."""
    words: ClassVar[Mapping[str, str]]
    """The name of each reading in the advice."""
    samples: ClassVar[Literal["reading", "speed"]] = "reading"
    """Result of each simulation: the reading [m], or a speed [m/s] that is zero if the cloth sticks."""

    @classmethod
    @abstractmethod
    def of(cls, entry: Any, specimen: Specimen) -> Self:
        """Make the simulated copy of a measurement; `entry` is of the class `cls.entry`.

        Raises:
            InputError: If the specimen cannot have been measured so.
        """

    @classmethod
    @abstractmethod
    def template(cls, garment: Garment) -> str:
        """Return the test's part of a measurements file with empty readings."""

    @classmethod
    def was_made(cls, readings: Readings) -> bool:
        """Return whether the measurements have the readings of this test."""
        return cls.words.keys() <= readings.keys()

    @abstractmethod
    def scene(self, material: Material) -> Scene:
        """Return the scene of a material."""

    @abstractmethod
    def drawing(self, shape: np.ndarray | None) -> str:
        """Draw the reading as SVG, from positions at rest [m], shape (n, 3); empty without required positions."""

    @property
    def textbook(self) -> float | None:
        """The parameter by a textbook, if the reading alone gives it; None otherwise."""
        return None

    def record(self) -> dict[str, float]:
        """Return entries for the table [calibration] of the material's file."""
        return {}

    def unusable(self, simulator: str) -> str | None:
        """Return why a simulator cannot do this test; None if it can."""
        return None

    def sentence(self, fit: Fit) -> str:
        """Return a sentence on the measured and the simulated reading."""
        return (
            f"{self.read[0].upper()}{self.read[1:]} measured: {1e3 * fit.measured:.1f} ± {1e3 * fit.uncertainty:.1f} "
            f"mm; simulated: {1e3 * fit.simulated:.2f} mm."
        )

    @abstractmethod
    def advice(self, estimate: Estimate, fit: Fit) -> list[str]:
        """Return sentences of advice on a fit that determined its parameter."""

    def remark(self, estimate: Estimate, fit: Fit) -> list[str]:
        """Return sentences on a fit that follow all advice."""
        return []


class RestTest(CalibrationTest):
    """A test whose reading is a length of cloth at rest."""

    @abstractmethod
    def reading(self, rollout: Rollout, frame: int = -1) -> float:
        """Return the length that a ruler would read [m]."""

    @abstractmethod
    def target(self, readings: Readings) -> Target:
        """Return the target of the simulated reading."""


class ElasticTest(RestTest):
    """A length at rest that depends on stretch stiffness and on bending, and determines one of them."""

    reads: ClassVar[Mapping[str, float]]
    """The readings that make up the length, each with its factor."""
    weighs: ClassVar[bool] = True
    """Whether the length depends on the cloth's own weight."""
    size: ClassVar[str | None] = None
    """Name of the reading with which all lengths of the test scale; None if no reading is."""
    step: ClassVar[float] = 0.1
    """Step of a parameter's logarithm for differences of the length."""

    def chance(self, shapes: Sequence[np.ndarray]) -> float:
        """Return the standard uncertainty of the simulated length [m] due to chance.

        Args:
            shapes: Positions at rest [m], shape (n, 3), of all materials that were tried.
        """
        return 0.0

    def measured(self, readings: Readings) -> tuple[float, float]:
        """Return the length that was read and its standard uncertainty [m]."""
        value = 0.0
        error = 0.0
        for name, factor in self.reads.items():
            value += factor * readings[name].value
            error = float(np.hypot(error, factor * readings[name].uncertainty))
        return value, error


class LaterTest(CalibrationTest):
    """A test that finds its parameter once stretch stiffness and bending are known."""

    @abstractmethod
    def find(self, laboratory: Laboratory, material: Material, readings: Readings) -> tuple[Material, Fit]:
        """Return the material with the parameter of the test, and the fit."""

    @abstractmethod
    def propagate(self, changes: Changes, readings: Readings, fit: Fit) -> None:
        """Add the change of the test's parameter with each reading to `changes`.

        Args:
            changes: Changes by reading; the row of this test's parameter is still zero.
            readings: Readings by name.
            fit: Fit of the test.
        """


def millimetres(length: float) -> str:
    """Format a length [m] in millimetres."""
    return f"{1e3 * length:.1f} mm"
