"""Random folds of a towel: two hands grasp one end and carry it over the other end along Bezier curves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tatamu.base.curves import bezier
from tatamu.simulation.material import Material
from tatamu.simulation.scene import Gripper, Scene, Table
from tests.physics.meshes import staggered
from tests.physics.scenes import flat

LENGTH, WIDTH = 0.28, 0.20
"""Length and width of the towel [m]. With this size, a mesh with a spacing of 10 mm has twice as many rows as a mesh
with 20 mm. Hands then hold the same part of the towel on both meshes."""
PATCH = 0.025
"""Side of the square corner that a hand holds [m]."""
EDGE = 1e-9
"""Depth of the held cloth, measured from the edge of the towel, if a hand holds only the edge [m]."""
KNOTS = 41
REST = 0.6
"""Time from the release to the end of the scene [s]."""


@dataclass(frozen=True)
class RandomFold:
    """A random fold of a towel by two hands that move along Bezier curves."""

    control: np.ndarray
    """Control points P1, P2 and P3 of each hand's Bezier curve, relative to its start P0 [m], shape (2, 3, 3)."""
    seconds: float
    """Time for which the hands move [s]."""

    @classmethod
    def random(cls, seed: int, fast: bool) -> RandomFold:
        """Return a random fold that ends near the other end of the towel.

        The paths of the hands may differ, but the hands never pull the cloth apart.
        """
        random = np.random.default_rng(seed)
        points = np.zeros((2, 3, 3))
        points[:, 2, 0] = LENGTH * random.uniform(0.75, 1.0)
        points[:, 0, 0] = LENGTH * random.uniform(-0.1, 0.5)
        points[:, 1, 0] = LENGTH * random.uniform(0.4, 1.0)
        points[:, :2, 2] = LENGTH * random.uniform(0.15, 0.9, 2)
        points[:, :, ::2] += random.uniform(-0.01, 0.01, (2, 3, 2))
        points[:, :, 1] += random.uniform(0.0, 0.02, (2, 3)) * [[-1], [1]]
        points[:, 2, 2] = random.uniform(0.003, 0.02)
        return cls(points, float(random.uniform(0.5, 0.9) if fast else random.uniform(1.8, 3.0)))

    def paths(self) -> np.ndarray:
        """Return displacements of each hand at evenly spaced times, smooth at both ends, shape (2, KNOTS, 3) [m]."""
        u = np.linspace(0, 1, KNOTS)
        return np.array([bezier(np.vstack([np.zeros(3), points]), u * u * (3 - 2 * u)) for points in self.control])


def scene_of(manipulation: RandomFold, material: Material, spacing: float, depth: float = PATCH) -> Scene:
    """Return the scene of a random fold of a towel on a mesh with this spacing [m].

    Each hand holds a corner at one end of the towel: the cloth within `depth` metres of the edge. The hands carry the
    corners over the towel and let go.
    """
    mesh = staggered(LENGTH, WIDTH, spacing)
    plan = mesh[0]
    times = (np.linspace(0, 1, KNOTS) * manipulation.seconds).tolist()
    near = plan[:, 0] < depth
    corners = (near & (plan[:, 1] > WIDTH - PATCH), near & (plan[:, 1] < PATCH))
    grippers = [
        Gripper(
            vertices=np.flatnonzero(corner).tolist(), opens=manipulation.seconds + 0.1, times=times, displacements=path
        )
        for corner, path in zip(corners, manipulation.paths(), strict=True)
    ]
    return Scene(
        cloth=flat(mesh, material.thickness / 2),
        material=material,
        table=Table(),
        grippers=grippers,
        duration=manipulation.seconds + 0.1 + REST,
    )


def half_fold_target(plan: np.ndarray, thickness: float) -> np.ndarray:
    """Return the vertices of a towel folded over its middle, with the held end on top [m], shape (n, 3)."""
    over = plan[:, 0] < LENGTH / 2
    return np.column_stack(
        [np.where(over, LENGTH - plan[:, 0], plan[:, 0]), plan[:, 1], np.where(over, 1.5, 0.5) * thickness]
    )
