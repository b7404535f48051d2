"""Parameters that were found from readings, with the uncertainty that each reading contributes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from tatamu.calibration.parameters import OPTIONAL, PARAMETERS, PLACE
from tatamu.calibration.readings import Reading
from tatamu.simulation.material import Material

Samples = tuple[tuple[float, float], ...]
"""Values of a parameter that were simulated, each with its reading, or its speed [m/s] for friction."""


@dataclass(frozen=True)
class Fit:
    """The result of one test: the parameter with which the simulation reproduces the reading."""

    test: str
    parameter: str
    measured: float
    """The measured reading, in `unit`."""
    uncertainty: float
    """Standard uncertainty of the measured reading, in `unit`."""
    aim: float
    """Value of the reading that the simulation had to reproduce, `Target.aim`."""
    simulated: float
    """The simulated reading, with the parameter that was found."""
    unit: str
    bound: str | None
    """Bound of the parameter, "at least" or "at most"; None if the test determines the value of the parameter."""
    samples: Samples
    alone: float | None = None
    """Value of the parameter by this test alone; None if the material's value is from this test only. Several tests may
    determine the parameter, or the value that was assumed before may satisfy this test's bound."""
    resolution: float | None = None
    """Standard uncertainty of the parameter's logarithm due to the last interval of a bisection; None without one."""

    @property
    def slope(self) -> float | None:
        """Derivative of the reading by the parameter's logarithm, of the three samples closest to `aim`; or None."""
        nearest = sorted(self.samples, key=lambda sample: abs(sample[1] - self.aim))[:3]
        if len(nearest) < 2:
            return None
        return float(np.polyfit(np.log([sample[0] for sample in nearest]), [sample[1] for sample in nearest], 1)[0])


@dataclass(frozen=True)
class Estimate:
    """A material for one simulator, the results of the tests, and the uncertainties of the material's parameters."""

    material: Material
    simulator: str
    """Name of the simulator. Another simulator needs another material."""
    fits: tuple[Fit, ...]
    contributions: Mapping[str, np.ndarray]
    """Change of the logarithms of the k parameters by one standard uncertainty of each reading, shape (k,)."""
    readings: Mapping[str, Reading]
    """Readings from the measurements file, by their names."""
    assumed: tuple[str, ...]
    """Fields of the material that no reading determines."""
    shapes: Mapping[str, np.ndarray | None]
    """Positions of the simulated cloth at rest [m], shape (n, 3), by the name of the test."""

    @property
    def covariance(self) -> np.ndarray:
        """Covariance matrix of the logarithms of the k parameters in `PARAMETERS`, shape (k, k)."""
        parts = np.array([np.zeros(len(PARAMETERS)), *self.contributions.values()])
        return np.asarray(parts.T @ parts)

    @property
    def listed(self) -> tuple[str, ...]:
        """Names of the parameters to show. An optional parameter is shown only if it was tested."""
        made = {fit.parameter for fit in self.fits}
        return tuple(name for name in PARAMETERS if name not in OPTIONAL or name in made)

    @property
    def known(self) -> tuple[str, ...]:
        """Names of the parameters whose values the readings determine."""
        return tuple(name for name in self.listed if name not in self.assumed and self.bounding(name) is None)

    def relative(self, parameter: str) -> float:
        """Return the standard uncertainty of a parameter, divided by its value."""
        place = PLACE[parameter]
        return float(np.sqrt(self.covariance[place, place]))

    def uncertainty(self, parameter: str) -> float:
        """Return the standard uncertainty of a parameter, in the parameter's unit."""
        return self.relative(parameter) * float(getattr(self.material, parameter))

    def correlation(self) -> np.ndarray:
        """Return the correlations between the k known parameters, shape (k, k)."""
        rows = [PLACE[name] for name in self.known]
        part = self.covariance[np.ix_(rows, rows)]
        scale = np.sqrt(np.diag(part))
        return np.asarray(part / np.outer(scale, scale))

    def bounding(self, parameter: str) -> Fit | None:
        """Return the result of the test that bounds a parameter whose value no test determines; or None."""
        fits = [fit for fit in self.fits if fit.parameter == parameter]
        return fits[-1] if fits and all(fit.bound for fit in fits) else None

    def fit(self, test: str) -> Fit | None:
        """Return the result of a test; None if the test was not made."""
        return next((fit for fit in self.fits if fit.test == test), None)
