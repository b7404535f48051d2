"""Compression of cloth that wrinkles finer than its mesh: a membrane that resists it less than tension.

A sheet that is pushed does not shorten, it buckles; waves shorter than two cells are not on the mesh, and the mesh
would hold the load of a plate. As in tension field theory (Pipkin 1986; Choi and Ko 2002 for cloth) the energy is
therefore relaxed: with the principal strains E1 >= E2, and m = E2 + nu E1, which is s2 over q,

    W      = 1/2 Y psi(E1, b) + 1/2 q psi(m, (1 + nu) b),   q = Y / (1 - nu^2)
    psi(e) = e^2 for e > 0, c e^2 down to -b, c e^2 + (1 - c)(e + b)^2 beyond

c is the material's `compression`; with c = 1 this is St. Venant-Kirchhoff. b keeps triangles from turning inside out.
The second b is larger so that the stresses agree where E1 = E2. Derived in docs/native.md.
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
def tension(R, soft, e, n, tau):  # type: ignore[no-untyped-def]
    """Turn eps, in tau, into tau = 2 dW/d eps of the n triangles whose constants begin at place e; `soft` is c."""
    p0, p1, p2 = R[0, e : e + n], R[1, e : e + n], R[2, e : e + n]
    p3, p4, p5 = R[3, e : e + n], R[4, e : e + n], R[5, e : e + n]
    p6, p7, p8 = R[6, e : e + n], R[7, e : e + n], R[8, e : e + n]
    pull, push, ratio = R[9, e : e + n], R[10, e : e + n], R[11, e : e + n]
    t0, t1, t2 = tau[0, :n], tau[1, :n], tau[2, :n]
    crowded = np.float32(CROWDED)
    for j in range(n):
        e0, e1, e2 = t0[j], t1[j], t2[j]
        exx = p0[j] * e0 + p1[j] * e1 + p2[j] * e2
        eyy = p3[j] * e0 + p4[j] * e1 + p5[j] * e2
        shear = HALF * (p6[j] * e0 + p7[j] * e1 + p8[j] * e2)
        mean, half = HALF * (exx + eyy), HALF * (exx - eyy)
        radius = np.sqrt(half * half + shear * shear) + TINY
        nu = ratio[j]
        first = mean + radius
        across = _half_slope(mean - radius + nu * first, soft, (ONE + nu) * crowded)
        s1 = pull[j] * _half_slope(first, soft, crowded) + push[j] * nu * across
        s2 = push[j] * across
        middle, lean = HALF * (s1 + s2), HALF * (s1 - s2) / radius
        sxx, syy, sxy = middle + lean * half, middle - lean * half, lean * shear
        t0[j] = p0[j] * sxx + p3[j] * syy + p6[j] * sxy
        t1[j] = p1[j] * sxx + p4[j] * syy + p7[j] * sxy
        t2[j] = p2[j] * sxx + p5[j] * syy + p8[j] * sxy
