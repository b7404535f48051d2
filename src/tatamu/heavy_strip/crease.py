"""The crease of cloth: the loop of minimum energy at a fold, lying on the table under its own weight.

A strip of arc length 2U, u in [-U, U], lies flat at both ends. The end u = U is on the table. The end u = -U is right
above it, one thickness higher, so that the layers are flush. Between them it takes the shape of minimum bending and
gravitational energy

    E / b = int  B/2 (d phi/du)^2 + rho g z  du,     z >= t/2 below, z >= 3t/2 above,

b the width, phi the direction of the strip: a heavy elastica with contact, as an inextensible chain of short links. In
units of the bending length only t / l_b remains, and limp cloth (l_b of the order of t) is folded round a circle. A
stack of layers that slide on each other has the bending length of one of them and the thickness of all.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.optimize import minimize
from threadpoolctl import threadpool_limits

from tatamu.errors import TatamuError

LINKS = 100
HALF_LENGTH = 4.5
"""U in bending lengths: the loop of a heavy strip is shorter than this on either side."""
STEP = 2 * HALF_LENGTH / LINKS
"""Length of a link in bending lengths."""
SHARPEST = 0.75
"""Lowest bending length for which a crease is computed, in thicknesses; limper cloth gets the same shape."""
GUESSED_WIDTH = 1.4
"""Arc length of half the turn at the start of the minimisation [bending lengths]."""
TOLERANCE = 1e-8
"""Change of the energy at which the minimisation ends [w l_b^2]."""
MOST_ITERATIONS = 300
"""Largest number of iterations; about 75 are enough from the thinnest cloth to `SHARPEST`."""
AFTER = np.tril(np.ones((LINKS + 1, LINKS)), -1)
"""1 where a node (row) comes after a link (column) and so moves as that link turns, shape (LINKS + 1, LINKS)."""


@dataclass(frozen=True)
class Crease:
    """The profile of a fold in the vertical plane across the fold line."""

    arc: np.ndarray
    """Signed distance u from the fold line on the flat cloth [m], increasing, shape (k,); u > 0 stays on the table."""
    x: np.ndarray
    """Distance of that point from the fold line, towards the side that stays [m], shape (k,)."""
    z: np.ndarray
    """Height of the mid-surface over the table [m], shape (k,)."""

    def place(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return x and z of points at arc lengths u; beyond the profile the layers lie flat and flush."""
        inside = np.abs(u) <= self.arc[-1]
        x = np.where(inside, np.interp(u, self.arc, self.x), np.abs(u))
        z = np.where(inside, np.interp(u, self.arc, self.z), np.where(u > 0, self.z[-1], self.z[0]))
        return x, z

    def normals(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return x and z of unit vectors across the strip at arc lengths u, into the loop: up below, down above."""
        along_x = np.gradient(self.x, self.arc)
        along_z = np.gradient(self.z, self.arc)
        inside = np.abs(u) <= self.arc[-1]
        x = np.where(inside, -np.interp(u, self.arc, along_z), 0.0)
        z = np.where(inside, np.interp(u, self.arc, along_x), np.sign(u))
        size = np.maximum(np.hypot(x, z), 1e-9)
        return x / size, z / size


def crease(bending_length: float, thickness: float) -> Crease:
    """Return the crease of a cloth with bending length l_b [m] and thickness t [m].

    Raises:
        TatamuError: If the minimisation did not converge, as it did for every cloth tried.
    """
    length = max(bending_length, SHARPEST * thickness)
    arc, x, z = _profile(round(thickness / length, 6))
    return Crease(arc * length, x * length, z * length)


@lru_cache(maxsize=32)
def _profile(thickness: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return arc, x and z in bending lengths for a thickness in bending lengths."""
    phi = least_energy(thickness)
    x, z = nodes(phi, thickness)
    arc = HALF_LENGTH - STEP * np.arange(LINKS + 1)
    return arc[::-1], x[::-1], z[::-1]


def nodes(phi: np.ndarray, thickness: float) -> tuple[np.ndarray, np.ndarray]:
    """Return x and z of a chain's nodes for link directions phi [bending lengths], from u = U, shapes (LINKS + 1,)."""
    x = HALF_LENGTH + STEP * np.concatenate([[0.0], np.cumsum(np.cos(phi))])
    z = thickness / 2 + STEP * np.concatenate([[0.0], np.cumsum(np.sin(phi))])
    return x, z


def least_energy(thickness: float) -> np.ndarray:
    """Return the links' directions phi of minimum energy for a thickness in bending lengths, shape (LINKS,).

    Raises:
        TatamuError: If the minimisation did not converge.
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
    with threadpool_limits(1):  # the last bit of a product that threads share depends on their number
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
    """Return link directions to start from, shape (LINKS,): a flat strip that turns over a half circle."""
    turn = np.clip((np.arange(LINKS) + 0.5 - LINKS / 2) * STEP / GUESSED_WIDTH, -0.5, 0.5)
    return np.pi * (0.5 - turn)
