"""The air that a thin plate carries, and the drag on it, predicted from its size.

The formulas are from potential flow and the measured drag of rigid plates; none was measured on cloth. They serve to
choose a material's `air_*` fields if no swing of the cloth was timed. docs/theory/air.md derives them and compares them
with measurements.
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

    The disc carries 8/3 density radius^3 (Lamb, Hydrodynamics, article 102); divided by its area that is 8 / (3 pi)
    density radius.

    Args:
        radius: Radius of the disc [m].
        density: Density of the air [kg/m^3].
    """
    return 8.0 / (3.0 * np.pi) * density * radius


def rectangle_added_mass(length: float, width: float, density: float = AIR_DENSITY) -> float:
    """Return the added mass per area of a thin rectangle that moves along its normal [kg/m^2].

    The added mass of a rectangle with sides a <= b is C pi/4 density a^2 b. Without C this is the mass of an infinite
    strip. C depends on b / a; its values are from DNV-RP-C205, Environmental Conditions and Environmental Loads, table
    D-2, rectangular plates.
    Per area that is C pi/4 density a.

    Args:
        length: One side [m].
        width: The other side [m].
        density: Density of the air [kg/m^3].
    """
    short = min(length, width)
    aspect = max(length, width) / short
    part = np.interp(1.0 / aspect, 1.0 / _ASPECT[::-1], _COEFFICIENT[::-1])
    if aspect > _ASPECT[-1]:  # approaches 1, the strip's coefficient
        part = 1.0 - (1.0 - _COEFFICIENT[-1]) * _ASPECT[-1] / aspect
    return float(part * np.pi / 4.0 * density * short)


def steady_drag(density: float = AIR_DENSITY) -> float:
    """Return density C_D / 2, the drag per area and square of the speed of a square plate in steady flow [kg/m^3]."""
    return 0.5 * density * STEADY_DRAG


GRAHAM = 8.0
"""Drag coefficient at a Keulegan-Carpenter number of 1, which falls with its cube root (Graham 1980)."""
SHARE = 27.0 / 20.0
"""Mean of s^(-1/3) over the work of a harmonic stroke from 0 to 1, where 1 is at its end (docs/theory/air.md)."""


def swinging_drag(amplitude: float, width: float, density: float = AIR_DENSITY) -> float:
    """Return the drag per area and square of the speed of a plate that swings along its normal [kg/m^3].

    To and fro over less than its width, a plate has more drag than in a steady flow, because it meets its own vortices:
    C_D = 8 KC^(-1/3), with the Keulegan-Carpenter number KC = 2 pi amplitude / width (Graham 1980, J. Fluid Mech. 97,
    331 to 346; between KC 1 and 30). The result is at least the drag in a steady flow.

    Args:
        amplitude: Amplitude of the swing, half of peak to peak [m].
        width: Width of the plate, across the edges that shed vortices [m].
        density: Density of the air [kg/m^3].
    """
    number = 2.0 * np.pi * amplitude / width
    return 0.5 * density * max(GRAHAM * number ** (-1.0 / 3.0), STEADY_DRAG)


def turning_drag(width: float, density: float = AIR_DENSITY) -> float:
    """Return the drag along the normal of a plate after it turned around, `Material.air_drag_turning` [kg/m^(8/3)].

    After a path s since the turn the plate has drag with density C_D / 2, C_D = 8 / 1.35 (pi s / width)^(-1/3). Over a
    harmonic swing that takes as much energy as the C_D of `swinging_drag`, with KC = pi s / width at the end of a
    stroke.

    Args:
        width: Width of the plate, across the edges that shed vortices [m].
        density: Density of the air [kg/m^3].
    """
    return float(0.5 * density * GRAHAM / SHARE * np.cbrt(width / np.pi))


def skin_drag(frequency: float, density: float = AIR_DENSITY, viscosity: float = AIR_VISCOSITY) -> float:
    """Return the linear drag along both faces of a plate that swings in its own plane [N s/m^3].

    Stokes's second problem: the drag on each face is density sqrt(viscosity omega / 2) times its velocity.

    Args:
        frequency: Swings per second [1/s].
        density: Density of the air [kg/m^3].
        viscosity: Kinematic viscosity of the air [m^2/s].
    """
    return float(2.0 * density * np.sqrt(viscosity * np.pi * frequency))
