"""Shapes of a heavy strip: inextensible cloth in a vertical plane, bent only by its own weight.

Let B be the bending rigidity [N m], w = rho g the weight per area [N/m^2], s the arc length, theta the slope and z the
height. The shape has the minimum energy per width, so it depends only on lengths in units of the bending length
l_b = (B / w)^(1/3) (Peirce 1930):

    E = int  B/2 (d theta/ds)^2 + w z  ds

The *cantilever* is clamped at one end. Its slope theta is measured downwards. From the clamp, x is the horizontal reach
and y the vertical drop:

    B theta'' = -w (L - s) cos(theta),  theta(0) = 0,  theta'(L) = 0,  x' = cos(theta),  y' = sin(theta)
    Gamma = w L^3 / B = (L / l_b)^3

Gamma is raised step by step, because a solver finds wrong solutions above about 100 without a good initial guess.

The *crease* is the loop at a fold that lies on the table. The arc length u goes from U, flat on the table, to -U,
exactly above it and one thickness t higher. With the direction phi and the height z, an inextensible chain of links
minimises, below (u > 0) and above (u < 0),

    E / b = int  B/2 (d phi/du)^2 + rho g z  du,     z >= t/2 below, z >= 3t/2 above.

In units of l_b, the shape depends only on t / l_b; limp cloth with l_b of about t makes nearly a circle. A stack of
layers that slide on each other has the bending length of one layer and the thickness of the whole stack.
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
"""Half of the arc length, U [bending lengths], longer than the loop, so that both ends of the strip are flat."""
STEP = 2 * HALF_LENGTH / LINKS
"""Length of a link [bending lengths]."""
AFTER = np.tril(np.ones((LINKS + 1, LINKS)), -1)
"""1 where a node (row) comes after a link (column), and so moves if it turns; otherwise 0."""


def _solve(gamma: float, s: np.ndarray, guess: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    from scipy.integrate import solve_bvp  # slow to import, and folds need only the crease

    def slope(s: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.vstack([y[1], -gamma * (1 - s) * np.cos(y[0]), np.cos(y[0]), np.sin(y[0])])

    def ends(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.array([a[0], b[1], a[2], a[3]])

    found = solve_bvp(slope, ends, s, guess, tol=1e-8, max_nodes=20000)
    if not found.success:
        raise TatamuError(f"heavy elastica, Gamma {gamma:g}: {found.message}")
    return found.x, found.y


@lru_cache(maxsize=256)
def _continued(gamma: float) -> tuple[np.ndarray, np.ndarray]:
    """Return arc lengths and theta, theta', x and y at each of them in units of L, from a smaller Gamma."""
    least, steps_per_decade = 0.01, 30
    if gamma <= least:
        s = np.linspace(0, 1, 201)
        return _solve(gamma, s, np.vstack([0 * s, 0 * s, s, 0 * s]))
    rung = np.ceil(np.log10(gamma / least) * steps_per_decade - 1e-9) - 1
    return _solve(gamma, *_continued(float(least * 10 ** (rung / steps_per_decade))))


def cantilever(gamma: float, count: int = 201) -> np.ndarray:
    """Return the reach x / L and the drop y / L at equal steps of arc length, shape (count, 2)."""
    s, y = _continued(float(gamma))
    arc = np.linspace(0, 1, count)
    return np.column_stack([np.interp(arc, s, y[2]), np.interp(arc, s, y[3])])


def tip(gamma: float) -> tuple[float, float, float]:
    """Return the reach x / L and the drop y / L of the tip, and its slope below the horizontal [rad]."""
    _, y = _continued(float(gamma))
    return float(y[2, -1]), float(y[3, -1]), float(y[0, -1])


def slowest_frequency(gamma: float, length: float, gravity: float) -> float:
    """Estimate the lowest angular frequency of a hanging cantilever [rad/s].

    It is the larger one of a clamped beam, 3.52 sqrt(B / (rho L^4)), and of a hanging chain, 1.2 sqrt(g / L).
    """
    return float(max(3.52 / np.sqrt(gamma), 1.2) * np.sqrt(gravity / length))


def chord(gamma: float) -> float:
    """Return the angle between the horizontal and the line from the clamp to the tip [rad]."""
    reach, drop, _ = tip(gamma)
    return float(np.arctan2(drop, reach))


@dataclass(frozen=True)
class Crease:
    """The profile of folded cloth near the fold, in the vertical plane across the fold line."""

    arc: np.ndarray
    """Signed distances u from the fold line on the flat cloth [m], increasing, shape (k,); the side u > 0 stays."""
    x: np.ndarray
    """Distances from the fold line after the fold, towards the side that stays [m], shape (k,)."""
    z: np.ndarray
    """Heights of the cloth's mid-surface above the table [m], shape (k,)."""

    def place(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return x and z at arc lengths u [m]; outside the profile, the two layers lie flat on each other."""
        inside = np.abs(u) <= self.arc[-1]
        x = np.where(inside, np.interp(u, self.arc, self.x), np.abs(u))
        z = np.where(inside, np.interp(u, self.arc, self.z), np.where(u > 0, self.z[-1], self.z[0]))
        return x, z

    def normals(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return x and z of unit vectors across the strip at arc lengths u, which point into the loop."""
        along_x = np.gradient(self.x, self.arc)
        along_z = np.gradient(self.z, self.arc)
        inside = np.abs(u) <= self.arc[-1]
        x = np.where(inside, -np.interp(u, self.arc, along_z), 0.0)
        z = np.where(inside, np.interp(u, self.arc, along_x), np.sign(u))
        size = np.maximum(np.hypot(x, z), 1e-9)
        return x / size, z / size


def crease(bending_length: float, thickness: float) -> Crease:
    """Return the crease for a bending length [m] and a thickness [m], or raise TatamuError if none is found."""
    length = max(bending_length, 0.75 * thickness)  # cloth that is limper is computed like this
    arc, x, z = _profile(round(thickness / length, 6))
    return Crease(arc * length, x * length, z * length)


@lru_cache(maxsize=32)
def _profile(thickness: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the arc lengths, x and z of a crease. All lengths are in bending lengths."""
    phi = least_energy(thickness)
    x, z = nodes(phi, thickness)
    arc = HALF_LENGTH - STEP * np.arange(LINKS + 1)
    return arc[::-1], x[::-1], z[::-1]


def nodes(phi: np.ndarray, thickness: float) -> tuple[np.ndarray, np.ndarray]:
    """Return x and z of the LINKS + 1 nodes [bending lengths], from u = U on, for link directions phi [rad]."""
    x = HALF_LENGTH + STEP * np.concatenate([[0.0], np.cumsum(np.cos(phi))])
    z = thickness / 2 + STEP * np.concatenate([[0.0], np.cumsum(np.sin(phi))])
    return x, z


def least_energy(thickness: float) -> np.ndarray:
    """Return the link directions phi of minimum energy [rad], shape (LINKS,), for a thickness in bending lengths."""

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
        {"type": "eq", "fun": miss, "jac": lambda phi: STEP * np.stack([-np.sin(phi), np.cos(phi)])},
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
            options={"maxiter": 300, "ftol": 1e-8},  # about 75 iterations are enough for any cloth
        )
    if not result.success:
        raise TatamuError(
            f"crease: no shape of minimum energy was found for cloth whose thickness is {thickness:g} bending lengths: "
            f"{result.message}"
        )
    return np.asarray(result.x)


def guess() -> np.ndarray:
    """Return link directions to start from [rad], shape (LINKS,): a flat strip, bent over in a half circle."""
    bent = 1.4  # arc length of the half circle [bending lengths]
    turn = np.clip((np.arange(LINKS) + 0.5 - LINKS / 2) * STEP / bent, -0.5, 0.5)
    return np.pi * (0.5 - turn)
