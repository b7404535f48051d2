"""Test *elongation* (paper, section IV-A): how much longer the garment is when it hangs than when it lies.

The simulated garment hangs from the same grips as the real one. L2 is measured on the unstrained mesh.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, ClassVar, Self

import numpy as np
from pydantic import Field, model_validator

from tatamu.base.curves import arc_lengths, length
from tatamu.base.errors import InputError
from tatamu.base.records import Record
from tatamu.calibration.readings import Length, Lengths, TestEntry
from tatamu.calibration.test import CLOTH, ElasticTest, Specimen
from tatamu.garments import Garment
from tatamu.show.drawing import Drawing
from tatamu.show.shapes import Segments
from tatamu.simulation.material import GRAVITY, Material, settling
from tatamu.simulation.mesh.topology import Topology, areas
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Cloth, Gripper, Scene

HUNG_BY = {"towel": ["bottom"], "tshirt": ["left_shoulder", "right_shoulder"], "trousers": ["waist"]}
"""Edges by which each of these garments hangs, by its name. Other garments hang by their longest edge."""


class Grasp(Record):
    """A straight grip on an edge of the garment."""

    edge: str
    """Name of the edge. `tatamu show GARMENT` draws the edges."""
    at: float = Field(0.5, ge=0.0, le=1.0)
    """Position of the middle of the grip along the edge, from 0 to 1."""
    width: Length | None = None
    """Width of the grip along the edge [m]; None for the whole edge, which a hanger or two rulers hold."""


class ElongationReadings(TestEntry):
    """Hanging and lying length of the garment (paper, section IV-A, Fig. 1)."""

    taken: ClassVar = {"L1": ("L1", "length"), "L2": ("L2", "length")}

    grasps: Annotated[list[Grasp], Field(min_length=1)]
    """Grips by which the garment hangs."""
    L1: Lengths
    """Distance from the grip straight down to the lowest end of the hanging garment [m]."""
    L2: Lengths
    """Distance from the grip to the same end when the garment lies flat [m]."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        hanging = float(np.mean(self.L1))
        lying = float(np.mean(self.L2))
        if lying > hanging:
            raise ValueError(
                f"L2 ({lying:g} m, lying) must be at most L1 ({hanging:g} m, hanging), because cloth stretches "
                "when it hangs; check that L1 and L2 are not swapped"
            )
        if hanging > 1.5 * lying:
            raise ValueError(
                f"L1 ({hanging:g} m) must be at most 1.5 times L2 ({lying:g} m); check that both are in metres "
                "and measured to the same point of the cloth"
            )
        return self


@dataclass(frozen=True)
class Elongation(ElasticTest):
    """The test of how much longer a garment is when it hangs than when it lies."""

    garment: Garment
    grasps: Sequence[Grasp]

    name = "elongation"
    parameter = "stretch_stiffness"
    entry = ElongationReadings
    reads: ClassVar = {"L1": 1.0, "L2": -1.0}
    size = "length"

    @classmethod
    def of(cls, entry: ElongationReadings, specimen: Specimen) -> Self:
        test = cls(specimen.garment, tuple(entry.grasps))
        lying = float(np.mean(entry.L2))
        if abs(lying / test.length - 1.0) > 0.25:
            raise InputError(
                f"elongation: L2 ({lying:g} m) must be within 25 % of {test.length:.2f} m, the length of the garment "
                "from the grasps to the farthest end; check `size` and `grasps`"
            )
        return test

    @classmethod
    def blanks(cls, garment: Garment) -> dict[str, str]:
        edges = HUNG_BY.get(garment.name) or [longest_edge(garment)]
        return {"grasps": ", ".join(f'{{edge = "{each}"}}' for each in edges)}

    @cached_property
    def held(self) -> list[np.ndarray]:
        """Indices of the vertices that each grip holds."""
        held = [held_vertices(self.garment, grasp) for grasp in self.grasps]
        if len(np.unique(np.concatenate(held))) < sum(map(len, held)):
            raise InputError("elongation.grasps: must not overlap; move the grasps apart, or give a single wider grasp")
        return held

    @cached_property
    def plan(self) -> np.ndarray:
        """Positions of the unstrained garment [m], shape (n, 2): to the side along the grips, and down from them."""
        flat = self.garment.cloth().rest[:, :2]
        gripped = flat[np.concatenate(self.held)]
        grip = 0.5 * (gripped.min(axis=0) + gripped.max(axis=0))
        weight = areas(self.garment.cloth().rest, self.garment.faces)
        middle = weight @ flat[self.garment.faces].mean(axis=1) / weight.sum()
        down = (middle - grip) / np.linalg.norm(middle - grip)
        return (flat - grip) @ np.column_stack([[-down[1], down[0]], down])

    @cached_property
    def end(self) -> np.ndarray:
        """Vertices of the end that is farthest below the grips."""
        below = self.plan[:, 1]
        return np.flatnonzero(below > below.max() - 2e-3)

    @property
    def length(self) -> float:
        """Length L2 from the grip to the end of the unstrained garment [m]."""
        return float(self.plan[self.end, 1].mean())

    def guess(self, elongation: float, material: Material) -> float:
        return material.areal_density * GRAVITY * self.length**2 / (2.0 * elongation)

    def scene(self, material: Material) -> Scene:
        apart = 2.0 * self.garment.vertices[:, 2]  # contact would push closer layers apart in the grip
        cloth = self.garment.cloth()
        start = np.column_stack([apart, self.plan[:, 0], -self.plan[:, 1]])
        hung = cloth.model_copy(update={"vertices": start, "rest_vertices": cloth.rest})
        return hanging_scene(hung, self.held, self.length, material)

    def reading(self, rollout: Rollout, frame: int = -1) -> float:
        return float(-rollout.positions[frame, self.end, 2].mean()) - self.length

    def straight(self, reading: float) -> float:
        return float(np.log(max(reading, 1e-9)))

    def drawing(self, shape: np.ndarray) -> str:
        hung = shape[:, 1:]
        wide, tall = np.ptp(self.plan, axis=0)
        lying = self.plan * [1.0, -1.0] + [1.45 * wide, 0.0]
        room = lying.max(axis=0) + np.array([0.25 * (1.45 * wide), 0.06 * tall])
        drawing = Drawing.around(np.concatenate([hung, lying, room[None]]), 340.0, 260.0)
        edges = Topology(self.garment.faces).edges
        for view in (hung, lying):
            drawing.add(Segments(view[edges], CLOTH, 0.5, opacity=0.6))
        for held in self.held:
            grip = hung[held]
            drawing.line(grip[[grip[:, 0].argmin(), grip[:, 0].argmax()]], "muted", 7.0)
        for view, end, name in ((hung, hung[self.end, 1].mean(), "L1"), (lying, -self.length, "L2")):
            right = view[:, 0].max() + 0.04 * (1.45 * wide)
            drawing.dimension((right, 0.0), (right, end), name)
        for view, words in ((hung, "hanging"), (lying, "lying")):
            drawing.label((view[:, 0].mean(), hung[:, 1].max() + 0.01 * tall), words, "muted", (0.0, 1.0))
        return drawing.svg()


def hanging_scene(cloth: Cloth, grips: Sequence[np.ndarray], length: float, material: Material) -> Scene:
    """Return a scene in which cloth of a length [m] hangs from the vertices of grips until it is at rest."""
    rate = 2.0 * float(np.sqrt(GRAVITY / length))
    return Scene(
        cloth=cloth,
        material=settling(material, rate),
        grippers=[Gripper(vertices=each.tolist(), times=[0.0], displacements=np.zeros((1, 3))) for each in grips],
        duration=14.0 / rate,  # until the slowest motion has died out
        frame_rate=30.0,
    )


def held_vertices(garment: Garment, grasp: Grasp) -> np.ndarray:
    """Return the indices of the vertices that a grip holds, in all layers of the garment.

    Raises:
        InputError: If the garment has no such edge.
    """
    path = named_edge(garment, grasp.edge)
    flat = garment.vertices[:, :2]
    arc = arc_lengths(flat[path])
    if grasp.width is not None:
        away = np.abs(arc - grasp.at * arc[-1])
        path = path[away <= max(grasp.width / 2 + 1e-9, np.sort(away)[1])]
    near = np.linalg.norm(flat[:, None] - flat[path], axis=2).min(axis=1)
    return np.flatnonzero(near < 0.25 * garment.spacing)


def named_edge(garment: Garment, name: str) -> np.ndarray:
    """Return the indices of the vertices along a named edge of the garment, in order.

    Raises:
        InputError: If the garment has no such edge.
    """
    if name not in garment.edges:
        raise InputError(f"edge: must be one of {', '.join(garment.edges)}, given {name!r}")
    return garment.edges[name]


def longest_edge(garment: Garment) -> str:
    """Return the name of the longest edge at an opening of the garment, such as a hem.

    If no edge is at an opening, return the name of the longest edge.

    Raises:
        InputError: If the garment has no named edges.
    """
    names = [name for name in garment.edges if name in garment.openings] or list(garment.edges)
    if not names:
        raise InputError(f"garment: must have a named edge by which the cloth can hang, but {garment.name} has none")
    return max(names, key=lambda name: length(garment.vertices[garment.edges[name]]))
