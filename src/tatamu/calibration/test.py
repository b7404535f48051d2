"""A calibration test: what a person measures, its simulated copy, and the parameter that it tells.

A test is one module: its table of the measurements file (a `TestEntry`), how to read it, its scene, the parameter that
it tells and with which uncertainty, what to advise and how to draw it. `registry` lists the modules; everything else
goes through that list. Two kinds are matched differently:

- `ElasticTest`: a length at rest that tells stretch stiffness, bending rigidity or its friction. All of them are
  matched together, as each depends a little on all.
- `LaterTest`: finds its parameter once those are known, in the order of the registry.
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
"""A relative standard uncertainty above this is said to tell hardly anything."""
Readings = Mapping[str, Reading]
"""By name."""
Changes = dict[str, np.ndarray]
"""Reading to the change of each parameter's logarithm with one standard uncertainty of it, in the order of
`PARAMETERS`."""


@dataclass(frozen=True)
class Specimen:
    """The simulated garment that was measured."""

    garment: Garment
    base: Material
    """Its material before anything is found; what is not measured stays so."""
    spacing: float | None
    """Mesh spacing that was asked for [m]; None: each test chooses one fine enough that it does not matter."""


class CalibrationTest(ABC):
    """Base of all tests."""

    name: ClassVar[str]
    """Of the test and of its table in the file."""
    title: ClassVar[str]
    """Heading of its section on the page."""
    parameter: ClassVar[str]
    """The field of a material that it tells."""
    entry: ClassVar[type[TestEntry]]
    """Its table in the file."""
    needs: ClassVar[tuple[str, ...]] = ()
    """Tests without which this one tells nothing."""
    needs_because: ClassVar[str] = ""
    """Why, to be read after "as"."""
    yields_to: ClassVar[tuple[str, ...]] = ()
    """Tests beside which this one is not used: a material cannot have the parameters of both."""
    yields_because: ClassVar[str] = ""
    """Why, to be read after "as"."""
    instructions: ClassVar[str]
    """How to measure; `$NAME` is the number of that test in the guide."""
    read: ClassVar[str]
    """The reading, in a word or two."""
    words: ClassVar[Mapping[str, str]]
    """Each of its readings, in the words of the advice."""
    samples: ClassVar[Literal["reading", "speed"]] = "reading"
    """Result of each simulation: the reading [m], or a speed [m/s] that is zero where the cloth sticks."""

    @classmethod
    @abstractmethod
    def of(cls, entry: Any, specimen: Specimen) -> Self:
        """The simulated copy of what was measured; `entry` is of the class `cls.entry`.

        Raises:
            InputError: The specimen cannot have been measured so.
        """

    @classmethod
    @abstractmethod
    def template(cls, garment: Garment) -> str:
        """Its part of a file to be filled in."""

    @classmethod
    def was_made(cls, readings: Readings) -> bool:
        """Return whether the measurements have the readings of this test."""
        return cls.words.keys() <= readings.keys()

    @abstractmethod
    def scene(self, material: Material) -> Scene:
        """The scene of a material."""

    @abstractmethod
    def drawing(self, shape: np.ndarray | None) -> str:
        """Draw the reading as SVG, from positions at rest [m], shape (n, 3), where there are any."""

    @property
    def textbook(self) -> float | None:
        """The parameter where the reading alone gives it by a textbook; None: it does not."""
        return None

    def record(self) -> dict[str, float]:
        """Entries for the table [calibration] of the material's file."""
        return {}

    def unusable(self, simulator: str) -> str | None:
        """Why a simulator cannot do this test; None: it can."""
        return None

    def sentence(self, fit: Fit) -> str:
        """Measured and simulated reading."""
        return (
            f"{self.read[0].upper()}{self.read[1:]} measured: {1e3 * fit.measured:.1f} ± {1e3 * fit.uncertainty:.1f} "
            f"mm; simulated: {1e3 * fit.simulated:.2f} mm."
        )

    @abstractmethod
    def advice(self, estimate: Estimate, fit: Fit) -> list[str]:
        """Sentences for the person who measured, on a fit that decided its parameter."""

    def remark(self, estimate: Estimate, fit: Fit) -> list[str]:
        """Sentences on a fit that follow all advice."""
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
    """The reading by which all lengths of the test scale; None: none that was read."""
    step: ClassVar[float] = 0.1
    """Of the logarithm of a parameter, for differences of the length."""

    def chance(self, shapes: Sequence[np.ndarray]) -> float:
        """Standard uncertainty of the simulated length [m] where chance decides it, too.

        Args:
            shapes: Positions at rest [m], shape (n, 3), of all materials that were tried.
        """
        return 0.0

    def measured(self, readings: Readings) -> tuple[float, float]:
        """The length that was read and its standard uncertainty [m]."""
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
        """The material with its parameter, and how it was matched."""

    @abstractmethod
    def propagate(self, changes: Changes, readings: Readings, fit: Fit) -> None:
        """Add what each reading moves its parameter by to the changes of those found before.

        Args:
            changes: By reading; the row of this test's parameter is still zero.
            readings: By name.
            fit: How it was matched.
        """


def millimetres(length: float) -> str:
    """A length [m] in words."""
    return f"{1e3 * length:.1f} mm"
