"""Uncertainties of parameters from uncertainties of readings, to first order (JCGM 100:2008, 5.1 and 5.2).

For cloth at rest, a length divided by the size L depends only on Y / (rho g L), B / (rho g L^3) and HB / (rho g L^2). A
few simulations give the derivatives f_Y, f_B and f_HB of a reading f by ln Y, ln B and ln HB, and so

    df/dln rho = -(f_Y + f_B + f_HB),    df/dln L = f - f_Y - 3 f_B - 2 f_HB,    f_Y = df/dln Y, ...
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from tatamu.base.errors import TatamuError
from tatamu.calibration.estimate import Fit
from tatamu.calibration.parameters import PARAMETERS, PLACE
from tatamu.calibration.readings import Reading
from tatamu.calibration.test import Changes, ElasticTest, LaterTest, Readings

ELASTIC = ("stretch_stiffness", "bending_rigidity", "bending_hysteresis")
"""Parameters on which lengths at rest depend."""


@dataclass(frozen=True)
class Slopes:
    """Derivatives of a reading [m] by the logarithms of stretch stiffness, bending rigidity and friction of bending."""

    reading: float
    stretch: float
    bending: float
    friction: float = 0.0

    @property
    def density(self) -> float:
        """Derivative by the logarithm of the areal density."""
        return -(self.stretch + self.bending + self.friction)

    @property
    def size(self) -> float:
        """Derivative by the logarithm of the garment's size."""
        return self.reading - self.stretch - 3.0 * self.bending - 2.0 * self.friction


def slopes(reading: Callable[..., float], at: tuple[float, ...], step: float) -> Slopes:
    """Return the derivatives of a reading, which is a function of the logarithms of the first `ELASTIC` parameters.

    They are central differences, or one-sided where the simulator fails.
    """
    here = reading(*at)

    def slope(more: float, less: float) -> float:
        known = [(value, step) for value, step in ((less, -step), (here, 0.0), (more, step)) if np.isfinite(value)]
        if len(known) < 2:
            raise TatamuError(
                "uncertainty: cannot be estimated, because simulations of slightly softer and stiffer cloth fail"
            )
        (first, low) = known[0]
        (last, high) = known[-1]
        return (last - first) / (high - low)

    steps = step * np.eye(len(at))
    return Slopes(here, *(slope(reading(*(at + each)), reading(*(at - each))) for each in steps))


@dataclass(frozen=True)
class Sensitivity:
    """Dependence of an elastic test's reading on all parameters in `ELASTIC`."""

    test: type[ElasticTest] | ElasticTest
    weight: float
    """Weight of this test among the tests of its parameter. The weights add up to 1."""
    slopes: Slopes
    chance: float = 0.0
    """Standard uncertainty of the simulated reading due to chance [m]."""


def contributions(
    readings: Readings, elastic: Sequence[Sensitivity], later: Sequence[tuple[LaterTest, Fit]]
) -> Changes:
    """Return by how much one standard uncertainty of each reading changes the logarithms of all `PARAMETERS`.

    `elastic` and `later` are the tests that determine a parameter, in the order in which they were made.
    """
    found = {name: np.zeros(len(PARAMETERS)) for name in readings}
    places = [PLACE[parameter] for parameter in ELASTIC]
    for name, reading in readings.items():
        density = _share(reading) * {"mass": 1.0, "width": -1.0, "length": -1.0}.get(name, 0.0)
        found[name][PLACE["areal_density"]] = density
        found[name][places] = _elastic(elastic, [_moved(each, name, reading, density) for each in elastic])
    if any(each.chance for each in elastic):
        found["chance"] = np.zeros(len(PARAMETERS))
        found["chance"][places] = _elastic(elastic, [each.chance for each in elastic])
    for _, fit in later:
        if fit.resolution is not None:
            found.setdefault("search", np.zeros(len(PARAMETERS)))[PLACE[fit.parameter]] = fit.resolution
    for test, fit in later:
        test.propagate(found, readings, fit)
    return found


def disagreement(values: list[float], spreads: list[float]) -> float:
    """Return the uncertainty of a parameter's logarithm that the disagreement of its tests adds; 0 if they agree.

    `spreads` are the uncertainties of the logarithms of the values. The Birge ratio increases that of their mean.
    """
    if len(values) < 2:
        return 0.0
    logs = np.log(values)
    inverse = np.array(spreads) ** -2.0
    squares = float(inverse @ (logs - inverse @ logs / inverse.sum()) ** 2) / (len(values) - 1)
    return float(np.sqrt((squares - 1.0) / inverse.sum())) if squares > 2.0**2 else 0.0


def _share(reading: Reading) -> float:
    """Return the uncertainty of a reading as a fraction of the reading; 0 if the reading is 0."""
    return reading.uncertainty / reading.value if reading.value else 0.0


def _moved(each: Sensitivity, name: str, reading: Reading, density: float) -> float:
    """Return the change of a test's reading [m] by one uncertain reading, which changes ln rho by `density`."""
    own = each.test.reads.get(name, 0.0) * reading.uncertainty
    scaled = each.slopes.size * _share(reading) if name == each.test.size else 0.0
    heavier = each.slopes.density * density if each.test.weighs else 0.0
    return own - scaled - heavier


def _elastic(tests: Sequence[Sensitivity], moved: Sequence[float]) -> np.ndarray:
    """Return the changes of the logarithms of `ELASTIC` that change the readings by `moved` [m], shape (3,)."""
    matrix = np.eye(len(ELASTIC))
    wanted = np.zeros(len(ELASTIC))
    for each, by in zip(tests, moved, strict=True):
        along = (each.slopes.stretch, each.slopes.bending, each.slopes.friction)
        row = ELASTIC.index(each.test.parameter)
        for other in range(len(ELASTIC)):
            if other != row:
                matrix[row, other] += each.weight * along[other] / along[row]
        wanted[row] += each.weight * by / along[row]
    return np.asarray(np.linalg.solve(matrix, wanted))
