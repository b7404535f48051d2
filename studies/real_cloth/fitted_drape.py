"""Fabrics without a measured rigidity, which is fitted to the drape coefficient, and anisotropy to the hem's ellipse.

Drapes are simulated over a sweep of rigidities, and of a few anisotropies if these are fitted; the fit is interpolated
between them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from studies.real_cloth import drape
from studies.real_cloth.bench import Bench
from studies.real_cloth.drape import Draped, Size
from studies.real_cloth.fabric import WARP, WEFT, Fabric
from tatamu.material import Material

DENSITY = 0.2
"""Areal density of all simulated fabrics [kg/m^2]; only ratios to it matter."""
RIGIDITIES = tuple(np.geomspace(7e-7, 4e-5, 7).tolist())
"""Rigidities of the sweep [N m]."""
SWEPT = 2
"""Number of repeats of each drape."""
TYPICAL = WARP / WEFT
"""Rigidity along the warp over that along the weft, of a typical weave."""
ANISOTROPIES = (1.0, TYPICAL, 3.0)
"""Anisotropies of the sweep; 18 % of the 618 fabrics of Feng et al. 2022 have 3 or more."""
ELLIPSE = 2
"""Harmonic of the hem that an anisotropy causes."""


@dataclass(frozen=True)
class FittedModel:
    """A model of fabrics without a known rigidity."""

    name: str
    fitted: str
    """The fitted numbers, and the measurements to which they are fitted."""
    material: Callable[[Fabric, float], Material]
    """Material of a fabric and an anisotropy."""
    anisotropies: Sequence[float] = (TYPICAL,)
    """The assumed anisotropy, or those of the sweep."""
    waviness: float = 0.0
    """Waviness of the unstrained cloth [m]."""
    times: int = 1
    """Ratio of its number of repeats to that of other models."""
    needs: tuple[str, ...] = ()
    """Capabilities of a simulator without which it cannot."""
    rigidities: Sequence[float] = RIGIDITIES
    """Rigidities of the sweep [N m]."""

    @property
    def swept(self) -> int:
        """Return the number of drapes of a sweep."""
        return len(self.anisotropies) * len(self.rigidities) * SWEPT

    def draped(self, fabrics: Sequence[FittedFabric], size: Size, repeats: int, bench: Bench) -> list[Draped]:
        """Simulate the drapes of some fabrics."""
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
    """A fabric with its fitted numbers."""

    name: str
    bending: float
    """B [N m]."""
    anisotropy: float
    """Rigidity along the warp over that along the weft."""


@dataclass(frozen=True)
class Sweep:
    """Drapes over the rigidities of a model, for each of its anisotropies."""

    anisotropies: Sequence[float]
    rigidities: Sequence[float]
    """[N m]"""
    drapes: Sequence[Sequence[Draped]]

    @classmethod
    def of(cls, model: FittedModel, size: Size, bench: Bench) -> Sweep:
        """Simulate the drapes."""
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
        """Return the fabric with this drape coefficient [%] and, if anisotropy is fitted, this second harmonic [m]."""
        bendings = [self._rigidity(coefficient, drapes) for drapes in self.drapes]
        ellipses = [self._ellipse(bending, drapes) for bending, drapes in zip(bendings, self.drapes, strict=True)]
        rising = np.maximum.accumulate(ellipses)
        sought = float(np.interp(ellipse, rising, np.log(self.anisotropies)))
        bending = float(np.exp(np.interp(sought, np.log(self.anisotropies), np.log(bendings))))
        return FittedFabric(name, bending, float(np.exp(sought)))

    def _rigidity(self, coefficient: float, drapes: Sequence[Draped]) -> float:
        """Return the rigidity at which the sweep has the measured coefficient [N m]."""
        means = np.maximum.accumulate([drawn.mean for drawn in drapes])
        return float(np.exp(np.interp(coefficient, means, np.log(self.rigidities))))

    def _ellipse(self, bending: float, drapes: Sequence[Draped]) -> float:
        """Return the second harmonic of a rigidity [m]."""
        harmonics = [drawn.harmonic(ELLIPSE) for drawn in drapes]
        return float(np.interp(np.log(bending), np.log(self.rigidities), harmonics))
