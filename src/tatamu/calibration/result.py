"""The result of a calibration, and its file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import tomli_w

from tatamu.base.files import write_text
from tatamu.base.version import __version__
from tatamu.calibration.estimate import Estimate
from tatamu.calibration.parameters import PARAMETERS
from tatamu.calibration.setup import Setup


@dataclass(frozen=True)
class Calibration(Estimate):
    """An estimate of a material, and the record of how the estimate was made."""

    setup: Setup
    passes: int
    """Number of passes over the tests whose readings are lengths of cloth at rest, until no parameter changed."""
    simulations: int
    unsettled: float
    """Largest change of any accepted reading over the last quarter of its simulation [m]."""

    def to_toml(self) -> dict[str, Any]:
        """Return the contents of the material's file, MATERIAL.toml. Simulators use its table `[material]`."""
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
                "size": [float(side) for side in self.setup.garment.size],
                "assumed": list(self.assumed),
                "passes": self.passes,
                "simulations": self.simulations,
                "unsettled": rounded(self.unsettled),
                **{name: rounded(value, 6) for name, value in records},
            },
        }

    def save(self, path: Path) -> None:
        """Write the material's file, MATERIAL.toml, atomically."""
        head = (
            f"# A cloth as the simulator {self.simulator} needs it; other simulators need another file. SI units.\n\n"
        )
        write_text(path, head + tomli_w.dumps(self.to_toml()))


def rounded(value: float, digits: int = 3) -> float:
    """Round a number to `digits` significant digits."""
    return float(f"{value:.{digits}g}")
