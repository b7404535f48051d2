"""A scene: the complete input of a simulator, in SI units and with z up (docs/reference/scene-and-rollout.md)."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from tatamu.base.arrays import MAX_COORDINATE, Edges, Triangles, edges
from tatamu.base.arrays import Index as Index
from tatamu.base.arrays import Points as Points
from tatamu.base.errors import InputError
from tatamu.base.files import read_json, validated, write_text
from tatamu.base.records import Record
from tatamu.simulation.body import Body, check_knots
from tatamu.simulation.clearance import deepest
from tatamu.simulation.material import GRAVITY, Material, Number
from tatamu.simulation.mesh.topology import check_mesh

MIN_IN_PLANE = 1e-3
"""Minimum part of a warp direction in the plane of its triangle [-]."""

MAX_VERTICES = 150_000
"""Maximum number of vertices, which take ten seconds to prepare; garments have about 2,000."""


def _check_fibre(rest: np.ndarray, faces: np.ndarray, fibre: np.ndarray) -> None:
    if len(fibre) not in (1, len(faces)):
        raise ValueError(f"fibre must be one vector, or one for each of {len(faces)} triangles, given {len(fibre)}")
    a, b, c = (rest[faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    within = np.linalg.norm(np.cross(normal, fibre), axis=1) / np.linalg.norm(normal, axis=1)
    if not (within > MIN_IN_PLANE * np.maximum(np.linalg.norm(fibre, axis=1), 1e-30)).all():
        wrong = int(np.argmin(within))
        raise ValueError(
            "fibre must not be zero or perpendicular to its triangle, given "
            f"{fibre[min(wrong, len(fibre) - 1)].tolist()} in triangle {wrong}"
        )


class Cloth(Record):
    """The cloth as a triangle mesh of its mid-surface."""

    vertices: Points
    """Positions at the start [m], shape (n, 3)."""
    faces: Triangles
    """Triangles, shape (m, 3)."""
    rest_vertices: Points | None = None
    """Positions in the unstrained shape [m], shape (n, 3); None for `vertices`."""
    seams: Edges = Field(default_factory=lambda: edges([]))
    """Edges that hinge freely, shape (s, 2)."""
    fibre: Points | None = None
    """Direction of the warp in the unstrained shape, shape (m, 3), or (1, 3) for all triangles, each of which uses the
    part in its plane. None stands for x, or for y in triangles perpendicular to x."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.rest_vertices is not None and self.rest_vertices.shape != self.vertices.shape:
            raise ValueError(
                f"rest_vertices must have one item for each of {len(self.vertices)} vertices, given "
                f"{len(self.rest_vertices)}"
            )
        if len(self.vertices) > MAX_VERTICES:
            raise ValueError(
                f"the cloth must have at most {MAX_VERTICES} vertices, given {len(self.vertices)}; give a larger "
                "spacing"
            )
        check_mesh(self.rest, self.faces, self.seams)
        if self.fibre is not None:
            _check_fibre(self.rest, self.faces, self.fibre)
        return self

    def __repr__(self) -> str:
        return f"<Cloth of {len(self.vertices)} vertices and {len(self.faces)} faces>"

    __str__ = __repr__

    @property
    def rest(self) -> np.ndarray:
        """Positions in the unstrained shape [m], shape (n, 3)."""
        return self.vertices if self.rest_vertices is None else self.rest_vertices


class Table(Record):
    """The plane of the table: z = height - x tan(tilt)."""

    height: Number = Field(0.0, ge=-MAX_COORDINATE, le=MAX_COORDINATE)
    """Height of the table's top at x = 0 [m]."""
    tilt: Number = Field(0.0, ge=-1.5533, le=1.5533)
    """Rotation about y [rad], at most 89 degrees. With a positive tilt, +x is downhill."""


class Gripper(Record):
    """Vertices that are held from `closes` to `opens`, keep their arrangement and follow `displacements`."""

    hand: Literal["left", "right"] | None = None
    """Hand to which the gripper belongs, or None. Of several grippers of a hand, the first moves like the hand."""
    vertices: Annotated[list[Index], Field(min_length=1)]
    """Indices of the held vertices."""
    closes: Number = Field(0.0, ge=0.0)
    """Time at which the gripper closes [s]."""
    opens: Number | None = None
    """Time at which the gripper opens [s]; None if it never opens."""
    times: Annotated[list[Number], Field(min_length=1)]
    """Times of the knots of the motion [s], increasing."""
    displacements: Points
    """Displacement at each knot from the position at closing [m], shape (k, 3); linear between knots, then constant."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        twice = next((one for one, other in pairwise(sorted(self.vertices)) if one == other), None)
        if twice is not None:
            raise ValueError(f"vertices must not contain an index twice, given {twice} twice")
        if self.opens is not None and not self.opens > self.closes:
            raise ValueError(f"`opens` ({self.opens:g} s) must be later than `closes` ({self.closes:g} s)")
        check_knots(self.times, displacements=self.displacements)
        return self

    def path(self, times: np.ndarray) -> np.ndarray:
        """Return the displacements at k times [s], in metres, shape (k, 3); zero before the first knot."""
        path = np.column_stack([np.interp(times, self.times, column) for column in self.displacements.T])
        path[times < self.times[0] - 1e-9] = 0.0  # sums of time steps have rounding errors
        return path

    def displacement(self, time: float) -> np.ndarray:
        """Return the displacement at a time [s] from the position at closing [m], shape (3,)."""
        return self.path(np.array([time]))[0]


class Scene(Record):
    """Cloth, material, table, hands, rigid bodies and time."""

    version: Literal[1] = 1
    cloth: Cloth
    material: Material
    table: Table | None = None
    grippers: Annotated[list[Gripper], Field(max_length=1000)] = Field(default_factory=list)
    """Grippers of the hands; a hand that pinches layers together has several."""
    bodies: Annotated[list[Body], Field(max_length=100)] = Field(default_factory=list)
    """Rigid bodies with which the cloth collides, at most 100, because each is compared with every triangle."""
    gravity: Number = Field(GRAVITY, ge=0.0, le=1e3)
    """Downward acceleration of gravity [m/s^2]."""
    duration: Number = Field(gt=0.0, le=3600.0)
    """Length of the rollout [s]."""
    frame_rate: Number = Field(60.0, gt=0.0, le=1e4)
    """Frames per second of the rollout [1/s]."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        count = len(self.cloth.vertices)
        for number, gripper in enumerate(self.grippers):
            if max(gripper.vertices) >= count:
                raise ValueError(
                    f"grippers.{number}.vertices must be vertex indices from 0 to {count - 1}, given "
                    f"{max(gripper.vertices)}"
                )
        self._check_held_once()
        for number, body in enumerate(self.bodies):
            depth = 0.5 * self.material.thickness + deepest(body, self.cloth.vertices, self.cloth.faces)
            if depth > self.material.thickness:
                raise ValueError(
                    f"bodies.{number} begins {depth:.3g} m deep in the cloth, more than the cloth's thickness "
                    f"({self.material.thickness:g} m); move the body or the cloth"
                )
        if self.frames > 200_000:
            raise ValueError(f"duration x frame_rate must not exceed 200000 frames, given {self.frames}")
        return self

    def __repr__(self) -> str:
        return (
            f"<Scene of {len(self.cloth.vertices)} vertices: grippers {len(self.grippers)}, bodies {len(self.bodies)}, "
            f"{self.duration:g} s>"
        )

    __str__ = __repr__

    def _check_held_once(self) -> None:
        holders: dict[int, list[tuple[float, float, int]]] = {}
        for number, gripper in enumerate(self.grippers):
            end = np.inf if gripper.opens is None else gripper.opens
            for vertex in gripper.vertices:
                holders.setdefault(vertex, []).append((gripper.closes, end, number))
        for spans in holders.values():
            for (_, end, one), (start, _, other) in pairwise(sorted(spans)):
                if start < end:
                    first, second = sorted((one, other))
                    raise ValueError(
                        f"grippers must not hold the same vertex at the same time, given grippers {first} and {second}"
                    )

    @property
    def frames(self) -> int:
        """Number of frames of the rollout, including the start."""
        return int(np.floor(self.duration * self.frame_rate + 1e-6)) + 1

    def save(self, path: Path | str) -> None:
        """Write the scene file."""
        write_text(Path(path), self.model_dump_json(exclude_none=False) + "\n")

    @classmethod
    def load(cls, path: Path | str) -> Scene:
        """Read and validate a scene file, or raise InputError that names the file and the field."""
        value = read_json(Path(path))
        if not isinstance(value, dict):
            raise InputError(f"{path}: must be a JSON object, given {type(value).__name__}")
        return validated(cls, value, path)


@dataclass(frozen=True)
class Segment:
    """A time from `start` to `end` [s], in which no gripper opens or closes and all hands move on straight lines."""

    start: float
    end: float
    frame: bool
    """Whether the segment ends at a frame of the rollout."""
    held: tuple[bool, ...]
    """Whether each gripper is closed during the segment."""

    @property
    def duration(self) -> float:
        return self.end - self.start


def segments(scene: Scene, longest: float) -> list[Segment]:
    """Divide the time of a scene at each frame, opening and closing, and into segments of at most `longest` [s]."""
    frames = np.arange(scene.frames) / scene.frame_rate
    events = [time for gripper in scene.grippers for time in (gripper.closes, gripper.opens) if time is not None]
    instants = [(float(time), True) for time in frames]
    for event in sorted(set(events)):
        if 0.0 < event < frames[-1] and np.abs(frames - event).min() > 1e-7:  # otherwise the times are equal
            instants.append((event, False))
    found = []
    for (start, _), (end, frame) in pairwise(sorted(instants)):
        middle = 0.5 * (start + end)
        held = tuple(each.closes <= middle and (each.opens is None or middle < each.opens) for each in scene.grippers)
        pieces = max(1, int(np.ceil((end - start) / longest - 1e-6)))
        bounds = [start + (end - start) * k / pieces for k in range(pieces)] + [end]
        found += [Segment(a, b, frame and b == end, held) for a, b in pairwise(bounds)]
    return found
