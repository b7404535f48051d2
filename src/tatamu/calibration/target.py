"""The target of a simulated reading, and readings that only bound a parameter."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tatamu.calibration.fit import Fit
from tatamu.calibration.laboratory import Laboratory, LengthTest
from tatamu.calibration.match import Match, match
from tatamu.calibration.parameters import LIMITS
from tatamu.calibration.readings import Reading
from tatamu.errors import SimulationError
from tatamu.material import Material

UNKNOWN = 1.0
"""Standard uncertainty of a parameter's logarithm if a reading determines only its magnitude."""
Guess = Callable[[float, Material], float]
"""Function from a reading, and a cloth with known other parameters, to the parameter by the textbook."""
UNIT = Material(areal_density=1.0, stretch_stiffness=1.0, bending_rigidity=1.0)
"""Any cloth: the textbooks' parameters are proportional to its density, their relative spread does not depend on it."""


@dataclass(frozen=True)
class Target:
    """The reading of one test and the parameter that it determines."""

    test: LengthTest
    parameter: str
    measured: float
    """[m]"""
    uncertainty: float
    """Standard uncertainty of the reading [m]."""
    bound: str | None
    """"at least" or "at most" if the reading only bounds the parameter; None otherwise."""
    guess: Guess
    """The parameter by a textbook."""
    straight: Callable[[float], float]
    """Function of the reading that is nearly linear in the logarithm of the parameter."""
    rising: bool = False
    """Whether the reading rises with the parameter."""
    spread: float = 1.0
    """Standard uncertainty of the parameter's logarithm that follows from the test's own readings, by the textbook.
    Tests of one parameter weigh by it."""

    @property
    def limits(self) -> tuple[float, float]:
        """Smallest and largest parameter that is tried."""
        return LIMITS[self.parameter]

    @property
    def aim(self) -> float:
        """Length to match [m]: the reading, moved by its uncertainty if it is a bound."""
        towards = {None: 0.0, "at least": 1.0, "at most": -1.0}[self.bound] * (-1.0 if self.rising else 1.0)
        return self.measured + towards * self.uncertainty

    def start(self, material: Material) -> float:
        """Return the parameter by the textbook, within its limits, where the search starts."""
        return float(np.clip(self.guess(max(self.aim, 1e-5), material), *self.limits))

    def matched(self, laboratory: Laboratory, material: Material, start: float) -> Match:
        """Search the parameter at which the simulator gives the aim, with all other parameters of `material`.

        Raises:
            SimulationError: If the simulator fails for every parameter.
        """

        def reading(value: float) -> float:
            return laboratory.reading(self.test, material.model_copy(update={self.parameter: value}))

        within = max(laboratory.options.within * self.aim, laboratory.options.finest)
        found = match(reading, self.aim, start, self.limits, within, self.straight, self.rising)
        if not np.isfinite(found.reading):
            raise SimulationError(f"{self.test.name}: {laboratory.simulator} gave up: {laboratory.failure}")
        return found

    def bound_by(self, found: Match) -> str | None:
        """Return `bound`, or the bound of a search in which the simulator could not come near the reading."""
        if self.bound is not None or found.reached or abs(found.reading - self.aim) <= self.uncertainty:
            return self.bound
        return "at most" if (found.reading < self.aim) != self.rising else "at least"

    def fit(self, found: Match, simulated: float, shared: bool = False) -> Fit:
        """Return the fit of a match; `shared` if other tests determined the parameter as well."""
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
    """Return the standard uncertainty of a parameter's logarithm that follows from that of a reading, by the textbook.

    A reading that does not exceed its uncertainty leaves the parameter uncertain by a factor of e.
    """
    if not reading.value > reading.uncertainty:
        return UNKNOWN
    more, less = (guess(reading.value + step, UNIT) for step in (reading.uncertainty, -reading.uncertainty))
    if not (more > 0.0 and less > 0.0):
        return UNKNOWN
    return max(0.5 * abs(float(np.log(more / less))), 1e-6)


def by_parameter(targets: list[Target]) -> dict[str, list[Target]]:
    """Group tests by parameter; tests that only bound it are left out if another test determines it."""
    groups: dict[str, list[Target]] = {}
    for target in targets:
        groups.setdefault(target.parameter, []).append(target)
    return {
        parameter: [target for target in group if target.bound is None] or group[-1:]
        for parameter, group in groups.items()
    }


def weights(group: list[Target]) -> np.ndarray:
    """Return the weights of the tests of one parameter, shape (k,): inverse squares of spreads, with the sum 1."""
    inverse = np.array([target.spread**-2.0 for target in group])
    return np.asarray(inverse / inverse.sum())
