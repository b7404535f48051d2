"""Compression of cloth that wrinkles finer than its mesh: a membrane that resists it less than tension.

A sheet that is pushed does not shorten, it buckles; waves shorter than two cells are not on the mesh, and the mesh
would hold the load of a plate. As in tension field theory (Pipkin 1986; Choi and Ko 2002 for cloth) the energy is
therefore relaxed: with the principal strains E1 >= E2, and m = E2 + nu E1, which is s2 over q,

    W      = 1/2 Y psi(E1, b) + 1/2 q psi(m, (1 + nu) b),   q = Y / (1 - nu^2)
    psi(e) = e^2 for e > 0, c e^2 down to -b, c e^2 + (1 - c)(e + b)^2 beyond

c is the material's `compression`; with c = 1 this is St. Venant-Kirchhoff. b keeps triangles from turning inside out.
The second b is larger so that the stresses agree where E1 = E2. Derived in docs/theory/membrane.md.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from tatamu.material import Material

CROWDED = 0.2
"""b: compressed by this Green strain the membrane is as stiff again as in tension; its length is then 0.77."""
HALF, ZERO, ONE, TINY = np.float32(0.5), np.float32(0.0), np.float32(1.0), np.float32(1e-12)


def constants(inverse: np.ndarray, area: np.ndarray, material: Material) -> np.ndarray:
    """What the relaxed membrane needs of each triangle, shape (12, m); shape (12, 0) of one that is not relaxed.

    Args:
        inverse: P^-1 of each triangle [1/m^2], shape (m, 3, 3).
        area: Of each triangle [m^2], shape (m,).
        material: The cloth.
    """
    count, nu = len(area), material.poisson_ratio
    if material.compression == 1.0:
        return np.zeros((12, 0))
    force = 2.0 * area * material.stretch_stiffness
    rows = [force, force / (1.0 - nu * nu), np.full(count, nu)]
    return np.concatenate([inverse.reshape(count, 9).T, rows])


@njit(cache=True, error_model="numpy")
def _half_slope(e, soft, crowded):  # type: ignore[no-untyped-def]
    """Half of d psi / d e, `crowded` being b."""
    return max(e, ZERO) + soft * min(e, ZERO) + (ONE - soft) * min(e + crowded, ZERO)


@njit(cache=True, error_model="numpy")
def stress(exx, eyy, exy, pull, push, nu, soft):  # type: ignore[no-untyped-def]
    """2 dW/dE (xx, yy, xy) of a triangle; `pull`, `push` and nu as in `constants`, `soft` is c."""
    crowded = np.float32(CROWDED)
    mean, half = HALF * (exx + eyy), HALF * (exx - eyy)
    radius = np.sqrt(half * half + exy * exy) + TINY
    first = mean + radius
    across = _half_slope(mean - radius + nu * first, soft, (ONE + nu) * crowded)
    s1 = pull * _half_slope(first, soft, crowded) + push * nu * across
    s2 = push * across
    middle, lean = HALF * (s1 + s2), HALF * (s1 - s2) / radius
    return middle + lean * half, middle - lean * half, lean * exy
