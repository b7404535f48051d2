"""A calibration test: a measurement, its simulated copy, and the parameter that the test determines.

Each test is one module. It contains:

- the test's table in the measurements file (a `TestEntry`), and its readings
- its scene
- the parameter that the test determines, with the uncertainty of this parameter
- its advice to the user, and its drawing

`registry` lists the tests, and all other code uses this list. There are two kinds of tests, which find their parameters
in different ways:

- `ElasticTest`: a length at rest that determines the stretch stiffness, the bending rigidity or the friction of
  bending. The parameters of all these tests are found together, because each reading depends on all three parameters.
- `LaterTest`: a test that finds its parameter when these three parameters are known. Later tests are made in the order
  of the registry.
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
from tatamu.simulation.material import Material
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Scene

POOR = 0.25
"""Largest relative standard uncertainty of a parameter.

If it is larger, the user is told that the readings are insufficient.
"""
Readings = Mapping[str, Reading]
"""Readings by their names."""
Changes = dict[str, np.ndarray]
"""For each reading, by its name: the changes of all parameters' logarithms if the reading changes by one standard
uncertainty.

The parameters are in the order of `PARAMETERS`.
"""


@dataclass(frozen=True)
class Specimen:
    """The simulated copy of the garment that was measured."""

    garment: Garment
    base: Material
    """Material before the calibration. Parameters that are not measured keep their values."""
    spacing: float | None
    """Mesh spacing [m]. If None, each test chooses a mesh so fine that its spacing does not matter."""


class CalibrationTest(ABC):
    """Base class of all calibration tests."""

    name: ClassVar[str]
    """Name of the test, and of its table in the measurements file."""
    title: ClassVar[str]
    """Heading of the test's section on the page."""
    parameter: ClassVar[str]
    """Field of a material that the test determines."""
    entry: ClassVar[type[TestEntry]]
    """Class of the test's table in the measurements file."""
    needs: ClassVar[tuple[str, ...]] = ()
    """Tests whose results this test needs."""
    needs_because: ClassVar[str] = ""
    """Reason why this test needs other tests. Messages put this text after the word "as"."""
    yields_to: ClassVar[tuple[str, ...]] = ()
    """Tests that replace this test.

    A material cannot have the parameter of this test together with the parameter of one of these tests.
    """
    yields_because: ClassVar[str] = ""
    """Reason why other tests replace this test. Messages put this text after the word "as"."""
    instructions: ClassVar[str]
    """Instructions for measuring. `$NAME` stands for the number of the test NAME in the guide."""
    read: ClassVar[str]
    """Name of the reading in one or two words."""
    words: ClassVar[Mapping[str, str]]
    """Name of each reading in the advice."""
    samples: ClassVar[Literal["reading", "speed"]] = "reading"
    """Kind of result of each simulation.

    "reading" is the simulated reading, "speed" is the speed of the cloth [m/s].
    """

    @classmethod
    @abstractmethod
    def of(cls, entry: Any, specimen: Specimen) -> Self:
        """Make the simulated copy of a measurement.

        `entry` is the test's table in the measurements file. Its class is `cls.entry`.

        Raises:
            InputError: If the specimen cannot have these readings.
        """

    @classmethod
    @abstractmethod
    def template(cls, garment: Garment) -> str:
        """Return the test's part of a measurements file, with empty readings."""

    @classmethod
    def was_made(cls, readings: Readings) -> bool:
        """Return whether the measurements have the readings of this test."""
        return cls.words.keys() <= readings.keys()

    @abstractmethod
    def scene(self, material: Material) -> Scene:
        """Return the simulated scene of this test with a material."""

    @abstractmethod
    def drawing(self, shape: np.ndarray | None) -> str:
        """Return a drawing of the test as SVG, from the positions of its cloth at rest [m], shape (n, 3).

        The drawing is empty if the test needs the positions but they are missing.
        """

    @property
    def textbook(self) -> float | None:
        """The parameter by a textbook formula; None if the formula needs more than the reading."""
        return None

    def record(self) -> dict[str, float]:
        """Return additional entries for the table [calibration] of the material's file."""
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
        """Return sentences of advice to the user on the result of this test."""

    def remark(self, estimate: Estimate, fit: Fit) -> list[str]:
        """Return remarks on the result of this test as sentences. They are printed after all advice."""
        return []


class RestTest(CalibrationTest):
    """A test whose reading is a length of cloth at rest."""

    @abstractmethod
    def reading(self, rollout: Rollout, frame: int = -1) -> float:
        """Return the length that a ruler would read on the simulated cloth [m]."""

    @abstractmethod
    def target(self, readings: Readings) -> Target:
        """Return what the simulation must reproduce: the measured reading, and whether it only bounds the parameter."""


class ElasticTest(RestTest):
    """A test whose length at rest depends on stretch stiffness and bending, and determines one of these parameters."""

    reads: ClassVar[Mapping[str, float]]
    """Names of readings, each with a factor. The sum of these readings times their factors is the measured length."""
    weighs: ClassVar[bool] = True
    """Whether the length depends on the cloth's own weight."""
    size: ClassVar[str | None] = None
    """Name of the reading to which all lengths of the simulated test are proportional; None if no reading has this
    effect."""
    step: ClassVar[float] = 0.1
    """Step of a parameter's logarithm for numerical derivatives of the length."""

    def chance(self, shapes: Sequence[np.ndarray]) -> float:
        """Return the standard uncertainty of the simulated length due to the random positions of folds [m].

        Args:
            shapes: Positions at rest [m], shape (n, 3), for all materials that were tried.
        """
        return 0.0

    def measured(self, readings: Readings) -> tuple[float, float]:
        """Return the measured length and its standard uncertainty [m]."""
        value = 0.0
        error = 0.0
        for name, factor in self.reads.items():
            value += factor * readings[name].value
            error = float(np.hypot(error, factor * readings[name].uncertainty))
        return value, error


class LaterTest(CalibrationTest):
    """A test that finds its parameter after the stretch stiffness and the bending parameters are known."""

    @abstractmethod
    def find(self, laboratory: Laboratory, material: Material, readings: Readings) -> tuple[Material, Fit]:
        """Return the material with the parameter that the test found, and the result of the test."""

    @abstractmethod
    def propagate(self, changes: Changes, readings: Readings, fit: Fit) -> None:
        """Add the effects of uncertain readings on this test's parameter to `changes`.

        An effect is the change of the parameter's logarithm if a reading changes by one standard uncertainty.

        Args:
            changes: Effects of each reading on all parameters. The entries of this test's parameter are still zero.
            readings: Readings by their names.
            fit: Result of the test.
        """


def millimetres(length: float) -> str:
    """Return a length [m] as text in millimetres."""
    return f"{1e3 * length:.1f} mm"
