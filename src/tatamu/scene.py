"""A scene: everything that a simulator needs in order to make a rollout. See docs/reference/scene-and-rollout.md.

SI units, z up. The table's top is at z = `height`; `tilt` turns it about y, so that +x is downhill.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from tatamu.arrays import LARGEST, Edges, Triangles, edges
from tatamu.arrays import Index as Index
from tatamu.arrays import Points as Points
from tatamu.body import Body
from tatamu.clearance import deepest
from tatamu.errors import InputError
from tatamu.files import read_json, validated, write_text
from tatamu.material import GRAVITY, Material, Number
from tatamu.records import Record
from tatamu.topology import check_mesh

LEAST_IN_PLANE = 1e-3
"""Least part of a fibre's direction that lies in the plane of its triangle [-]."""

MOST_VERTICES = 150_000
"""Largest number of vertices of a cloth, which takes ten seconds to prepare; garments have 2,000."""
MOST_GRIPPERS = 1000
"""Largest number of grippers of a scene; a hand that pinches layers together has one for each."""
MOST_BODIES = 100
"""Largest number of rigid bodies of a scene, because each is compared with every triangle."""
SAME_TIME = 1e-9
"""Largest difference of times that count as equal [s], because sums of steps have rounding errors."""


def _check_fibre(rest: np.ndarray, faces: np.ndarray, fibre: np.ndarray) -> None:
    if len(fibre) not in (1, len(faces)):
        raise ValueError(f"fibre must be one vector or one for each of {len(faces)} triangles, given {len(fibre)}")
    a, b, c = (rest[faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    within = np.linalg.norm(np.cross(normal, fibre), axis=1) / np.linalg.norm(normal, axis=1)
    if not (within > LEAST_IN_PLANE * np.maximum(np.linalg.norm(fibre, axis=1), 1e-30)).all():
        wrong = int(np.argmin(within))
        raise ValueError(
            f"fibre must have a part in the plane of its triangle, triangle {wrong} has "
            f"{fibre[min(wrong, len(fibre) - 1)].tolist()}"
        )


class Cloth(Record):
    """A triangle mesh of the cloth's mid-surface."""

    vertices: Points
    """Start positions [m], shape (n, 3)."""
    faces: Triangles
    """Triangles, shape (m, 3)."""
    rest_vertices: Points | None = None
    """The unstrained shape [m], shape (n, 3); None for `vertices`."""
    seams: Edges = Field(default_factory=lambda: edges([]))
    """Mesh edges that hinge freely, shape (s, 2)."""
    fibre: Points | None = None
    """Direction of the warp in the unstrained shape, shape (m, 3), or (1, 3) for all triangles.

    Its part in the plane of each triangle is used. None for x, or for y in triangles perpendicular to x.
    """

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.rest_vertices is not None and self.rest_vertices.shape != self.vertices.shape:
            raise ValueError(
                f"rest_vertices must be as many as vertices ({len(self.vertices)}), given {len(self.rest_vertices)}"
            )
        if len(self.vertices) > MOST_VERTICES:
            raise ValueError(f"vertices must be at most {MOST_VERTICES}, given {len(self.vertices)}: coarsen it")
        check_mesh(self.rest, self.faces, self.seams)
        if self.fibre is not None:
            _check_fibre(self.rest, self.faces, self.fibre)
        return self

    @property
    def rest(self) -> np.ndarray:
        """The unstrained shape [m], shape (n, 3)."""
        return self.vertices if self.rest_vertices is None else self.rest_vertices


class Table(Record):
    """A plane that the cloth lies on: z = height - x tan(tilt)."""

    height: Number = Field(0.0, ge=-LARGEST, le=LARGEST)
    """Top at x = 0 [m]."""
    tilt: Number = Field(0.0, ge=-1.5533, le=1.5533)
    """Turned about y [rad], at most 89 degrees: +x is downhill."""


class Gripper(Record):
    """Vertices held from `closes` to `opens`; they keep their arrangement and follow `displacements`."""

    hand: Literal["left", "right"] | None = None
    """The hand that it belongs to.

    None if the scene does not name hands. Fingers that press layers together are several grippers of one hand; the
    first moves like the hand.
    """
    vertices: Annotated[list[Index], Field(min_length=1)]
    """The held vertices."""
    closes: Number = Field(0.0, ge=0.0)
    """Time at which the gripper closes [s]."""
    opens: Number | None = None
    """Time at which it opens again [s]; None for never."""
    times: Annotated[list[Number], Field(min_length=1)]
    """Knots of the motion [s], increasing."""
    displacements: Points
    """Displacement from where it closed at each knot [m], shape (k, 3); linear between, held after the last."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        sorted_vertices = sorted(self.vertices)
        twice = next((one for one, other in pairwise(sorted_vertices) if one == other), None)
        if twice is not None:
            raise ValueError(f"vertices must be different from one another, given {twice} twice")
        if self.opens is not None and not self.opens > self.closes:
            raise ValueError(f"opens must be later than closes ({self.closes:g} s), given {self.opens:g} s")
        for earlier, later in pairwise(self.times):
            if not later > earlier:
                raise ValueError(f"times must increase from knot to knot, given {earlier:g}, {later:g}")
        if len(self.times) != len(self.displacements):
            raise ValueError(
                f"displacements must be as many as times ({len(self.times)}), given {len(self.displacements)}"
            )
        return self

    def path(self, times: np.ndarray) -> np.ndarray:
        """Displacements from where it closed [m], shape (k, 3), at times [s], shape (k,); zero before the first."""
        path = np.column_stack([np.interp(times, self.times, column) for column in self.displacements.T])
        path[times < self.times[0] - SAME_TIME] = 0.0
        return path

    def displacement(self, time: float) -> np.ndarray:
        """Displacement from where it closed [m], shape (3,)."""
        return self.path(np.array([time]))[0]


class Scene(Record):
    """Cloth, material, table, hands, rigid bodies and time: the whole input of a simulator."""

    version: Literal[1] = 1
    cloth: Cloth
    material: Material
    table: Table | None = None
    grippers: Annotated[list[Gripper], Field(max_length=MOST_GRIPPERS)] = Field(default_factory=list)
    bodies: Annotated[list[Body], Field(max_length=MOST_BODIES)] = Field(default_factory=list)
    """Rigid bodies that the cloth collides with, at most 100."""
    gravity: Number = Field(GRAVITY, ge=0.0, le=1e3)
    """Downward acceleration [m/s^2]."""
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
                    f"grippers.{number}.vertices must be below {count}, the number of vertices, "
                    f"given {max(gripper.vertices)}"
                )
        self._check_held_once()
        for number, body in enumerate(self.bodies):
            depth = 0.5 * self.material.thickness + deepest(body, self.cloth.vertices, self.cloth.faces)
            if depth > self.material.thickness:
                raise ValueError(
                    f"bodies.{number} must begin outside the cloth, or inside it by at most its thickness "
                    f"({self.material.thickness:g} m), given {depth:.3g} m; move the body or the cloth"
                )
        if self.frames > 200_000:
            raise ValueError(f"duration x frame_rate must be at most 200000 frames, given {self.frames}")
        return self

    def _check_held_once(self) -> None:
        """Refuse grippers that hold one vertex at one time."""
        holders: dict[int, list[tuple[float, float, int]]] = {}
        for number, gripper in enumerate(self.grippers):
            end = np.inf if gripper.opens is None else gripper.opens
            for vertex in gripper.vertices:
                holders.setdefault(vertex, []).append((gripper.closes, end, number))
        for spans in holders.values():
            for (_, end, one), (start, _, other) in pairwise(sorted(spans)):
                if start < end:
                    first, second = sorted((one, other))
                    raise ValueError(f"grippers {first} and {second} hold the same vertex at the same time")

    @property
    def frames(self) -> int:
        """Number of frames of the rollout, the start included."""
        return int(np.floor(self.duration * self.frame_rate + 1e-6)) + 1

    def save(self, path: Path | str) -> None:
        """Write the scene file."""
        write_text(Path(path), self.model_dump_json(exclude_none=False) + "\n")

    @classmethod
    def load(cls, path: Path | str) -> Scene:
        """Read and validate a scene file.

        Raises:
            InputError: If the file cannot be read, or a field is wrong; the message names both.
        """
        value = read_json(Path(path))
        if not isinstance(value, dict):
            raise InputError(f"{path}: (whole file): must be a JSON object, given {type(value).__name__}")
        return validated(cls, value, path)
