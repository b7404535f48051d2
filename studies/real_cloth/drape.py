"""Simulates the drape of a fabric several times, with different random unevenness of the cloth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, TypeVar

import numpy as np

from studies.real_cloth.bench import Experiment, Values
from studies.real_cloth.hem import Hem, WavyDrapemeter
from studies.real_cloth.section import Sketch
from tatamu.show.drawing import Drawing
from tatamu.simulation.material import Material
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.simulators import capabilities

FINENESS = 0.35
"""Maximum edge length of the mesh, in bending lengths."""
EARLIER = 5
"""Number of frames (half a second) between two shapes of the hanging cloth: an earlier shape and the last shape. The
difference between both shapes shows whether the cloth still moves."""
TURN = np.linspace(0.0, 2.0 * np.pi, 181)


@dataclass(frozen=True)
class Size:
    """The size of a drapemeter, an instrument in which a round specimen of cloth hangs over a smaller round plate.

    The fields are the radii of both [m].
    """

    specimen: float
    plate: float

    @property
    def name(self) -> str:
        """Diameters of the drapemeter's specimen and plate in millimetres, as text."""
        return f"{2e3 * self.specimen:.0f}/{2e3 * self.plate:.0f} mm"

    @property
    def ring(self) -> float:
        """Area of the flat specimen outside the plate [m^2]."""
        return float(np.pi * (self.specimen**2 - self.plate**2))

    def coefficient(self, outline: Hem) -> float:
        """Return the drape coefficient of a specimen with this outline from above [%]."""
        return 100.0 * outline.drape_coefficient(self.specimen, self.plate)


@dataclass(frozen=True)
class Draped:
    """The results of all repeats of a simulated drape, except repeats that failed."""

    size: Size
    outlines: Sequence[Hem]
    moving: float
    """Largest change of a drape coefficient during the last half second of a simulation [percentage points]."""
    failures: Sequence[str] = ()

    @classmethod
    def of(cls, values: Sequence[Values], size: Size) -> Draped:
        """Make the results of a drape from the values that were read from its repeats."""
        good = [each for each in values if "failed" not in each]
        moved = [abs(each["area"] - each["area_before"]) / size.ring for each in good]
        outlines = [Hem(np.array(each["radii"])) for each in good]
        failures = [str(each["failed"]) for each in values if "failed" in each]
        return cls(size, outlines, 100.0 * max(moved, default=0.0), failures)

    @property
    def coefficients(self) -> np.ndarray:
        """Drape coefficients of all repeats [%], shape (repeats,)."""
        return np.array([self.size.coefficient(outline) for outline in self.outlines])

    @property
    def mean(self) -> float:
        """Mean drape coefficient over the repeats [%]."""
        return self._mean(list(self.coefficients))

    @property
    def nodes(self) -> float:
        """Mean number of nodes, which are the folds of the hanging hem, over the repeats."""
        return self._mean([outline.nodes for outline in self.outlines])

    @property
    def amplitude(self) -> float:
        """Mean amplitude of the waves of the hanging hem, over the repeats [m]."""
        return self._mean([outline.amplitude for outline in self.outlines])

    @property
    def wavelength(self) -> float:
        """Mean wavelength of the waves of the hanging hem, over the repeats [m]."""
        return self._mean([outline.wavelength for outline in self.outlines])

    @property
    def scatter(self) -> float:
        """Standard deviation of the drape coefficients over the repeats [percentage points]."""
        return float(self.coefficients.std()) if self.outlines else float("nan")

    def harmonic(self, order: int) -> float:
        """Return the mean amplitude of a harmonic of the hem's waves over the repeats [m]."""
        return self._mean([outline.harmonic(order) for outline in self.outlines])

    @staticmethod
    def _mean(values: Sequence[float]) -> float:
        """Return the mean of values of all repeats, or NaN if every repeat failed."""
        return float(np.mean(values)) if values else float("nan")

    @property
    def counted(self) -> str:
        """Number of nodes, which are the folds of the hem, in each repeat, as text."""
        return ", ".join(str(outline.nodes) for outline in self.outlines) or "none came to an end"


class Needing(Protocol):
    """The interface of models of cloth that need certain capabilities of a simulator."""

    @property
    def needs(self) -> tuple[str, ...]:
        """Names of the capabilities that a simulator must have to simulate this model of cloth."""


Model = TypeVar("Model", bound=Needing)


def known_to(simulator: str, models: Sequence[Model]) -> list[Model]:
    """Return those of the given models of cloth that a simulator can simulate."""
    able = capabilities(simulator)
    return [model for model in models if all(getattr(able, name, False) for name in model.needs)]


def experiments(name: str, material: Material, size: Size, seeds: int, waviness: float = 0.0) -> list[Experiment]:
    """Return the experiments for all repeats of a drape, with the random seeds 0, 1, and so on.

    The unstrained cloth may be wavy: `waviness` is the standard deviation of its height [m].
    """
    spacing = min(FINENESS * material.bending_length, 0.2 * (size.specimen - size.plate))
    meters = [WavyDrapemeter(size.specimen, size.plate, spacing, seed, waviness) for seed in range(seeds)]
    return [_experiment(name, meter, material, size) for meter in meters]


def _experiment(name: str, meter: WavyDrapemeter, material: Material, size: Size) -> Experiment:
    def read(rollout: Rollout) -> Values:
        last = meter.outline(rollout)
        earlier = meter.outline(rollout, -1 - EARLIER)
        radii = [round(float(radius), 6) for radius in last.radii]
        return {"radii": radii, "area": last.area, "area_before": earlier.area}

    return Experiment(f"{name}, {size.name}", meter.scene(material), "outline", read)


def sketched(title: str, outlines: Sequence[Hem], size: Size, note: str = "", colour: str = "plot") -> Sketch:
    """Return a drawing of draped specimens from above.

    It has their outlines, and circles of the flat specimen and of the plate.
    """
    circle = np.column_stack([np.cos(TURN), np.sin(TURN)])
    drawing = Drawing.around(1.02 * size.specimen * circle, 210.0, 210.0, margin=6.0)
    drawing.line(size.specimen * circle, "muted", 1.0, dash=4.0)
    drawing.line(size.plate * circle, "muted", 1.0, fill="grip")
    for number, outline in enumerate(outlines):
        drawing.line(outline.curve, colour, 1.0 if number else 2.0)
    drawing.words = f"{title}, from above. {note}"
    return Sketch(title, drawing.svg(), note)
