"""Added mass and drag of a thin plate in air, predicted from its size.

The formulas come from potential flow and from the measured drag of rigid plates. None of them was measured on cloth.
They help to choose the `air_*` fields of a material if no swing of the cloth was timed. The formulas are derived and
compared with measurements in docs/theory/air.md.
"""

from __future__ import annotations

import numpy as np

AIR_DENSITY = 1.2
"""Density of air at 20 degrees Celsius [kg/m^3]."""
AIR_VISCOSITY = 1.5e-5
"""Kinematic viscosity of air at 20 degrees Celsius [m^2/s]."""

_ASPECT = np.array([1.0, 1.25, 1.59, 2.0, 2.5, 3.17, 4.0, 5.0, 6.25, 8.0, 10.0])
_COEFFICIENT = np.array([0.579, 0.642, 0.704, 0.757, 0.801, 0.840, 0.872, 0.897, 0.917, 0.934, 0.947])
STEADY_DRAG = 1.17
"""Drag coefficient of a square plate across a steady flow (Hoerner, Fluid-Dynamic Drag, 1965, section 3)."""


def disc_added_mass(radius: float, density: float = AIR_DENSITY) -> float:
    """Return the added mass per area of a thin disc that moves along its axis [kg/m^2].

    The disc carries the mass 8/3 density radius^3 (Lamb, Hydrodynamics, article 102). Divided by the disc's area, this
    is 8 / (3 pi) density radius.

    Args:
        radius: Radius of the disc [m].
        density: Density of the air [kg/m^3].
    """
    return 8.0 / (3.0 * np.pi) * density * radius


def rectangle_added_mass(length: float, width: float, density: float = AIR_DENSITY) -> float:
    """Return the added mass per area of a thin rectangle that moves along its normal [kg/m^2].

    The added mass of a rectangle with sides a <= b is C pi/4 density a^2 b. Without the factor C, the formula is the
    added mass of a part of an infinite strip. C depends on b / a. Its values come from the table D-2 for rectangular
    plates in DNV-RP-C205, Environmental Conditions and Environmental Loads. The added mass per area is C pi/4 density
    a.

    Args:
        length: Length of one side [m].
        width: Length of the other side [m].
        density: Density of the air [kg/m^3].
    """
    short = min(length, width)
    aspect = max(length, width) / short
    part = np.interp(1.0 / aspect, 1.0 / _ASPECT[::-1], _COEFFICIENT[::-1])
    if aspect > _ASPECT[-1]:  # C approaches 1, the value of a strip
        part = 1.0 - (1.0 - _COEFFICIENT[-1]) * _ASPECT[-1] / aspect
    return float(part * np.pi / 4.0 * density * short)


def steady_drag(density: float = AIR_DENSITY) -> float:
    """Return the drag per area and square of the speed of a square plate in steady flow [kg/m^3].

    The drag is density C_D / 2, with the drag coefficient C_D.
    """
    return 0.5 * density * STEADY_DRAG


GRAHAM = 8.0
"""Drag coefficient at a Keulegan-Carpenter number of 1. The drag coefficient is inversely proportional to the cube root
of this number (Graham 1980)."""
SHARE = 27.0 / 20.0
"""Mean of s^(-1/3) over a half swing, weighted by the work of drag (docs/theory/air.md). The variable s is the covered
fraction of the half swing's path: 0 at the start and 1 at the end."""


def swinging_drag(amplitude: float, width: float, density: float = AIR_DENSITY) -> float:
    """Return the drag per area and square of the speed of a plate that swings along its normal [kg/m^3].

    A plate that moves to and fro over less than its width meets its own vortices, so its drag is larger than in a
    steady flow. The drag coefficient is C_D = 8 KC^(-1/3), with the Keulegan-Carpenter number KC = 2 pi amplitude /
    width (Graham 1980, J. Fluid Mech. 97, 331 to 346; between KC 1 and 30). The result is at least the drag in a steady
    flow.

    Args:
        amplitude: Amplitude of the swing, which is half of the peak-to-peak motion [m].
        width: Width of the plate across the edges at which vortices form [m].
        density: Density of the air [kg/m^3].
    """
    number = 2.0 * np.pi * amplitude / width
    return 0.5 * density * max(GRAHAM * number ** (-1.0 / 3.0), STEADY_DRAG)


def turning_drag(width: float, density: float = AIR_DENSITY) -> float:
    """Return the constant of drag along the normal of a plate after a reversal of motion [kg/m^(8/3)].

    The constant is the value of the field `Material.air_drag_turning`.

    After a path s since the reversal, the drag is density C_D / 2, with C_D = 8 / 1.35 (pi s / width)^(-1/3). Over a
    harmonic swing, this drag takes as much energy as the constant C_D of `swinging_drag`. For this comparison, the
    number KC of `swinging_drag` is pi s / width, where s is the path at the end of a half swing.

    Args:
        width: Width of the plate across the edges at which vortices form [m].
        density: Density of the air [kg/m^3].
    """
    return float(0.5 * density * GRAHAM / SHARE * np.cbrt(width / np.pi))


def skin_drag(frequency: float, density: float = AIR_DENSITY, viscosity: float = AIR_VISCOSITY) -> float:
    """Return the linear drag along both faces of a plate that swings in its own plane [N s/m^3].

    This is Stokes's second problem. The drag on each face is density sqrt(viscosity omega / 2) times the velocity of
    the face, with the angular frequency omega.

    Args:
        frequency: Number of swings per second [1/s].
        density: Density of the air [kg/m^3].
        viscosity: Kinematic viscosity of the air [m^2/s].
    """
    return float(2.0 * density * np.sqrt(viscosity * np.pi * frequency))
