"""Tension field: a membrane that resists compression less than tension. It replaces wrinkles too fine for the mesh.

A compressed sheet buckles, but the mesh has no waves shorter than two cells, so it would carry load like a plate that
cannot buckle. The energy is therefore reduced, as in tension field theory (Pipkin 1986; Choi and Ko 2002 for cloth).
With the principal strains E1 >= E2 and m = E2 + nu E1, the second principal stress divided by q:

    W      = 1/2 Y psi(E1, b) + 1/2 q psi(m, (1 + nu) b),   q = Y / (1 - nu^2)
    psi(e) = e^2 for e > 0, c e^2 down to -b, c e^2 + (1 - c)(e + b)^2 beyond

c is the material's `compression`; with c = 1, the membrane is St. Venant-Kirchhoff. b is
`ElasticOptions.crowding_strain`, which keeps triangles from turning inside out. With 1 + nu, the stresses are equal at
E1 = E2. The derivation is in docs/theory/membrane.md.
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
"""Added to the radius of Mohr's circle, which is used as a divisor."""


def constants(inverse: np.ndarray, area: np.ndarray, material: Material) -> np.ndarray:
    """Return the constants of wrinkling, shape (12, m), or (12, 0) if the cloth does not wrinkle.

    Rows 0 to 8 are P^-1 from changes of squared edge lengths to strains [1/m^2], rows 9 and 10 twice the area times Y
    and times q [N m], and row 11 is nu.
    """
    nu = material.poisson_ratio
    if material.compression == 1.0:
        return np.zeros((12, 0))
    force = 2.0 * area * material.stretch_stiffness
    rows = [force, force / (1.0 - nu * nu), np.full(len(area), nu)]
    return np.concatenate([inverse.reshape(len(area), 9).T, rows])


@kernel
def _half_slope(e: float, compression: float, crowding: float) -> float:
    """Return half of the derivative of psi(e)."""
    return max(e, ZERO) + compression * min(e, ZERO) + (ONE - compression) * min(e + crowding, ZERO)


@kernel
def stress(
    exx: float, eyy: float, exy: float, young: float, plane: float, nu: float, compression: float, crowding: float
) -> tuple[float, float, float]:
    """Return the stress (xx, yy, xy) of a triangle for its Green strains, multiplied by twice its area A [N m].

    `young` is 2 A Y and `plane` is 2 A q, while `compression` and `crowding` are c and b.
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
