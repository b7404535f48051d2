"""Simulates tests until their cloth has come to rest, and keeps their readings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from tatamu.base.errors import SimulationError
from tatamu.simulation.material import Material
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Scene
from tatamu.simulation.simulators import simulate


@dataclass(frozen=True)
class CalibrationOptions:
    """Tolerances of simulated readings, and limits of the time in which the simulated cloth comes to rest."""

    settled: float = 5e-5
    """Maximum change of a reading over the last quarter of its simulation [m]. Otherwise it is lengthened."""
    lengthening: float = 2.0
    """Factor by which a simulation is lengthened if its cloth has not come to rest."""
    longest: float = 8.0
    """Largest duration of a simulation, as a multiple of the duration that its test sets."""
    within: float = 1e-3
    """Largest accepted difference between the simulated and the measured reading, as a fraction of the reading."""
    finest: float = 1e-5
    """Minimum difference that is accepted [m]."""
    agreement: float = 5e-3
    """Maximum change of a parameter's logarithm in the last pass over the tests."""
    passes: int = 5
    """Maximum number of passes over the elastic tests."""
    passes_with_friction: int = 10
    """Maximum number with friction of bending, which changes the rigidity that follows from a sag."""


DEFAULTS = CalibrationOptions()
"""Options of the command `tatamu calibrate`."""


class LengthTest(Protocol):
    """A test whose reading is a length of cloth at rest."""

    @property
    def name(self) -> str:
        """Name of the test, by which a laboratory stores its readings."""
        ...

    def scene(self, material: Material) -> Scene:
        """Return the scene of the test."""
        ...

    def reading(self, rollout: Rollout, frame: int = -1) -> float:
        """Return the length that a ruler would read [m]."""
        ...


@dataclass
class Laboratory:
    """Measures simulated cloth, and stores the readings."""

    simulator: str
    tick: Callable[[str], None] = lambda what: None
    """Function that is called before each simulation with the name of its test."""
    options: CalibrationOptions = DEFAULTS
    simulations: int = 0
    failure: str = ""
    """Error message of the last simulation that failed."""
    unsettled: float = 0.0
    """Largest change of any accepted reading over the last quarter of its simulation [m]."""
    _known: dict[tuple[str, str], float] = field(default_factory=dict)
    _shapes: dict[tuple[str, str], np.ndarray] = field(default_factory=dict)
    _durations: dict[str, float] = field(default_factory=dict)

    def run(self, scene: Scene, what: str) -> Rollout:
        """Simulate a scene, and count the simulation."""
        self.tick(what)
        self.simulations += 1
        return simulate(scene, self.simulator)

    def reading(self, test: LengthTest, material: Material) -> float:
        """Return the simulated reading of a test [m]. It is infinite if the cloth is too soft for the simulator."""
        key = test.name, material.model_dump_json()
        if key not in self._known:
            try:
                self._known[key], self._shapes[key] = self._settled(test, test.scene(material))
            except SimulationError as error:
                self._known[key] = np.inf
                self.failure = str(error)
        return self._known[key]

    def shape(self, test: str, material: Material) -> np.ndarray | None:
        """Return the positions of a test's cloth at rest [m], shape (n, 3); None if the material was not tried."""
        return self._shapes.get((test, material.model_dump_json()))

    def shapes(self, test: str) -> list[np.ndarray]:
        """For each material that was tried, return the positions of a test's cloth at rest [m], shape (n, 3)."""
        return [shape for (name, _), shape in self._shapes.items() if name == test]

    def _settled(self, test: LengthTest, scene: Scene) -> tuple[float, np.ndarray]:
        """Simulate until a reading no longer changes, first for the time that the same test needed before."""
        options = self.options
        factor = self._durations.get(test.name, 1.0)
        while True:
            longer = scene.model_copy(update={"duration": factor * scene.duration})
            rollout = self.run(longer, test.name)
            reading = test.reading(rollout)
            late = [test.reading(rollout, frame) for frame in range(len(rollout.times) * 3 // 4, len(rollout.times))]
            if np.ptp(late) < options.settled or factor >= options.longest:
                break
            factor *= options.lengthening
        self._durations[test.name] = factor
        self.unsettled = max(self.unsettled, float(np.ptp(late)))
        return (reading if np.ptp(late) < options.settled else float(np.mean(late))), rollout.positions[-1]
