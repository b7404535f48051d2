"""Computes the bending of a strip with friction of bending, in one dimension.

The module computes the moment of the strip as a function of its curvature. It also computes the shape of a heavy strip
whose clamp turns.

The friction of bending consists of a few elements side by side. Each element is a spring that slips above a yield
curvature (`Material.friction_elements`). The strip is a chain of rigid links with a moment at every joint.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import solveh_banded
from scipy.optimize import brentq

from tatamu.base.errors import SimulationError
from tatamu.simulation.material import Material

LINKS = 400
STEPS = 60
"""Number of steps in which the clamp of the strip turns from one angle to the next."""


class BentSection:
    """The bending moments of several sections of a strip. The moments depend on how the sections were bent before."""

    def __init__(self, material: Material, count: int) -> None:
        """Start with flat sections.

        Args:
            material: Material of the strip.
            count: Number of sections.
        """
        self._rigidity = material.bending_rigidity
        self._elements = material.friction_elements
        self._plastic = np.zeros((len(self._elements), count))

    def moment(self, curvature: np.ndarray) -> np.ndarray:
        """Return the moment per width of each of k sections of the strip [N], shape (k,), after they are bent.

        The curvatures change from the stored ones to `curvature` [1/m], shape (k,).
        """
        moment = self._rigidity * curvature
        for (stiffness, limit), plastic in zip(self._elements, self._plastic, strict=True):
            moment = moment + stiffness * np.clip(curvature - plastic, -limit, limit)
        return moment

    def work(self, curvature: np.ndarray) -> np.ndarray:
        """Return the work of bending per area of each of k sections of the strip [J/m^2], shape (k,).

        The work is the integral of `moment` over the curvature.
        """
        work = 0.5 * self._rigidity * curvature**2
        for (stiffness, limit), plastic in zip(self._elements, self._plastic, strict=True):
            bent = np.abs(curvature - plastic)
            work = work + stiffness * np.where(bent < limit, 0.5 * bent**2, limit * (bent - 0.5 * limit))
        return work

    def slope(self, curvature: np.ndarray) -> np.ndarray:
        """Return the derivative of `moment` with respect to the curvature of each section [N m], shape (k,)."""
        slope = np.full(len(curvature), self._rigidity)
        for (stiffness, limit), plastic in zip(self._elements, self._plastic, strict=True):
            slope = slope + stiffness * (np.abs(curvature - plastic) < limit)
        return slope

    def keep(self, curvature: np.ndarray) -> None:
        """Store these curvatures [1/m], shape (k,), as the present curvatures of the k sections."""
        for (_, limit), plastic in zip(self._elements, self._plastic, strict=True):
            plastic[:] = curvature - np.clip(curvature - plastic, -limit, limit)


def loop(material: Material, curvatures: Sequence[float]) -> np.ndarray:
    """Return the moment per width [N] of a strip at each of k successive curvatures [1/m], shape (k,).

    The strip starts flat.
    """
    section = BentSection(material, 1)
    moments = []
    for curvature in curvatures:
        at = np.array([curvature])
        moments.append(float(section.moment(at)[0]))
        section.keep(at)
    return np.array(moments)


def residual_curvature(material: Material, curvature: float) -> float:
    """Return the curvature that remains after a flat strip was bent to `curvature` and released [1/m]."""
    section = BentSection(material, 1)
    section.keep(np.array([curvature]))
    return float(brentq(lambda k: float(section.moment(np.array([k]))[0]), 0.0, curvature, xtol=1e-12))


def turned_strip(material: Material, length: float, clamps: Sequence[float], gravity: float) -> list[np.ndarray]:
    """Return the shapes of a heavy strip whose clamp turns slowly.

    Args:
        material: Material of the strip.
        length: Length of the strip [m].
        clamps: Successive angles of the clamp below the horizontal [rad]. The clamp starts at a right angle, so the
            strip hangs straight.
        gravity: Acceleration of gravity [m/s^2].

    Returns:
        The shape of the strip at each angle of the clamp: the horizontal and the vertical distance of each node from
        the clamp (reach and drop) [m], shape (LINKS + 1, 2).

    Raises:
        SimulationError: If a shape cannot be found.
    """
    link = length / LINKS
    lengths = np.full(LINKS, link)
    lengths[0] = link / 2  # the joint at the clamp belongs to half a link
    joints = BentSection(material, LINKS)
    torque = material.areal_density * gravity * link * (length - link * (np.arange(LINKS) + 0.5))
    angles = np.full(LINKS, np.pi / 2)
    before = np.pi / 2
    shapes = []
    for clamp in clamps:
        for turned in np.linspace(before, clamp, STEPS + 1)[1:]:
            angles = _equilibrium(joints, lengths, torque, angles, turned)
            joints.keep(np.diff(angles, prepend=turned) / lengths)
        before = clamp
        points = np.cumsum(link * np.column_stack([np.cos(angles), np.sin(angles)]), axis=0)
        shapes.append(np.vstack([[0.0, 0.0], points]))
    return shapes


def _equilibrium(
    joints: BentSection, lengths: np.ndarray, torque: np.ndarray, angles: np.ndarray, clamp: float
) -> np.ndarray:
    """Return the angles of a strip's links below the horizontal [rad] in equilibrium.

    The equilibrium is the minimum of the energy of bending and weight. Newton's method finds the minimum.
    """

    def energy(angles: np.ndarray) -> float:
        return float(joints.work(np.diff(angles, prepend=clamp) / lengths) @ lengths - torque @ np.sin(angles))

    for _ in range(500):
        curvature = np.diff(angles, prepend=clamp) / lengths
        moment = joints.moment(curvature)
        stiffness = joints.slope(curvature) / lengths
        out = moment - np.append(moment[1:], 0.0) - torque * np.cos(angles)
        if np.abs(out).max() < 1e-7 * torque[0]:
            return angles
        diagonal = stiffness + np.append(stiffness[1:], 0.0) + torque * np.maximum(np.sin(angles), 0.0)
        beside = np.append(0.0, -stiffness[1:])
        change = solveh_banded(np.vstack([beside, diagonal]), -out)
        part = 1.0
        least = energy(angles)
        enough = 1e-13 * abs(least)  # the rounding error of energies
        while energy(angles + part * change) > least + 1e-4 * part * float(out @ change) + enough and part > 1e-6:
            part *= 0.5
        angles = angles + part * change
    raise SimulationError("the frictional strip found no equilibrium")
