"""Elongation (paper, section IV-A): how much longer the garment is hanging than lying.

The simulated garment hangs from the same grasps. L1 is read straight down from the grip to the end farthest from it,
L2 is the same distance on the unstrained garment: simulated cloth has no memory, so that it lies unstrained.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tatamu.calibration.measurements import Grasp
from tatamu.calibration.settling import settling
from tatamu.errors import InputError
from tatamu.garments import Garment
from tatamu.material import GRAVITY, Material
from tatamu.rollout import Rollout
from tatamu.scene import Cloth, Gripper, Scene
from tatamu.topology import areas

RELAXATIONS = 14.0
"""The scene lasts so many times 1 / rate of its slowest motion: what is left of it is e^-14."""
LAYERS_APART = 2.0
"""Layers hang so many thicknesses apart at first: where a grip holds them as near as contact allows, contact and grip
would push against each other for ever."""
SAME_END = 2e-3
"""Vertices less than this nearer to the end than the farthest belong to it [m]."""


@dataclass(frozen=True)
class Elongation:
    """The hanging test of one garment."""

    garment: Garment
    grasps: Sequence[Grasp]
    name: str = "elongation"

    @cached_property
    def held(self) -> list[np.ndarray]:
        """Vertices in each grip."""
        held = [held_vertices(self.garment, grasp) for grasp in self.grasps]
        if len(np.unique(np.concatenate(held))) < sum(map(len, held)):
            raise InputError("elongation.grasps: two of them hold the same cloth; give each its own place or one wider")
        return held

    @cached_property
    def plan(self) -> np.ndarray:
        """The garment upright, in its own plane: across and below the grips [m], shape (n, 2)."""
        flat = self.garment.cloth().rest[:, :2]
        gripped = flat[np.concatenate(self.held)]
        grip = 0.5 * (gripped.min(axis=0) + gripped.max(axis=0))
        weight = areas(self.garment.cloth().rest, self.garment.faces)
        middle = weight @ flat[self.garment.faces].mean(axis=1) / weight.sum()
        down = (middle - grip) / np.linalg.norm(middle - grip)
        return (flat - grip) @ np.column_stack([[-down[1], down[0]], down])

    @cached_property
    def end(self) -> np.ndarray:
        """Vertices of the end farthest below the grips."""
        below = self.plan[:, 1]
        return np.flatnonzero(below > below.max() - SAME_END)

    @property
    def length(self) -> float:
        """L2: from the grip to the end, unstrained [m]."""
        return float(self.plan[self.end, 1].mean())

    def guess(self, elongation: float, density: float) -> float:
        """Stretch stiffness of a strip that hangs so much longer, rho g L^2 / 2 e [N/m]."""
        return density * GRAVITY * self.length**2 / (2.0 * elongation)

    def scene(self, material: Material) -> Scene:
        """The garment starts unstrained in a vertical plane and settles."""
        rate = 2.0 * float(np.sqrt(GRAVITY / self.length))
        apart = LAYERS_APART * self.garment.vertices[:, 2]
        cloth = self.garment.cloth()
        start = np.column_stack([apart, self.plan[:, 0], -self.plan[:, 1]])
        grippers = [Gripper(vertices=each.tolist(), times=[0.0], displacements=np.zeros((1, 3))) for each in self.held]
        return Scene(
            cloth=Cloth(vertices=start, faces=cloth.faces, rest_vertices=cloth.rest, seams=cloth.seams),
            material=settling(material, rate),
            grippers=grippers,
            duration=RELAXATIONS / rate,
            frame_rate=30.0,
        )

    def reading(self, rollout: Rollout, frame: int = -1) -> float:
        """L1 - L2 of a rollout [m]."""
        return float(-rollout.positions[frame, self.end, 2].mean()) - self.length


def held_vertices(garment: Garment, grasp: Grasp) -> np.ndarray:
    """Vertices of all layers in a grip.

    Raises:
        InputError: The garment has no such edge.
    """
    path = named_edge(garment, grasp.edge)
    flat = garment.vertices[:, :2]
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(flat[path], axis=0), axis=1))])
    if grasp.width is not None:
        away = np.abs(arc - grasp.at * arc[-1])
        path = path[away <= max(grasp.width / 2 + 1e-9, np.sort(away)[1])]
    near = np.linalg.norm(flat[:, None] - flat[path], axis=2).min(axis=1)
    return np.flatnonzero(near < 0.25 * garment.spacing)


def named_edge(garment: Garment, name: str) -> np.ndarray:
    """The path of vertices along an edge of the garment.

    Raises:
        InputError: The garment has no such edge.
    """
    if name not in garment.edges:
        raise InputError(f"edge: {garment.name} has {', '.join(garment.edges)}, given {name!r}")
    return garment.edges[name]
