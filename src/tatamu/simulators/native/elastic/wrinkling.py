"""Tension field: a membrane that resists compression less than tension, for wrinkles finer than the mesh.

A sheet that is pushed does not shorten, it buckles; waves shorter than two cells are not on the mesh, and the mesh
would hold the load of a plate. As in tension field theory (Pipkin 1986; Choi and Ko 2002 for cloth) the energy is
therefore relaxed: with the principal strains E1 >= E2, and m = E2 + nu E1, which is s2 over q,

    W      = 1/2 Y psi(E1, b) + 1/2 q psi(m, (1 + nu) b),   q = Y / (1 - nu^2)
    psi(e) = e^2 for e > 0, c e^2 down to -b, c e^2 + (1 - c)(e + b)^2 beyond

c is the material's `compression`; with c = 1 this is St. Venant-Kirchhoff. b, `ElasticOptions.crowding_strain`, keeps
triangles from turning inside out.
The second b is larger so that the stresses agree where E1 = E2. Derived in docs/theory/membrane.md.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tatamu.material import Material
from tatamu.simulators.native.compiled import kernel

# In single precision: a plain 0.5 would make all that it is multiplied by double.
HALF: Any = np.float32(0.5)
ZERO: Any = np.float32(0.0)
ONE: Any = np.float32(1.0)
TINY: Any = np.float32(1e-12)
"""Added to the radius of Mohr's circle, so that equal principal strains have some direction."""


def constants(inverse: np.ndarray, area: np.ndarray, material: Material) -> np.ndarray:
    """Constants of the relaxed membrane, per triangle; shape (12, 0) of cloth that is not relaxed.

    Args:
        inverse: P^-1 of each triangle [1/m^2], shape (m, 3, 3).
        area: Area of each triangle [m^2], shape (m,).
        material: The cloth.

    Returns:
        Rows of P^-1 (0 to 8), twice the area times Y (9) and times q (10) [N m], and nu (11), shape (12, m).
    """
    nu = material.poisson_ratio
    if material.compression == 1.0:
        return np.zeros((12, 0))
    force = 2.0 * area * material.stretch_stiffness
    rows = [force, force / (1.0 - nu * nu), np.full(len(area), nu)]
    return np.concatenate([inverse.reshape(len(area), 9).T, rows])


@kernel
def _half_slope(e: float, compression: float, crowding: float) -> float:
    """Half of d psi / d e."""
    return max(e, ZERO) + compression * min(e, ZERO) + (ONE - compression) * min(e + crowding, ZERO)


@kernel
def stress(
    exx: float, eyy: float, exy: float, young: float, plane: float, nu: float, compression: float, crowding: float
) -> tuple[float, float, float]:
    """Stress of a triangle, times twice its area, 2 dW/dE [N m].

    Args:
        exx: Green strain E_xx; eyy and exy likewise [-].
        eyy: See exx.
        exy: See exx.
        young: Twice the area times Y [N m].
        plane: Twice the area times q [N m].
        nu: Poisson ratio [-].
        compression: c [-].
        crowding: b [-].

    Returns:
        Its components xx, yy, xy.
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
