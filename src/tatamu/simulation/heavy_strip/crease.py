"""Computes the crease of cloth: the loop at a fold that lies on the table under its own weight.

The arc length u along the strip goes from -U to U. Both ends of the strip lie flat. The end u = U is on the table, and
the end u = -U is exactly above it, one thickness higher. The strip is an inextensible chain of short links with the
minimum energy

    E / b = int  B/2 (d phi/du)^2 + rho g z  du,     z >= t/2 below, z >= 3t/2 above,

for the lower half of the strip (u > 0) and the upper half (u < 0), with the width b, the thickness t, the direction phi
and the height z.

In units of the bending length l_b, the shape depends only on t / l_b. If l_b is about as small as t, the cloth is limp,
and its crease is nearly a circle. A stack of layers that slide on each other has the bending length of a single layer,
and the thickness of the whole stack.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.optimize import minimize
from threadpoolctl import threadpool_limits

from tatamu.base.errors import TatamuError

LINKS = 100
HALF_LENGTH = 4.5
"""Half of the strip's arc length, U, in bending lengths. The loop is shorter, so both ends of the strip are flat."""
STEP = 2 * HALF_LENGTH / LINKS
"""Length of a link, in bending lengths."""
SHARPEST = 0.75
"""Minimum bending length for which a crease is computed, in thicknesses. It replaces smaller ones."""
GUESSED_WIDTH = 1.4
"""Arc length of the bent part at the start of the minimisation, in bending lengths."""
TOLERANCE = 1e-8
"""Change of the energy in one step with which the minimisation ends, in units of w l_b^2."""
MOST_ITERATIONS = 300
"""Maximum number of iterations. About 75 are enough for any cloth."""
AFTER = np.tril(np.ones((LINKS + 1, LINKS)), -1)
"""1 where a node (row) comes after a link (column), and so moves if it turns; otherwise 0."""


@dataclass(frozen=True)
class Crease:
    """The profile of folded cloth near the fold, in the vertical plane across the fold line."""

    arc: np.ndarray
    """Signed distances u of points from the fold line on the flat cloth [m], increasing, shape (k,). The side u > 0
    stays on the table."""
    x: np.ndarray
    """Distances of the points from the fold line after the fold, towards the side that stays [m], shape (k,)."""
    z: np.ndarray
    """Heights of the cloth's mid-surface above the table at the points [m], shape (k,)."""

    def place(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return x and z of the crease at arc lengths u [m].

        Outside the profile, the two layers lie flat on each other.
        """
        inside = np.abs(u) <= self.arc[-1]
        x = np.where(inside, np.interp(u, self.arc, self.x), np.abs(u))
        z = np.where(inside, np.interp(u, self.arc, self.z), np.where(u > 0, self.z[-1], self.z[0]))
        return x, z

    def normals(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return x and z of unit vectors across the strip at arc lengths u.

        The vectors point into the loop: up in the lower layer, and down in the upper layer.
        """
        along_x = np.gradient(self.x, self.arc)
        along_z = np.gradient(self.z, self.arc)
        inside = np.abs(u) <= self.arc[-1]
        x = np.where(inside, -np.interp(u, self.arc, along_z), 0.0)
        z = np.where(inside, np.interp(u, self.arc, along_x), np.sign(u))
        size = np.maximum(np.hypot(x, z), 1e-9)
        return x / size, z / size


def crease(bending_length: float, thickness: float) -> Crease:
    """Return the crease of a cloth with the given bending length [m] and thickness [m].

    Raises:
        TatamuError: If the minimisation does not converge. It converged for every cloth that was tried.
    """
    length = max(bending_length, SHARPEST * thickness)
    arc, x, z = _profile(round(thickness / length, 6))
    return Crease(arc * length, x * length, z * length)


@lru_cache(maxsize=32)
def _profile(thickness: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the arc lengths, x and z of a crease. The thickness and all results are in bending lengths."""
    phi = least_energy(thickness)
    x, z = nodes(phi, thickness)
    arc = HALF_LENGTH - STEP * np.arange(LINKS + 1)
    return arc[::-1], x[::-1], z[::-1]


def nodes(phi: np.ndarray, thickness: float) -> tuple[np.ndarray, np.ndarray]:
    """Return x and z of the nodes of a chain with the link directions phi [rad], shapes (LINKS + 1,).

    The first node is at the end u = U on the table. The thickness and the results are in bending lengths.
    """
    x = HALF_LENGTH + STEP * np.concatenate([[0.0], np.cumsum(np.cos(phi))])
    z = thickness / 2 + STEP * np.concatenate([[0.0], np.cumsum(np.sin(phi))])
    return x, z


def least_energy(thickness: float) -> np.ndarray:
    """Return the directions phi of the links at the minimum of the energy [rad], shape (LINKS,).

    The thickness is in bending lengths.

    Raises:
        TatamuError: If the minimisation does not converge.
    """

    def energy(phi: np.ndarray) -> tuple[float, np.ndarray]:
        bend = np.diff(np.concatenate([[np.pi], phi, [0.0]]))
        _, z = nodes(phi, thickness)
        slope = (bend[:-1] - bend[1:]) / STEP + STEP * STEP * np.cos(phi) * (LINKS - np.arange(LINKS))
        return float((bend**2).sum() / (2 * STEP) + STEP * z[1:].sum()), slope

    def miss(phi: np.ndarray) -> np.ndarray:
        x, z = nodes(phi, thickness)
        return np.array([x[-1] - HALF_LENGTH, z[-1] - 1.5 * thickness])

    floor = np.where(np.arange(LINKS + 1) <= LINKS // 2, thickness / 2, 1.5 * thickness)
    constraints = [
        {
            "type": "eq",
            "fun": miss,
            "jac": lambda phi: STEP * np.stack([-np.sin(phi), np.cos(phi)]),
        },
        {
            "type": "ineq",
            "fun": lambda phi: (nodes(phi, thickness)[1] - floor)[1:-1],
            "jac": lambda phi: (STEP * AFTER * np.cos(phi))[1:-1],
        },
    ]
    with threadpool_limits(1):  # with more threads, the last bit of a product may change
        result = minimize(
            energy,
            guess(),
            jac=True,
            method="SLSQP",
            constraints=constraints,
            options={"maxiter": MOST_ITERATIONS, "ftol": TOLERANCE},
        )
    if not result.success:
        raise TatamuError(f"crease: no shape of least energy found for {thickness:g} l_b thick cloth: {result.message}")
    return np.asarray(result.x)


def guess() -> np.ndarray:
    """Return the directions of the links at the start of the minimisation [rad], shape (LINKS,).

    The directions describe a flat strip that is bent over in a half circle.
    """
    turn = np.clip((np.arange(LINKS) + 0.5 - LINKS / 2) * STEP / GUESSED_WIDTH, -0.5, 0.5)
    return np.pi * (0.5 - turn)
