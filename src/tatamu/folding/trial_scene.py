"""The scene of a manipulation: the garment on the table before the fold, and the hands that carry it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tatamu.base import curves
from tatamu.folding.fold import Fold
from tatamu.folding.grasps import pressed
from tatamu.folding.hand import HandPath, finger_bodies, leaves
from tatamu.folding.manipulation import FRAME_RATE, HANDS, WAIT, Hand, Manipulation
from tatamu.folding.press import press_body
from tatamu.simulation.body import Body
from tatamu.simulation.material import ORTHOTROPIC_MEMBRANE, Material
from tatamu.simulation.scene import Cloth, Gripper, Scene, Table

_CLOSING = np.linspace(0.0, WAIT, round(WAIT * FRAME_RATE) + 1).tolist()
"""Times of the frames in which the fingers close [s]."""


@dataclass(frozen=True)
class Carry:
    """The motion of a hand that carries vertices."""

    hand: Hand
    vertex: int
    times: np.ndarray
    """Times of the k knots of the motion, the first when the hand has closed [s], shape (k,)."""
    displacements: np.ndarray
    """Displacement from the grasp at each knot [m], shape (k, 3), the first of them 0."""
    opens: float
    """Time at which the hand opens [s]."""
    beside: np.ndarray | None = None
    """Position of the hand relative to the grasped vertex at each knot [m], shape (k, 3); None if it is at the vertex.
    """


def carries_of(fold: Fold, manipulation: Manipulation) -> list[Carry]:
    """Return the motion of each hand in a manipulation, left before right."""
    times, displacements = manipulation.motion()
    opens = manipulation.timing.opens
    hands = zip(HANDS, manipulation.grasps, displacements, strict=False)
    return [Carry(hand, vertex, times, moved, opens) for hand, vertex, moved in hands]


def scene_of(fold: Fold, manipulation: Manipulation) -> Scene:
    """Return the scene of one trial: the garment on the table before the fold, and the hands, left before right.

    Each hand is one gripper, or several if its fingers press layers together. Fingers with a thickness are bodies.
    """
    return scene_with(fold, carries_of(fold, manipulation), manipulation.timing.ends, fold.garment.material)


def scene_with(fold: Fold, carries: Sequence[Carry], ends: float, material: Material) -> Scene:
    """Return a scene that ends at a time [s], whose hands may have motions that no `Manipulation` can describe.

    Cloth of a thicker material than the garment's lies higher.
    """
    grippers = [
        Gripper(hand=carry.hand, vertices=held, closes=0.0, opens=carry.opens, times=knots, displacements=path)
        for carry in carries
        for held, down in _held(fold, carry.vertex)
        for knots, path in [_after_closing(carry, down)]
    ]
    fingered = carries if fold.fingers.stated else ()
    bodies = [body for carry in fingered for body in _fingers(fold, carry, material.thickness)]
    if fold.press is not None:
        left = max((carry.opens for carry in carries), default=0.0) + leaves(fold.fingers)
        low, high = fold.crease_ends
        gap = fold.press.gap_over(material, fold.folded_thickness, high - low)
        bodies.append(press_body(fold.press, fold.crease, (low, high), gap, left))
        ends = max(ends, left + fold.press.duration)
    return Scene(
        cloth=_cloth(fold, material.thickness / fold.garment.material.thickness),
        material=softened(material, fold.softening),
        table=Table(),
        grippers=grippers,
        bodies=bodies,
        duration=ends,
        frame_rate=FRAME_RATE,
    )


def _held(fold: Fold, vertex: int) -> list[tuple[list[int], float]]:
    """Return groups of held vertices, each with the height by which closing fingers move it [m], unpressed first."""
    patch = np.array(fold.patch(vertex))
    down = pressed(fold.start[patch], fold.garment.material.thickness, fold.garment.spacing)
    return [(patch[down == each].tolist(), float(each)) for each in np.unique(down)[::-1]]


def _fingers(fold: Fold, carry: Carry, thickness: float) -> list[Body]:
    heights = np.concatenate([fold.start[held, 2] + down for held, down in _held(fold, carry.vertex)])
    heights = heights * thickness / fold.garment.material.thickness
    middle = 0.5 * (heights.min() + heights.max())
    knots, path = _after_closing(carry, 0.0)
    beside = np.zeros((len(path), 3))
    if carry.beside is not None:
        beside[-len(carry.beside) :] = carry.beside
        beside[: -len(carry.beside)] = carry.beside[0]
    hand = HandPath(
        times=np.array(knots),
        points=path + beside + [*fold.start[carry.vertex, :2], middle],
        closed=WAIT,
        opens=carry.opens,
    )
    return finger_bodies(carry.hand, fold.fingers, fold.normal, float(np.ptp(heights)) + thickness, hand)


def _after_closing(carry: Carry, down: float) -> tuple[list[float], np.ndarray]:
    """Return the knots [s] and displacements [m] of vertices that are pressed by `down` [m], then carried."""
    pressed_down = np.array([0.0, 0.0, down])
    shift = pressed_down + carry.displacements[0]
    if not shift.any():
        return carry.times.tolist(), carry.displacements
    closing = curves.minimum_jerk(np.linspace(0.0, 1.0, len(_CLOSING)))[:-1, None] * shift
    moved = carry.displacements + pressed_down
    return [*_CLOSING[:-1], *carry.times.tolist()], np.concatenate([closing, moved])


def _cloth(fold: Fold, thicker: float) -> Cloth:
    """Return the cloth before the fold. Its unstrained shape is the flat garment, even after earlier folds."""
    garment = fold.garment
    rest = garment.rest if fold.start is garment.vertices else garment.unstrained
    start = fold.start if thicker == 1.0 else fold.start * [1.0, 1.0, thicker]
    unstrained = fold.start if rest is None and start is not fold.start else rest
    return Cloth(
        vertices=start, faces=garment.faces, rest_vertices=unstrained, seams=garment.seams, fibre=garment.fibre
    )


def softened(material: Material, divisor: float) -> Material:
    """Return a material whose stretch and shear stiffnesses are divided."""
    if divisor == 1.0:
        return material
    known = {name: getattr(material, name) for name in ("stretch_stiffness", *ORTHOTROPIC_MEMBRANE)}
    return material.model_copy(update={name: value / divisor for name, value in known.items() if value is not None})
