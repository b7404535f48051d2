"""Fits the bending rigidity of fabrics for which it was not measured.

The rigidity is fitted to the measured drape coefficient. The anisotropy is the ratio of the rigidities along warp and
weft. It may be fitted as well, to the elliptical shape of the hem. For the fit, drapes are simulated with several
rigidities and, if needed, several anisotropies. The fitted values are interpolated between these simulations.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from studies.real_cloth import drape
from studies.real_cloth.bench import Bench
from studies.real_cloth.drape import Draped, Size
from studies.real_cloth.fabric import WARP, WEFT, Fabric
from tatamu.simulation.material import Material

DENSITY = 0.2
"""Areal density of all simulated fabrics [kg/m^2]. The choice does not matter, because only ratios to the density
affect a drape."""
RIGIDITIES = tuple(np.geomspace(7e-7, 4e-5, 7).tolist())
"""Bending rigidities with which drapes are simulated, so that rigidities can be fitted by interpolation [N m]."""
SWEPT = 2
"""Number of repeats of each drape that is simulated to fit a bending rigidity."""
TYPICAL = WARP / WEFT
"""Anisotropy of a typical weave: the ratio of the rigidities along warp and weft."""
ANISOTROPIES = (1.0, TYPICAL, 3.0)
"""Ratios of the rigidities along warp and weft with which drapes are simulated for a fit. In Feng et al. 2022, 18 % of
618 fabrics have a ratio of 3 or more."""
ELLIPSE = 2
"""Order of the harmonic of a draped hem that results from different rigidities along warp and weft."""


@dataclass(frozen=True)
class FittedModel:
    """A model of fabrics whose bending rigidity is not known."""

    name: str
    fitted: str
    """Description of the numbers that are fitted, and of the measurements to which they are fitted."""
    material: Callable[[Fabric, float], Material]
    """Function that returns the material of a fabric with a given anisotropy, the ratio of rigidities along warp and
    weft."""
    anisotropies: Sequence[float] = (TYPICAL,)
    """Ratios of the rigidities along warp and weft with which drapes are simulated for a fit. If there is only one
    value, it is assumed and not fitted."""
    waviness: float = 0.0
    """Standard deviation of the height of wavy unstrained cloth [m]; 0 for flat cloth."""
    times: int = 1
    """Factor by which this model has more repeats of each drape than other models."""
    needs: tuple[str, ...] = ()
    """Names of the capabilities that a simulator must have for this model."""
    rigidities: Sequence[float] = RIGIDITIES
    """Bending rigidities with which drapes are simulated for a fit [N m]."""

    @property
    def swept(self) -> int:
        """Number of drapes that are simulated to fit the numbers of this model."""
        return len(self.anisotropies) * len(self.rigidities) * SWEPT

    def draped(self, fabrics: Sequence[FittedFabric], size: Size, repeats: int, bench: Bench) -> list[Draped]:
        """Simulate the drapes of fabrics with their fitted numbers, and return a result for each fabric."""
        groups = [
            drape.experiments(
                f"{each.name}, {self.name}",
                self.material(Fabric(each.name, "unknown", DENSITY, each.bending), each.anisotropy),
                size,
                repeats,
                self.waviness,
            )
            for each in fabrics
        ]
        values = bench.measure([experiment for group in groups for experiment in group])
        return [Draped.of(values[k : k + repeats], size) for k in range(0, len(values), repeats)]


@dataclass(frozen=True)
class FittedFabric:
    """A fabric with the numbers that were fitted to its drape."""

    name: str
    bending: float
    """Bending rigidity B of the fabric [N m]."""
    anisotropy: float
    """Ratio of the fabric's rigidities along warp and weft."""


@dataclass(frozen=True)
class Sweep:
    """Simulated drapes of a model of fabrics, for all combinations of given anisotropies and rigidities."""

    anisotropies: Sequence[float]
    rigidities: Sequence[float]
    """Bending rigidities with which drapes were simulated [N m]."""
    drapes: Sequence[Sequence[Draped]]

    @classmethod
    def of(cls, model: FittedModel, size: Size, bench: Bench) -> Sweep:
        """Simulate the drapes of a model of fabrics, for all its anisotropies and bending rigidities."""
        fabrics = [
            FittedFabric(f"B = {1e6 * bending:.2g} µN m", float(bending), anisotropy)
            for anisotropy in model.anisotropies
            for bending in model.rigidities
        ]
        drapes = model.draped(fabrics, size, SWEPT, bench)
        count = len(model.rigidities)
        groups = [drapes[k : k + count] for k in range(0, len(drapes), count)]
        return cls(model.anisotropies, model.rigidities, groups)

    def fitted(self, name: str, coefficient: float, ellipse: float) -> FittedFabric:
        """Return the fabric with this drape coefficient [%] and second harmonic of the hem [m], by interpolation."""
        bendings = [self._rigidity(coefficient, drapes) for drapes in self.drapes]
        ellipses = [self._ellipse(bending, drapes) for bending, drapes in zip(bendings, self.drapes, strict=True)]
        rising = np.maximum.accumulate(ellipses)
        sought = float(np.interp(ellipse, rising, np.log(self.anisotropies)))
        bending = float(np.exp(np.interp(sought, np.log(self.anisotropies), np.log(bendings))))
        return FittedFabric(name, bending, float(np.exp(sought)))

    def _rigidity(self, coefficient: float, drapes: Sequence[Draped]) -> float:
        """Return the bending rigidity for which the simulated drape has the measured drape coefficient [N m]."""
        means = np.maximum.accumulate([drawn.mean for drawn in drapes])
        return float(np.exp(np.interp(coefficient, means, np.log(self.rigidities))))

    def _ellipse(self, bending: float, drapes: Sequence[Draped]) -> float:
        """Return the amplitude of the hem's second harmonic for a fabric with a given bending rigidity [m]."""
        harmonics = [drawn.harmonic(ELLIPSE) for drawn in drapes]
        return float(np.interp(np.log(bending), np.log(self.rigidities), harmonics))
