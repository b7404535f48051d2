"""What a calibration found, and the file it goes to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from tatamu import __version__
from tatamu.calibration.readings import Reading
from tatamu.calibration.setup import Setup
from tatamu.files import write_text
from tatamu.material import Material

PARAMETERS = ("areal_density", "stretch_stiffness", "bending_rigidity", "friction_table", "compression")
"""Fields of a material that calibration finds, in the order of its matrices."""
UNITS = dict(zip(PARAMETERS, ("kg/m²", "N/m", "N m", "-", "-"), strict=True))
SYMBOLS = dict(zip(PARAMETERS, ("ρ", "Y", "B", "μ", "c"), strict=True))


@dataclass(frozen=True)
class Fit:
    """How one test was matched."""

    test: str
    parameter: str
    measured: float
    """The reading: L1 - L2 [m], theta [rad], sag [m], height of the loop [m], how far the far edge moved [m]."""
    uncertainty: float
    """Its standard uncertainty."""
    aim: float
    """What was matched: the reading, or where it bounds the parameter, that moved by its uncertainty."""
    simulated: float
    """The same reading, simulated with the parameter found."""
    unit: str
    bound: str | None
    """None where the test tells the parameter; else "at least" or "at most": all that it tells."""
    samples: tuple[tuple[float, float], ...]
    """Simulated (parameter, reading); of friction (parameter, speed)."""
    alone: float | None = None
    """What this test alone says of the parameter, where it did not decide alone: of several tests that tell it, or of a
    bound that what was assumed keeps."""


@dataclass(frozen=True)
class Calibration:
    """A material with its uncertainties, for one simulator."""

    material: Material
    simulator: str
    setup: Setup
    fits: tuple[Fit, ...]
    contributions: Mapping[str, np.ndarray]
    """Reading to the part of each of `PARAMETERS` that one standard uncertainty of it moves, shape (5,)."""
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
    def textbook_friction(self) -> float | None:
        """tan(theta), None where friction was not measured."""
        return self.setup.slope.textbook if self.setup.slope else None

    @property
    def covariance(self) -> np.ndarray:
        """Of the logarithms of `PARAMETERS`, shape (5, 5)."""
        parts = np.array([np.zeros(len(PARAMETERS)), *self.contributions.values()])
        return np.asarray(parts.T @ parts)

    def relative(self, parameter: str) -> float:
        """Standard uncertainty of a parameter over its value."""
        place = PARAMETERS.index(parameter)
        return float(np.sqrt(self.covariance[place, place]))

    @property
    def known(self) -> tuple[str, ...]:
        """Parameters that the readings tell."""
        return tuple(name for name in PARAMETERS if name not in self.assumed and self.bounding(name) is None)

    def bounding(self, parameter: str) -> Fit | None:
        """The fit that bounds a parameter of which no test tells more; None where one does, or none was made."""
        fits = [fit for fit in self.fits if fit.parameter == parameter]
        return fits[-1] if fits and all(fit.bound for fit in fits) else None

    def uncertainty(self, parameter: str) -> float:
        """Standard uncertainty of a parameter, in its unit."""
        return self.relative(parameter) * float(getattr(self.material, parameter))

    def correlation(self) -> np.ndarray:
        """Correlations of the known parameters, shape (k, k)."""
        rows = [PARAMETERS.index(name) for name in self.known]
        part = self.covariance[np.ix_(rows, rows)]
        scale = np.sqrt(np.diag(part))
        return np.asarray(part / np.outer(scale, scale))

    def fit(self, test: str) -> Fit | None:
        """The fit of a test, None where it was not made."""
        return next((fit for fit in self.fits if fit.test == test), None)

    def to_toml(self) -> dict[str, Any]:
        """What MATERIAL.toml holds; `[material]` is what simulators take."""
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
                **({} if self.textbook_friction is None else {"tan_theta": rounded(self.textbook_friction, 6)}),
            },
        }

    def save(self, path: Path) -> None:
        """Write MATERIAL.toml in one piece."""
        head = (
            f"# A cloth as the simulator {self.simulator} needs it; other simulators need another file. SI units.\n\n"
        )
        write_text(path, head + tomli_w.dumps(self.to_toml()))


def rounded(value: float, digits: int = 3) -> float:
    """A number with so many figures."""
    return float(f"{value:.{digits}g}")
