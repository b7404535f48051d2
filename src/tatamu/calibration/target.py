"""The values that simulated readings must reach. Some of these values only give a bound of a parameter."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tatamu.base.errors import SimulationError
from tatamu.calibration.fit import Fit
from tatamu.calibration.laboratory import Laboratory, LengthTest
from tatamu.calibration.match import Match, match
from tatamu.calibration.parameters import LIMITS
from tatamu.calibration.readings import Reading
from tatamu.simulation.material import Material

UNKNOWN = 1.0
"""Standard uncertainty of a parameter's logarithm if a reading determines only the order of magnitude of the
parameter."""
Guess = Callable[[float, Material], float]
"""Textbook formula: a function that computes the parameter from a reading and a material.

The formula takes all other parameters from the material.
"""
UNIT = Material(areal_density=1.0, stretch_stiffness=1.0, bending_rigidity=1.0)
"""Cloth with which relative uncertainties are computed by textbook formulas.

The relative uncertainties are the same for every cloth, because the formulas are proportional to its density.
"""


@dataclass(frozen=True)
class Target:
    """The reading of one test, and the parameter that this reading determines."""

    test: LengthTest
    parameter: str
    measured: float
    """The measured reading [m]."""
    uncertainty: float
    """Standard uncertainty of the reading [m]."""
    bound: str | None
    """Bound of the parameter, "at least" or "at most"; None if the reading determines the value of the parameter."""
    guess: Guess
    """Textbook formula for the parameter."""
    straight: Callable[[float], float]
    """Function of the reading that is nearly linear in the logarithm of the parameter."""
    rising: bool = False
    """Whether the reading rises with the parameter; otherwise it falls."""
    spread: float = 1.0
    """Standard uncertainty of the parameter's logarithm due to the readings, computed with the textbook formula.

    If several tests determine one parameter, their weights follow from these uncertainties.
    """

    @property
    def limits(self) -> tuple[float, float]:
        """Smallest and largest value of the parameter that is tried."""
        return LIMITS[self.parameter]

    @property
    def aim(self) -> float:
        """Length that the simulation must reproduce [m].

        This length is the reading. If the reading only bounds the parameter, the reading is shifted by its uncertainty.
        """
        towards = {None: 0.0, "at least": 1.0, "at most": -1.0}[self.bound] * (-1.0 if self.rising else 1.0)
        return self.measured + towards * self.uncertainty

    def start(self, material: Material) -> float:
        """Return the parameter by the textbook formula, within `limits`. The search starts with this value."""
        return float(np.clip(self.guess(max(self.aim, 1e-5), material), *self.limits))

    def matched(self, laboratory: Laboratory, material: Material, start: float) -> Match:
        """Search for the parameter at which the simulated reading equals `aim`.

        All other parameters have the values in `material`.

        Raises:
            SimulationError: If the simulator fails for every value of the parameter.
        """

        def reading(value: float) -> float:
            return laboratory.reading(self.test, material.model_copy(update={self.parameter: value}))

        within = max(laboratory.options.within * self.aim, laboratory.options.finest)
        found = match(reading, self.aim, start, self.limits, within, self.straight, self.rising)
        if not np.isfinite(found.reading):
            raise SimulationError(f"{self.test.name}: {laboratory.simulator} gave up: {laboratory.failure}")
        return found

    def bound_by(self, found: Match) -> str | None:
        """Return the bound that the test gives; None if the test determines the parameter.

        If `bound` is given, it is returned. If `bound` is None, and the simulator could not reproduce the reading, the
        bound follows from the nearest reading.
        """
        if self.bound is not None or found.reached or abs(found.reading - self.aim) <= self.uncertainty:
            return self.bound
        return "at most" if (found.reading < self.aim) != self.rising else "at least"

    def fit(self, found: Match, simulated: float, shared: bool = False) -> Fit:
        """Return the result of the test from the result of the search.

        `shared` is true if other tests also determined the parameter.
        """
        return Fit(
            test=self.test.name,
            parameter=self.parameter,
            measured=self.measured,
            uncertainty=self.uncertainty,
            aim=self.aim,
            simulated=simulated,
            unit="m",
            bound=self.bound_by(found),
            samples=found.samples,
            alone=found.parameter if shared else None,
        )


def textbook_spread(guess: Guess, reading: Reading) -> float:
    """Return the standard uncertainty of a parameter's logarithm, from the uncertainty of a reading.

    The result is computed with the textbook formula. If the reading is smaller than its uncertainty, the parameter is
    assumed to be uncertain by a factor of e.
    """
    if not reading.value > reading.uncertainty:
        return UNKNOWN
    more, less = (guess(reading.value + step, UNIT) for step in (reading.uncertainty, -reading.uncertainty))
    if not (more > 0.0 and less > 0.0):
        return UNKNOWN
    return max(0.5 * abs(float(np.log(more / less))), 1e-6)


def by_parameter(targets: list[Target]) -> dict[str, list[Target]]:
    """Group tests by their parameters. Tests that only bound a parameter are left out if another test determines it."""
    groups: dict[str, list[Target]] = {}
    for target in targets:
        groups.setdefault(target.parameter, []).append(target)
    return {
        parameter: [target for target in group if target.bound is None] or group[-1:]
        for parameter, group in groups.items()
    }


def weights(group: list[Target]) -> np.ndarray:
    """Return the weights of the k tests of one parameter, shape (k,).

    The weights are proportional to the inverse squares of the tests' uncertainties, `Target.spread`. Their sum is 1.
    """
    inverse = np.array([target.spread**-2.0 for target in group])
    return np.asarray(inverse / inverse.sum())
