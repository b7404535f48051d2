"""The result of a calibration, and the file it goes to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from tatamu import __version__
from tatamu.calibration.fit import Fit
from tatamu.calibration.parameters import OPTIONAL, PARAMETERS, PLACE
from tatamu.calibration.readings import Reading
from tatamu.calibration.setup import Setup
from tatamu.files import write_text
from tatamu.material import Material


@dataclass(frozen=True)
class Calibration:
    """A material with its uncertainties, for one simulator."""

    material: Material
    simulator: str
    setup: Setup
    fits: tuple[Fit, ...]
    contributions: Mapping[str, np.ndarray]
    """Reading to the change of each parameter's logarithm with one standard uncertainty of it, shape (k,)."""
    readings: Mapping[str, Reading]
    """By the name they have in the file."""
    assumed: tuple[str, ...]
    """Fields that nothing measured."""
    shapes: Mapping[str, np.ndarray | None]
    """Test to the simulated garment's or strip's positions at rest [m], shape (n, 3)."""
    passes: int
    simulations: int
    unsettled: float
    """Largest motion of a reading over the last quarter of a scene [m]."""

    @property
    def covariance(self) -> np.ndarray:
        """Of the logarithms of `PARAMETERS`, shape (k, k)."""
        parts = np.array([np.zeros(len(PARAMETERS)), *self.contributions.values()])
        return np.asarray(parts.T @ parts)

    def relative(self, parameter: str) -> float:
        """Standard uncertainty of a parameter over its value."""
        place = PLACE[parameter]
        return float(np.sqrt(self.covariance[place, place]))

    @property
    def listed(self) -> tuple[str, ...]:
        """Parameters to be shown: those that are optional only where a test was made of them."""
        made = {fit.parameter for fit in self.fits}
        return tuple(name for name in PARAMETERS if name not in OPTIONAL or name in made)

    @property
    def known(self) -> tuple[str, ...]:
        """Parameters that the readings tell."""
        return tuple(name for name in self.listed if name not in self.assumed and self.bounding(name) is None)

    def bounding(self, parameter: str) -> Fit | None:
        """The fit that bounds a parameter; None if a test tells its value, or if no test was made."""
        fits = [fit for fit in self.fits if fit.parameter == parameter]
        return fits[-1] if fits and all(fit.bound for fit in fits) else None

    def uncertainty(self, parameter: str) -> float:
        """Standard uncertainty of a parameter, in its unit."""
        return self.relative(parameter) * float(getattr(self.material, parameter))

    def correlation(self) -> np.ndarray:
        """Correlations of the known parameters, shape (k, k)."""
        rows = [PLACE[name] for name in self.known]
        part = self.covariance[np.ix_(rows, rows)]
        scale = np.sqrt(np.diag(part))
        return np.asarray(part / np.outer(scale, scale))

    def fit(self, test: str) -> Fit | None:
        """The fit of a test, None where it was not made."""
        return next((fit for fit in self.fits if fit.test == test), None)

    def to_toml(self) -> dict[str, Any]:
        """The contents of MATERIAL.toml; simulators take its `[material]`."""
        records = [item for test in self.setup.tests.values() for item in test.record().items()]
        return {
            "material": self.material.model_dump(),
            "uncertainty": {name: rounded(self.uncertainty(name)) for name in self.known},
            "bound": {fit.parameter: fit.bound for fit in map(self.bounding, PARAMETERS) if fit is not None},
            "correlation": {
                "parameters": list(self.known),
                "matrix": [[round(float(each), 3) for each in row] for row in self.correlation()],
            },
            "fit": [
                {
                    "test": fit.test,
                    "parameter": fit.parameter,
                    "measured": rounded(fit.measured, 6),
                    "uncertainty": rounded(fit.uncertainty),
                    "simulated": rounded(fit.simulated, 6),
                    "unit": fit.unit,
                    **({} if fit.alone is None else {"alone": rounded(fit.alone, 6)}),
                }
                for fit in self.fits
            ],
            "calibration": {
                "simulator": self.simulator,
                "tatamu": __version__,
                "garment": self.setup.garment.name,
                "assumed": list(self.assumed),
                "passes": self.passes,
                "simulations": self.simulations,
                "unsettled": rounded(self.unsettled),
                **{name: rounded(value, 6) for name, value in records},
            },
        }

    def save(self, path: Path) -> None:
        """Write MATERIAL.toml in one piece."""
        head = (
            f"# A cloth as the simulator {self.simulator} needs it; other simulators need another file. SI units.\n\n"
        )
        write_text(path, head + tomli_w.dumps(self.to_toml()))


def rounded(value: float, digits: int = 3) -> float:
    """A number with that many significant digits."""
    return float(f"{value:.{digits}g}")
