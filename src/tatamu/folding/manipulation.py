"""A manipulation: where the hands grasp, the paths they follow, when they move and let go."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Self

import numpy as np
from pydantic import Field, model_validator

from tatamu import curves
from tatamu.curves import Bezier
from tatamu.folding.fingers import cleared
from tatamu.folding.fold import Fold
from tatamu.folding.pinch import pressed
from tatamu.material import Material
from tatamu.records import OpenRecord
from tatamu.scene import Cloth, Gripper, Scene, Table

TOP_SPEED = 0.6
"""Fastest that a hand moves [m/s]; folding twice as fast changes folds (De Gusseme and wyffels 2022)."""
WAIT, HOLD, SETTLE = 0.1, 0.4, 1.0
"""Before the hands move, between arriving and opening, and after opening until the fold is scored [s]."""
FRAME_RATE = 60.0
"""Frames per second [1/s]."""

HANDS = ("left", "right")
"""Names of the hands, in the order of `Manipulation`."""
_CLOSING = np.linspace(0.0, WAIT, round(WAIT * FRAME_RATE) + 1).tolist()
"""When fingers close, frame by frame [s]: before the hands move."""


class Timing(OpenRecord):
    """When the hands close, start, arrive and open, and when the scene ends [s]."""

    closes: float = Field(ge=0)
    starts: float
    arrives: float
    opens: float
    ends: float
    top_speed: float | None = None
    """Of the faster hand [m/s]; None: not said."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        for early, late in pairwise(("closes", "starts", "arrives", "opens", "ends")):
            if getattr(self, late) < getattr(self, early):
                raise ValueError(f"{late} must not be before {early}")
        if not self.arrives > self.starts:
            raise ValueError("arrives must be after starts")
        return self


@dataclass(frozen=True)
class Manipulation:
    """One trial as the hands see it; one hand, or two."""

    grasps: tuple[int, ...]
    """Grasped vertex of the left and of the right hand."""
    positions: tuple[np.ndarray, ...]
    """Where each hand grasps [m], shape (3,)."""
    paths: tuple[np.ndarray, ...]
    """Each hand's path relative to its grasp [m], shape (s, 3), from 0 to its release."""
    control_points: tuple[np.ndarray, ...] | None
    """P0..P3 of each hand relative to its grasp [m], shape (4, 3); None for paths that are no cubic Bezier."""
    lift: float = 0.0
    """How high over their grasps the hands begin, as their fingers have closed [m]."""
    settle: float = SETTLE
    """After opening, until the fold is scored [s]."""

    @property
    def curves(self) -> tuple[Bezier, ...]:
        """Each hand's Bezier curve in the scene.

        Raises:
            ValueError: The paths are no cubic Bezier curves.
        """
        if self.control_points is None:
            raise ValueError("the paths of this manipulation are polylines")
        placed = zip(self.positions, self.control_points, strict=True)
        return tuple(Bezier(position + points + self._up) for position, points in placed)

    @property
    def _up(self) -> np.ndarray:
        return np.array([0.0, 0.0, self.lift])

    @property
    def trajectory_length(self) -> float:
        """l_x of Eq. (10): the mean length of both hands' paths [m]."""
        return sum(map(curves.length, self.paths)) / len(self.paths)

    @property
    def move_seconds(self) -> float:
        """How long the hands move [s], a whole number of frames; the longer path sets it."""
        longest = max(map(curves.length, self.paths))
        return float(np.ceil(curves.minimum_jerk_duration(longest, TOP_SPEED) * FRAME_RATE) / FRAME_RATE)

    @property
    def timing(self) -> Timing:
        """When the hands close, move and open."""
        arrives = WAIT + self.move_seconds
        return Timing(
            closes=0.0,
            starts=WAIT,
            arrives=round(arrives, 9),
            opens=round(arrives + HOLD, 9),
            ends=round(arrives + HOLD + self.settle, 9),
            top_speed=TOP_SPEED,
        )

    def motion(self) -> tuple[np.ndarray, list[np.ndarray]]:
        """Knots of the motion, one per frame: times [s], shape (k,), displacements of each hand [m], shape (k, 3)."""
        count = round(self.move_seconds * FRAME_RATE)
        fraction = curves.minimum_jerk(np.arange(count + 1) / count)
        times = WAIT + np.arange(count + 1) / FRAME_RATE
        return times, [curves.along(path, fraction) + self._up for path in self.paths]


def bezier_manipulation(
    fold: Fold, grasps: tuple[int, ...], x1: float, z1: float, x2: float, z2: float
) -> Manipulation:
    """The paper's manipulation, Eq. (9): P1 and P2 are given relative to P0, x along the fold, z up [m].

    They are those of a hand at the fold's span; a hand that is farther from the line follows the same curve, larger in
    proportion, so that both hands turn the cloth about the line together.
    """
    across = np.array([*fold.normal, 0.0])
    up = np.array([0.0, 0.0, 1.0])
    points = []
    for vertex in grasps:
        larger = fold.span_of(vertex) / fold.span
        inner = [larger * (x1 * across + z1 * up), larger * (x2 * across + z2 * up)]
        points.append(np.stack([np.zeros(3), *inner, fold.translation(vertex)]))
    paths = tuple(map(curves.sampled_bezier, points))
    return Manipulation(grasps, _places(fold, grasps), paths, tuple(points), fold.lift)


def trajectory_lengths(fold: Fold, parameters: Mapping[str, np.ndarray]) -> np.ndarray:
    """l_x of Eq. (10) of many manipulations at once [m], shape (p,), without sampling their paths.

    Args:
        fold: The fold.
        parameters: x1, z1, x2, z2 [m], g1 and g2 of Eq. (9), each of shape (p,).
    """
    x1, z1, x2, z2 = (parameters[name] for name in ("x1", "z1", "x2", "z2"))
    zero = np.zeros_like(x1)
    total = zero
    for name, releases in zip(("g1", "g2"), fold.releases, strict=False):
        chosen = np.minimum(parameters[name].astype(int), fold.candidates - 1)
        spans, rises = releases[chosen].T
        larger = spans / fold.span
        ahead = np.stack([zero, larger * x1, larger * x2, spans], axis=1)
        up = np.stack([zero, larger * z1, larger * z2, rises], axis=1)
        total = total + curves.bezier_lengths(np.stack([ahead, up], axis=2))
    return total / fold.hands


def polyline_manipulation(fold: Fold, grasps: tuple[int, ...], paths: Sequence[np.ndarray]) -> Manipulation:
    """Hands that follow polylines relative to their grasps [m], shape (s, 3) each."""
    return Manipulation(grasps, _places(fold, grasps), tuple(paths), None, fold.lift)


def _places(fold: Fold, grasps: tuple[int, ...]) -> tuple[np.ndarray, ...]:
    return tuple(fold.start[vertex] for vertex in grasps)


@dataclass(frozen=True)
class Carry:
    """A hand that carries the vertices it holds."""

    vertex: int
    """The grasped vertex."""
    times: np.ndarray
    """Knots of the motion [s], shape (k,); the first is when the hand begins to move."""
    displacements: np.ndarray
    """From the grasp at each knot [m], shape (k, 3); the first is where the hand is as it has closed."""
    opens: float
    """When the hand opens [s]."""


def carries_of(fold: Fold, manipulation: Manipulation) -> list[Carry]:
    """Both hands of a manipulation, left before right, their fingers clear of what lies below them."""
    times, displacements = manipulation.motion()
    opens = manipulation.timing.opens
    hands = zip(manipulation.grasps, displacements, strict=True)
    return [Carry(vertex, times, cleared(fold, vertex, moved), opens) for vertex, moved in hands]


def scene_of(fold: Fold, manipulation: Manipulation) -> Scene:
    """The scene of one trial: the garment as it lies on the table, and the hands.

    A hand is one gripper, left before right, or several where its fingers press layers together.
    """
    return scene_with(fold, carries_of(fold, manipulation), manipulation.timing.ends, fold.garment.material)


def scene_with(fold: Fold, carries: Sequence[Carry], ends: float, material: Material) -> Scene:
    """The scene of hands that carry the garment about in other manners than a manipulation says.

    Args:
        fold: The fold.
        carries: What each hand does.
        ends: When the scene ends [s].
        material: Of the cloth; of another thickness it lies as much higher.
    """
    grippers = [
        Gripper(vertices=held, closes=0.0, opens=carry.opens, times=knots, displacements=path)
        for carry in carries
        for held, down in _held(fold, carry.vertex)
        for knots, path in [_after_closing(carry, down)]
    ]
    return Scene(
        cloth=_cloth(fold, material.thickness / fold.garment.material.thickness),
        material=material,
        table=Table(),
        grippers=grippers,
        duration=ends,
        frame_rate=FRAME_RATE,
    )


def _held(fold: Fold, vertex: int) -> list[tuple[list[int], float]]:
    """The vertices of a hand in parts that its fingers press down equally far [m]; the part that stays is the first."""
    patch = np.array(fold.patch(vertex))
    down = pressed(fold.start[patch], fold.garment.material.thickness, fold.garment.spacing)
    return [(patch[down == each].tolist(), float(each)) for each in np.unique(down)[::-1]]


def _after_closing(carry: Carry, down: float) -> tuple[list[float], np.ndarray]:
    """Knots [s] and displacements [m] of what the fingers press `down` while they close, and then carry along."""
    pressed_down = np.array([0.0, 0.0, down])
    shift = pressed_down + carry.displacements[0]
    if not shift.any():
        return carry.times.tolist(), carry.displacements
    closing = curves.minimum_jerk(np.linspace(0.0, 1.0, len(_CLOSING)))[:-1, None] * shift
    moved = carry.displacements + pressed_down
    return [*_CLOSING[:-1], *carry.times.tolist()], np.concatenate([closing, moved])


def _cloth(fold: Fold, thicker: float) -> Cloth:
    """The cloth before the fold; once it was folded, its unstrained shape is still the flat one."""
    garment = fold.garment
    rest = garment.rest if fold.start is garment.vertices else garment.unstrained
    start = fold.start if thicker == 1.0 else fold.start * [1.0, 1.0, thicker]
    unstrained = fold.start if rest is None and start is not fold.start else rest
    return Cloth(
        vertices=start, faces=garment.faces, rest_vertices=unstrained, seams=garment.seams, fibre=garment.fibre
    )
