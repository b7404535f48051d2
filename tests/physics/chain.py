"""Computes the loop of a folded strip, modelled as a chain of links. Validation compares simulations with this loop.

The chain has n rigid links of length h and slopes theta_i. Its energy, with the bending rigidity B and the weight per
area w, is:

    E = sum B / (2 h) (theta_i+1 - theta_i)^2 + sum w h z_i,   x, z the sums of h cos(theta), h sin(theta)

The constraints are:

- Both ends are clamped: theta is 0 at the lower end and pi at the upper end.
- The last node is fixed at (0, z_lower + rise).
- The lower half is not below the table.
- The upper half is at least one thickness above the lower half.

There is no friction. The chain starts as a wide loop. Newton's method finds the minimum of the energy, with augmented
Lagrangians for the constraints. A boundary-value solver is not used, because such a solver finds a wrong solution, in
which the loop measures only 2 mm.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from tatamu.base.errors import TatamuError

PENALTIES = (1e2, 1e3, 1e4, 1e4, 1e4, 1e4)
"""Stiffness of the penalty for violated constraints, in units of the weight per area w. The minimisation runs once with
each of these values, in this order."""
AT_REST = 1e-5
"""Largest moment on a link at rest, in units of w l_b^2: weight per area times the square of the bending length."""
MET = 1e-4
"""Largest violation at which a constraint counts as met, in bending lengths."""


@dataclass(frozen=True)
class FoldedStrip:
    """A strip on a table that is folded over itself once."""

    length: float
    """Arc length of the whole strip [m]."""
    bending_length: float
    """Bending length l_b = (B / w)^(1/3) [m], with the bending rigidity B and the weight per area w."""
    thickness: float
    """Distance between the layers at rest [m]."""
    rise: float
    """Height of the upper clamp above the lower clamp [m]."""

    def solve(self, links: int = 200) -> np.ndarray:
        """Return the nodes of the chain at rest, shape (links + 1, 2).

        Each row has x and the height z above the table [m]. The loop points towards +x.

        Raises:
            TatamuError: If the chain did not come to rest, or violates a constraint.
        """
        energy = ChainEnergy(self, links)
        theta = energy.start()
        for stiffness in PENALTIES:
            energy.stiffness = stiffness
            found = minimize(
                energy.value,
                theta,
                jac=energy.slope,
                hessp=energy.curved,
                method="trust-krylov",
                options={"gtol": 1e-7, "maxiter": 400},
            )
            theta = found.x
            energy.update(theta)
        # Because of rounding, the minimiser may report a failure although its result is good. So the result is checked.
        if not (np.abs(found.jac).max() < AT_REST and energy.violation(theta) < MET):
            raise TatamuError(f"chain of {links} links: no equilibrium of {self} found: {found.message}")
        return energy.nodes(theta)


def start(length: float, bending_length: float, thickness: float, links: int = 200) -> np.ndarray:
    """Return the nodes of a wide loop from which the minimisation can start [m], shape (links + 1, 2).

    The loop is a half circle between two level parts.
    """
    chain = ChainEnergy(FoldedStrip(length, bending_length, thickness, 0.0), links)
    return chain.nodes(chain.start())


class ChainEnergy:
    """The energy of the chain with penalties for violated constraints (augmented Lagrangian).

    The energy is a function of the links' slopes. Lengths are in units of the bending length l_b. Energies per width
    are in units of w l_b^2, with the weight per area w.
    """

    def __init__(self, strip: FoldedStrip, links: int) -> None:
        """Make the chain of a strip with `links` links. All multipliers of constraints are zero at first."""
        self.strip = strip
        self.links = links
        self.h = strip.length / strip.bending_length / links
        self.floor = np.where(np.arange(1, links + 1) <= links // 2, 0.0, strip.thickness) / strip.bending_length
        self.rise = strip.rise / strip.bending_length
        self.stiffness = PENALTIES[0]
        self.push = np.zeros(links)  # multipliers of contact, for each node except the first
        self.pull = np.zeros(2)  # multipliers of the upper end's position

    def start(self) -> np.ndarray:
        """Return the slopes of the links at the start of the minimisation [rad], shape (links,).

        The chain is then a half circle between two straight parts. The radius is about one bending length.
        """
        arc = (np.arange(self.links) + 0.5) * self.h
        total = self.links * self.h
        radius = min(1.0, 0.2 * total)
        return np.clip((arc - (total - np.pi * radius) / 2) / radius, 0.0, np.pi)

    def _points(self, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.cumsum(self.h * np.cos(theta)), np.cumsum(self.h * np.sin(theta))

    def nodes(self, theta: np.ndarray) -> np.ndarray:
        """Return the nodes of the chain for the slopes `theta` of the links [m], shape (links + 1, 2)."""
        x, z = self._points(theta)
        points = np.vstack([[0.0, 0.0], np.column_stack([x, z])]) * self.strip.bending_length
        return points + np.array([0.0, self.strip.thickness / 2])

    def _turns(self, theta: np.ndarray) -> np.ndarray:
        """Return the angle between the neighbouring links at every node, including the clamps, shape (links + 1,).

        At a clamp, only half a link bends. For the same angle, the moment at a clamp is therefore twice as large.
        """
        return np.diff(np.concatenate([[0.0], theta, [np.pi]]))

    @property
    def _weights(self) -> np.ndarray:
        return np.concatenate([[2.0], np.ones(self.links - 1), [2.0]]) / self.h

    def _forces(self, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the derivatives of the energy with respect to x and z of every node except the first.

        The third result is a mask of the nodes on which a contact presses.
        """
        x, z = self._points(theta)
        press = np.maximum(0.0, self.push - self.stiffness * (z - self.floor))
        fz = np.full(self.links, self.h) - press
        fx = np.zeros(self.links)
        fz[-1] += press[-1] - 0.5 * self.h + self.pull[1] + self.stiffness * (z[-1] - self.rise)
        fx[-1] = self.pull[0] + self.stiffness * x[-1]
        return fx, fz, press > 0

    def value(self, theta: np.ndarray) -> float:
        """Return the energy with penalties (augmented Lagrangian) for the slopes `theta`."""
        x, z = self._points(theta)
        turn = 0.5 * float(self._weights @ self._turns(theta) ** 2)
        weight = self.h * (z.sum() - 0.5 * z[-1])
        press = np.maximum(0.0, self.push - self.stiffness * (z - self.floor))[:-1]
        miss = np.array([x[-1], z[-1] - self.rise])
        held = self.pull @ miss + 0.5 * self.stiffness * miss @ miss
        return float(turn + weight + (press @ press - self.push[:-1] @ self.push[:-1]) / (2 * self.stiffness) + held)

    def slope(self, theta: np.ndarray) -> np.ndarray:
        """Return the gradient of the energy with penalties (augmented Lagrangian), shape (links,)."""
        fx, fz, _ = self._forces(theta)
        sx, sz = (np.cumsum(f[::-1])[::-1] for f in (fx, fz))
        moment = -np.diff(self._weights * self._turns(theta))
        return moment + self.h * (sz * np.cos(theta) - sx * np.sin(theta))

    def curved(self, theta: np.ndarray, p: np.ndarray) -> np.ndarray:
        """Return the product of the augmented Lagrangian's Hessian and a direction p, shape (links,).

        The product is computed without storing the Hessian matrix.
        """
        fx, fz, pressed = self._forces(theta)
        sx, sz = (np.cumsum(f[::-1])[::-1] for f in (fx, fz))
        cosine = self.h * np.cos(theta)
        sine = self.h * np.sin(theta)
        weights = self._weights
        stiff = self.stiffness * pressed
        stiff[-1] = self.stiffness
        out = (weights[:-1] + weights[1:] - sz * sine - sx * cosine) * p
        out[:-1] -= weights[1:-1] * p[1:]
        out[1:] -= weights[1:-1] * p[:-1]
        out += cosine * np.cumsum((stiff * np.cumsum(cosine * p))[::-1])[::-1]
        return np.asarray(out + self.stiffness * sine * (sine @ p))

    def violation(self, theta: np.ndarray) -> float:
        """Return the largest violation of a constraint, in bending lengths."""
        x, z = self._points(theta)
        return float(max(abs(x[-1]), abs(z[-1] - self.rise), (self.floor - z)[:-1].max()))

    def update(self, theta: np.ndarray) -> None:
        """Change the multiplier of each constraint according to the constraint's violation."""
        x, z = self._points(theta)
        self.push = np.maximum(0.0, self.push - self.stiffness * (z - self.floor))
        self.push[-1] = 0.0
        self.pull = self.pull + self.stiffness * np.array([x[-1], z[-1] - self.rise])
