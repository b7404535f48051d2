"""Tension field: a membrane that resists compression less than tension. It replaces wrinkles too fine for the mesh.

A sheet that is compressed buckles instead of becoming shorter. Waves shorter than two cells are not possible on the
mesh. Without such waves, the mesh would carry load like a plate that cannot buckle. The energy is therefore reduced, as
in tension field theory (Pipkin 1986; Choi and Ko 2002 for cloth). E1 >= E2 are the principal strains. The number m = E2
+ nu E1 is the second principal stress divided by q. The formulas of the energy W are:

    W      = 1/2 Y psi(E1, b) + 1/2 q psi(m, (1 + nu) b),   q = Y / (1 - nu^2)
    psi(e) = e^2 for e > 0, c e^2 down to -b, c e^2 + (1 - c)(e + b)^2 beyond

Y is the stiffness and nu the Poisson ratio. c is the material's `compression`. With c = 1, the membrane is St.
Venant-Kirchhoff. b is `ElasticOptions.crowding_strain`, which keeps triangles from turning inside out. In the second
term, b is multiplied by 1 + nu, so that the stresses are equal at E1 = E2. The derivation is in
docs/theory/membrane.md.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tatamu.simulation.material import Material
from tatamu.simulation.native.compiled import kernel

# Constants in single precision. A plain 0.5 would convert everything that it is multiplied by to double precision.
HALF: Any = np.float32(0.5)
ZERO: Any = np.float32(0.0)
ONE: Any = np.float32(1.0)
TINY: Any = np.float32(1e-12)
"""Number that is added to the radius of Mohr's circle, because the radius is used as a divisor."""


def constants(inverse: np.ndarray, area: np.ndarray, material: Material) -> np.ndarray:
    """Return the constants of a membrane that wrinkles, with one column per triangle.

    There are no columns if the cloth resists compression as much as tension, because it then does not wrinkle.

    Args:
        inverse: The matrix P^-1 of each triangle from changes of squared edge lengths to strains [1/m^2], shape (m, 3,
            3).
        area: Area of each triangle [m^2], shape (m,).
        material: Material of the cloth.

    Returns:
        Array with one column for each of the m triangles, shape (12, m). Rows 0 to 8 are P^-1. Rows 9 and 10 are twice
        the area times Y and times q [N m]. Row 11 is the Poisson ratio nu.
    """
    nu = material.poisson_ratio
    if material.compression == 1.0:
        return np.zeros((12, 0))
    force = 2.0 * area * material.stretch_stiffness
    rows = [force, force / (1.0 - nu * nu), np.full(len(area), nu)]
    return np.concatenate([inverse.reshape(len(area), 9).T, rows])


@kernel
def _half_slope(e: float, compression: float, crowding: float) -> float:
    """Return half of the derivative of psi(e), the function in the energy of the tension field."""
    return max(e, ZERO) + compression * min(e, ZERO) + (ONE - compression) * min(e + crowding, ZERO)


@kernel
def stress(
    exx: float, eyy: float, exy: float, young: float, plane: float, nu: float, compression: float, crowding: float
) -> tuple[float, float, float]:
    """Return the stress of a triangle multiplied by twice its area [N m].

    Args:
        exx: Green strain E_xx [-].
        eyy: Green strain E_yy [-].
        exy: Green strain E_xy [-].
        young: Twice the area times the stiffness Y [N m].
        plane: Twice the area times the plane stiffness q [N m].
        nu: Poisson ratio [-].
        compression: Ratio c of compressive to tensile stiffness [-].
        crowding: Limit b of the compressive strain [-]. Below it, compression has only the fraction c of the stiffness.
            Strain beyond the limit meets the full stiffness, as in tension.

    Returns:
        The components xx, yy and xy.
    """
    mean = HALF * (exx + eyy)
    half = HALF * (exx - eyy)
    radius = np.sqrt(half * half + exy * exy) + TINY
    first = mean + radius
    across = _half_slope(mean - radius + nu * first, compression, (ONE + nu) * crowding)
    s1 = young * _half_slope(first, compression, crowding) + plane * nu * across
    s2 = plane * across
    middle = HALF * (s1 + s2)
    lean = HALF * (s1 - s2) / radius
    return middle + lean * half, middle - lean * half, lean * exy
