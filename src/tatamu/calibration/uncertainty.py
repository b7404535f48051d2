"""From the readings' uncertainties to the parameters', to first order (JCGM 100:2008, 5.1 and 5.2).

At rest, lengths over the garment's own depend on Y / (rho g L) and B / (rho g L^3) alone. So how a reading f depends on
Y and B, which a few simulations tell, also tells how it depends on density and size:

    df/dln rho = -(f_Y + f_B),    df/dln L = f - f_Y - 3 f_B,    f_Y = df/dln Y,  f_B = df/dln B
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from tatamu.calibration.readings import Reading
from tatamu.calibration.result import PARAMETERS
from tatamu.errors import TatamuError

STEP = 0.1
"""Of the logarithm of a parameter, for differences."""
AGREES = 2.0
"""Tests of one parameter within so many standard uncertainties of one another agree."""


@dataclass(frozen=True)
class Slopes:
    """How a reading f depends on the logarithms of Y and B [m]."""

    reading: float
    stretch: float
    bending: float

    @property
    def density(self) -> float:
        """df/dln rho."""
        return -(self.stretch + self.bending)

    @property
    def size(self) -> float:
        """df/dln L, everything else fixed."""
        return self.reading - self.stretch - 3.0 * self.bending


def slopes(reading: Callable[[float, float], float], at: tuple[float, float]) -> Slopes:
    """Differences of reading(ln Y, ln B): central ones, or one-sided ones where the simulator gives up on one side."""
    stretch, bending = at
    here = reading(stretch, bending)

    def slope(more: float, less: float) -> float:
        known = [(value, step) for value, step in ((less, -STEP), (here, 0.0), (more, STEP)) if np.isfinite(value)]
        if len(known) < 2:
            raise TatamuError("uncertainty: the simulator gives up on cloth a little softer or stiffer than this")
        (first, low), (last, high) = known[0], known[-1]
        return (last - first) / (high - low)

    along_stretch = slope(reading(stretch + STEP, bending), reading(stretch - STEP, bending))
    return Slopes(here, along_stretch, slope(reading(stretch, bending + STEP), reading(stretch, bending - STEP)))


def contributions(
    readings: Mapping[str, Reading],
    elongation: Slopes | None,
    bending: Mapping[str, tuple[float, Slopes]],
    friction: tuple[float, float, float] | None,
) -> dict[str, np.ndarray]:
    """Change of the logarithm of each of `PARAMETERS`, shape (5,), with one standard uncertainty of each reading.

    Args:
        readings: By name.
        elongation: Slopes of L1 - L2; None where it tells no stretch stiffness.
        bending: Tests that tell bending rigidity, "sag" or "loop" or both: how much each has to say, and its slopes.
        friction: theta [rad], L_t [m] and the width of the search's interval over the coefficient; None: not measured.
    """
    found = {name: np.zeros(len(PARAMETERS)) for name in readings}
    for name, reading in readings.items():
        density = _share(reading) * {"mass": 1.0, "width": -1.0, "length": -1.0}.get(name, 0.0)
        found[name][0] = density
        found[name][1:3] = _elastic(name, reading, density, elongation, bending)
    if friction is not None:
        angle, board, interval = friction
        per_radian = 2.0 / np.sin(2.0 * angle)  # d ln tan(theta) / d theta
        per_height = per_radian / (board * np.cos(angle))
        found["H_s"][3] = per_height * readings["H_s"].uncertainty
        found["L_t"][3] = -per_height * np.sin(angle) * readings["L_t"].uncertainty
        found["search"] = np.array([0.0, 0.0, 0.0, interval / np.sqrt(12.0), 0.0])
    if "moved" in readings:
        _compression(found, readings)
    return found


def disagreement(values: list[float], spreads: list[float]) -> float:
    """What tests that differ on one parameter add to the uncertainty of its logarithm; nothing where they agree.

    That of the weighted mean is raised by the Birge ratio, as the Particle Data Group does.

    Args:
        values: What each test alone says of the parameter.
        spreads: Standard uncertainty of the logarithm of each.
    """
    if len(values) < 2:
        return 0.0
    logs, inverse = np.log(values), np.array(spreads) ** -2.0
    squares = float(inverse @ (logs - inverse @ logs / inverse.sum()) ** 2) / (len(values) - 1)
    return float(np.sqrt((squares - 1.0) / inverse.sum())) if squares > AGREES**2 else 0.0


def _compression(found: dict[str, np.ndarray], readings: Mapping[str, Reading]) -> None:
    """Of c, from those of the others: c = mu rho g L^2 / 2 Y (s - p), see `push`."""
    shorter = max(readings["pushed"].value - readings["moved"].value, readings["pushed"].uncertainty)
    own = {"push_length": 2.0 / readings["push_length"].value, "pushed": -1.0 / shorter, "moved": 1.0 / shorter}
    for name, change in found.items():
        change[4] = change[0] - change[1] + change[3]
        if name in own:
            change[4] += own[name] * readings[name].uncertainty


def _share(reading: Reading) -> float:
    """The error as a part of the reading; of an edge that stayed none."""
    return reading.uncertainty / reading.value if reading.value else 0.0


def _elastic(
    name: str,
    reading: Reading,
    density: float,
    elongation: Slopes | None,
    bending: Mapping[str, tuple[float, Slopes]],
) -> np.ndarray:
    """Changes of ln Y and ln B that make up for the change of one reading, shape (2,)."""
    error, share = reading.uncertainty, _share(reading)
    matrix, wanted = np.eye(2), np.zeros(2)
    if elongation is not None:
        own = {"L1": error, "L2": -error, "length": -elongation.size * share}.get(name, 0.0)
        matrix[0], wanted[0] = (elongation.stretch, elongation.bending), own - elongation.density * density
    for test, (weight, bent) in bending.items():
        read = {"sag": error, "free_length": -bent.size * share} if test == "sag" else {"height": error}
        matrix[1, 0] += weight * bent.stretch / bent.bending
        wanted[1] += weight * (read.get(name, 0.0) - bent.density * density) / bent.bending
    return np.asarray(np.linalg.solve(matrix, wanted))
