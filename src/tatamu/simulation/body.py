"""Rigid bodies, such as fingers and obstacles, which move on given paths and with which cloth collides.

Every shape is a rounded box: all points whose distance from a core, a box with the half sizes h >= 0, is at most r. The
signed distance d of a point p in the frame of the body is:

    box      h = size, r = 0;     sphere   h = 0, r = size[0];     capsule  h = (0, 0, size[1]), r = size[0]
    d(p) = |max(q, 0)| + min(max(q_x, q_y, q_z), 0) - r,   q = |p| - h
"""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import BeforeValidator, Field, PlainSerializer, model_validator

from tatamu.base.arrays import MAX_COORDINATE, Points
from tatamu.base.records import Record
from tatamu.simulation.material import Number

SIZES = {"box": 3, "sphere": 1, "capsule": 2}
"""Number of entries in `size` for each shape."""
UNIT = 0.02
"""Maximum deviation of a quaternion's length from 1 [-], because numbers in files are rounded."""


def _quaternions(value: Any) -> np.ndarray:
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise ValueError("must be a list of quaternions [w, x, y, z]") from None
    if array.ndim != 2 or array.shape[1] != 4:
        raise ValueError(f"must be a list of quaternions [w, x, y, z], given an array of shape {array.shape}")
    lengths = np.linalg.norm(array, axis=1)
    wrong = ~(np.abs(lengths - 1.0) <= UNIT)
    if wrong.any():
        row = int(np.argmax(wrong))
        raise ValueError(f"must be unit quaternions [w, x, y, z], given length {lengths[row]:.3g} in row {row}")
    array.setflags(write=False)
    return array


def check_knots(times: list[float], **rows: np.ndarray | None) -> None:
    """Raise ValueError unless the times of knots increase, and each of the other fields has a row for each knot."""
    for earlier, later in pairwise(times):
        if not later > earlier:
            raise ValueError(f"times must increase from knot to knot, given {earlier:g} and then {later:g}")
    for field, values in rows.items():
        if values is not None and len(values) != len(times):
            raise ValueError(f"{field} must have one item for each of {len(times)} times, given {len(values)}")


Quaternions = Annotated[np.ndarray, BeforeValidator(_quaternions), PlainSerializer(lambda array: array.tolist())]
"""Unit quaternions (w, x, y, z), shape (k, 4)."""
Size = Annotated[float, Field(ge=1e-5, le=MAX_COORDINATE, strict=False)]


class Body(Record):
    """A rigid body: its shape, its friction and its motion."""

    name: str = ""
    """Name of the body in messages and pictures."""
    shape: Literal["box", "sphere", "capsule"]
    size: list[Size]
    """Half sizes of a box, the radius of a sphere, or the radius and half length (along z) of a capsule [m]."""
    friction: Number = Field(0.5, ge=0.0, le=10.0)
    """Coulomb coefficient between cloth and body [-]."""
    hand: Literal["left", "right"] | None = None
    """Hand to which a finger belongs; None for other bodies. A finger does not collide with triangles of which its hand
    holds a vertex, because these triangles are longer than a fingertip is thick and would stick out between the
    fingers."""
    times: Annotated[list[Number], Field(min_length=1)] = Field(default_factory=lambda: [0.0])
    """Times of the knots of the motion [s], increasing."""
    positions: Points
    """Centre at each knot [m], shape (k, 3); linear between knots, and constant before the first and after the last."""
    orientations: Quaternions | None = None
    """Unit quaternion (w, x, y, z) at each knot, from the frame of the body to that of the scene, shape (k, 4). None if
    the body never turns. Between knots, `slerp` interpolates."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if len(self.size) != SIZES[self.shape]:
            raise ValueError(f"size must have {SIZES[self.shape]} numbers for a {self.shape}, given {len(self.size)}")
        check_knots(self.times, positions=self.positions, orientations=self.orientations)
        return self

    @property
    def core(self) -> np.ndarray:
        """Half sizes h of the core [m], shape (3,)."""
        segment = [0.0, 0.0, self.size[1] if self.shape == "capsule" else 0.0]
        return np.array(self.size if self.shape == "box" else segment)

    @property
    def radius(self) -> float:
        """Radius r of the rounding [m]."""
        return 0.0 if self.shape == "box" else self.size[0]

    def path(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the centres [m], shape (k, 3), and unit quaternions (w, x, y, z), shape (k, 4), at k times [s]."""
        positions = np.column_stack([np.interp(times, self.times, column) for column in self.positions.T])
        if self.orientations is None:
            return positions, np.tile([1.0, 0.0, 0.0, 0.0], (len(times), 1))
        return positions, slerp(times, np.array(self.times), self.orientations)

    def pose(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the centre [m] and the rotation matrix from the body's frame to the scene's at a time [s]."""
        positions, orientations = self.path(np.array([time]))
        return positions[0], rotation(orientations[0])

    def local(self, points: np.ndarray, time: float = 0.0) -> np.ndarray:
        """Return points [m], shape (..., 3), in the frame of the body at a time [s]."""
        position, turned = self.pose(time)
        return np.asarray((points - position) @ turned)

    def distance(self, local: np.ndarray) -> np.ndarray:
        """Return the signed distance of points in the frame of the body [m], shape (...,); negative inside the body."""
        q = np.abs(local) - self.core
        outside = np.linalg.norm(np.maximum(q, 0.0), axis=-1)
        return np.asarray(outside + np.minimum(q.max(axis=-1), 0.0) - self.radius)


def slerp(times: np.ndarray, knots: np.ndarray, quaternions: np.ndarray) -> np.ndarray:
    """Interpolate quaternions, shape (m, 4), at k times on the sphere along the shorter way (Shoemake 1985)."""
    unit = quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)
    after = np.clip(np.searchsorted(knots, times, side="right"), 1, max(len(knots) - 1, 1))
    before = after - 1
    after = np.minimum(after, len(knots) - 1)
    span = np.maximum(knots[after] - knots[before], 1e-300)
    part = np.clip((times - knots[before]) / span, 0.0, 1.0)
    cosine = np.einsum("kq,kq->k", unit[before], unit[after])
    angle = np.arccos(np.clip(np.abs(cosine), 0.0, 1.0))
    sine = np.maximum(np.sin(angle), 1e-12)
    close = angle < 1e-6
    first = np.where(close, 1.0 - part, np.sin((1.0 - part) * angle) / sine)
    second = np.where(close, part, np.sin(part * angle) / sine) * np.where(cosine < 0.0, -1.0, 1.0)
    between = first[:, None] * unit[before] + second[:, None] * unit[after]
    return np.asarray(between / np.linalg.norm(between, axis=1, keepdims=True))


def rotation(quaternion: np.ndarray) -> np.ndarray:
    """Return the rotation matrix of a unit quaternion (w, x, y, z), shape (3, 3)."""
    w, x, y, z = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
