"""The scene of a manipulation in a scenario.

Positions are relative to the cloth, so the target shape is the same in all scenarios: a table that is too high is
simulated as hands that are too low, and displaced cloth as displaced hands.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pydantic import ValidationError

from tatamu.base import curves
from tatamu.base.errors import SimulationError
from tatamu.evaluation.disturbances.channels import FIELDS
from tatamu.evaluation.disturbances.scenario import Scenario
from tatamu.folding.fingers import PAD
from tatamu.folding.fold import Fold
from tatamu.folding.manipulation import HANDS, Manipulation
from tatamu.folding.trial_scene import Carry, carries_of, scene_of, scene_with
from tatamu.simulation.material import Material
from tatamu.simulation.scene import Scene

NEAR = 0.02
"""Horizontal distance over which layers below a finger begin to carry it [m]: behind the fold line for layers that
stay, and shortly before the release for those that the hand carries."""
MIN_HELD = 0.2
"""Minimum fraction of a pad's planned cloth, below which the hand holds nothing [-]."""
SIDES = (("left", 1.0), ("right", -1.0))
"""Hands, each with the sign with which half of `hands.difference` is added to its position."""


@dataclass(frozen=True)
class DisturbedHand:
    """A hand in a scenario."""

    carry: Carry | None
    """Its motion; None if the hand holds nothing."""
    failure: str | None
    """Why the hand fails, if this is known without a simulation; None if it does not fail."""


def disturbed_hands(fold: Fold, manipulation: Manipulation, scenario: Scenario) -> list[DisturbedHand]:
    """Return the hands of a manipulation in a scenario, or none if nothing is disturbed.

    A corrected manipulation may send a hand to a point next to its vertex, where it then closes. A hand that grasps
    next to the cloth holds nothing, and one that is commanded too far below the table stops.
    """
    aims = np.array(manipulation.positions) - fold.start[list(manipulation.grasps)]
    if scenario.is_nominal and not aims.any():
        return []
    planned = enumerate(zip(carries_of(fold, manipulation), aims, strict=True))
    return [_hand(fold, manipulation, scenario, number, usual, aim) for number, (usual, aim) in planned]


def hand_failure(hands: Sequence[DisturbedHand]) -> str | None:
    """Return why the first hand that fails does; None if none fails."""
    return next((hand.failure for hand in hands if hand.failure is not None), None)


def disturbed_scene(
    fold: Fold, manipulation: Manipulation, scenario: Scenario, hands: Sequence[DisturbedHand] | None = None
) -> Scene:
    """Return the scene of a manipulation in a scenario. Without disturbances, it is that of `scene_of`.

    `hands` are those of `disturbed_hands`, if they are known already.

    Raises:
        SimulationError: If both hands would grasp the same point.
    """
    hands = disturbed_hands(fold, manipulation, scenario) if hands is None else hands
    if not hands:
        return scene_of(fold, manipulation)
    held = [hand.carry for hand in hands if hand.carry is not None]
    slower = manipulation.timing.opens + manipulation.move_seconds * (1.0 / scenario.factor("hands.speed") - 1.0)
    ends = round(max([slower, *(carry.opens for carry in held)]) + manipulation.settle, 9)
    try:
        return scene_with(fold, held, ends, _material(fold.garment.material, scenario))
    except ValidationError:
        raise SimulationError("both hands would grasp the same place") from None


def _material(usual: Material, scenario: Scenario) -> Material:
    known = {name: getattr(usual, name) for name in FIELDS if getattr(usual, name) is not None}
    changed = {name: float(np.clip(known[name] * _factor(name, scenario), *_bounds(name))) for name in known}
    return _possible(usual.model_copy(update=changed))


def _possible(material: Material) -> Material:
    """Return the nearest material whose fields, each within its bounds, are consistent with each other."""
    changed: dict[str, float] = {}
    if material.orthotropic_membrane:
        changed["compression"] = 1.0
    if material.bending_rigidity_initial is not None:
        above = np.nextafter(material.bending_rigidity, np.inf)
        changed["bending_rigidity_initial"] = max(material.bending_rigidity_initial, float(above))
    if material.bending_rigidity_bias is not None:
        least = 0.25 * (material.bending_rigidity + material.weft_rigidity)
        changed["bending_rigidity_bias"] = max(material.bending_rigidity_bias, least)
    return material.model_copy(update=changed)


def _factor(name: str, scenario: Scenario) -> float:
    """Return the random factor of a field of the material."""
    own = scenario.factor(f"material.{name}")
    stiffnesses = ("stretch_stiffness", "bending_rigidity")  # those along the warp also vary in the other directions
    base = next((field for field in stiffnesses if name.startswith(f"{field}_")), None)
    return own if base is None else own * scenario.factor(f"material.{base}")


def _bounds(name: str) -> tuple[float, float]:
    limits = Material.model_fields[name].metadata
    least = next(limit.ge for limit in limits if hasattr(limit, "ge"))
    return float(least), float(next(limit.le for limit in limits if hasattr(limit, "le")))


@dataclass(frozen=True)
class _Grasp:
    """The actual grasp of a hand, seen from above."""

    vertex: int
    """The vertex nearest to the point of the grasp, which represents it in the simulation."""
    place: np.ndarray
    """The point of the grasp [m], shape (2,)."""
    slip: np.ndarray
    """Displacement from the intended to the actual point, along the fold and across it [m], shape (2,)."""
    rest: float
    """Distance along the fold from the actual point to the vertex [m]."""
    misses: bool
    """Whether the fingers close next to the cloth."""


def _hand(
    fold: Fold, manipulation: Manipulation, scenario: Scenario, number: int, usual: Carry, aim: np.ndarray
) -> DisturbedHand:
    """Return a hand with its usual motion, which is sent to its vertex plus the offset `aim` [m], shape (3,)."""
    grasp = _grasp(fold, usual.vertex, aim, scenario, number)
    if grasp.misses:
        return DisturbedHand(None, f"the {HANDS[number]} hand grasps beside the cloth")
    speed = scenario.factor("hands.speed")
    times = usual.times[0] + (usual.times - usual.times[0]) / speed
    share = curves.minimum_jerk(np.linspace(0.0, 1.0, len(times)))[:, None]
    back = grasp.slip + np.array([2.0 * grasp.rest, 0.0])
    off = _off(fold, manipulation, scenario, number) - fold.vector(*back) + [0.0, 0.0, aim[2]]
    moved = _turned(usual.displacements, -scenario["cloth.yaw"]) + np.hstack([share, share, np.ones_like(share)]) * off
    floor = _floor(fold, grasp.vertex, moved)
    too_low = float((floor - moved[:, 2]).max())  # below the table, or below the layers that stop the hand
    moved[:, 2] = np.maximum(moved[:, 2], floor)
    opens = usual.opens + float(times[-1] - usual.times[-1]) + _delay(scenario, number)
    turning = fold.vector(2.0 * grasp.rest)
    beside = share * turning - [*(fold.start[grasp.vertex, :2] - grasp.place), 0.0]
    failure = None
    if too_low > fold.fingers.compliance:
        failure = (
            f"the {HANDS[number]} hand meets the table: the hand is {1e3 * too_low:.1f} mm too low, but its fingers "
            f"yield by only {1e3 * fold.fingers.compliance:.1f} mm"
        )
    return DisturbedHand(Carry(HANDS[number], grasp.vertex, times, moved, opens, beside), failure)


def hand_errors(fold: Fold, manipulation: Manipulation, scenario: Scenario) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return those errors of each hand that a correction can undo, along the fold, across it and up [m].

    Each has that of its grasp, shape (2,), and that of its position, shape (3,), with the cloth's displacement.
    """
    lies = scenario.vector("cloth.place")
    found = []
    for number, side in enumerate(HANDS[: len(manipulation.grasps)]):
        off = _off(fold, manipulation, scenario, number)
        hand = np.array([off[:2] @ fold.normal, off[:2] @ fold.crease.along, off[2]]) - lies
        grasp = np.array([scenario[f"grasp.into.{side}"], scenario[f"grasp.along.{side}"]]) - lies[:2]
        found.append((grasp, hand))
    return found


def _delay(scenario: Scenario, number: int) -> float:
    """Return the delay of a hand's opening [s]: the left hand's if the disturbance is positive, else the right's."""
    return max(0.0, SIDES[number][1] * scenario["hands.opening_delay"])


def _off(fold: Fold, manipulation: Manipulation, scenario: Scenario, number: int) -> np.ndarray:
    """Return the error of a hand's position while it carries the cloth and lays it down [m], shape (3,).

    Its horizontal part does not act at the grasp, which has an error of its own.
    """
    error = scenario.vector("hands.offset") - [0.0, 0.0, scenario["table.height"]]
    if len(manipulation.grasps) > 1:
        part = SIDES[number][1]
        middle = np.mean(manipulation.positions, axis=0)
        arm = (manipulation.positions[number] - middle)[:2]
        turned = _turned(np.array([[*arm, 0.0]]), scenario["hands.yaw"])[0] - [*arm, 0.0]
        return fold.vector(*(error + 0.5 * part * scenario.vector("hands.difference"))) + turned
    return fold.vector(*error)


def _grasp(fold: Fold, vertex: int, aim: np.ndarray, scenario: Scenario, number: int) -> _Grasp:
    """Return the actual grasp of a hand that is sent to a vertex plus the offset `aim` [m], shape (3,)."""
    side = SIDES[number][0]
    place = fold.start[vertex, :2]
    wrong = np.array([scenario[f"grasp.into.{side}"], scenario[f"grasp.along.{side}"]])
    middle = 0.5 * (fold.start[:, :2].min(axis=0) + fold.start[:, :2].max(axis=0))
    seen = np.array([[*(place - middle), 0.0]])
    turned = _turned(seen, -scenario["cloth.yaw"])[0, :2] + middle - place
    lies = fold.vector(*scenario.vector("cloth.place"))[:2]
    held = place + aim[:2] + fold.vector(*wrong)[:2] + turned - lies
    chosen = _nearest(fold, vertex, held)
    rest = float((fold.start[chosen, :2] - held) @ fold.normal)
    misses = _covered(fold, held) < MIN_HELD * _covered(fold, place)
    return _Grasp(chosen, held, wrong, rest, misses)


def _covered(fold: Fold, place: np.ndarray) -> float:
    """Return the fraction of a pad that is over cloth, if the middle of its outer edge is at `place` [m]."""
    along, into = ((np.arange(count) + 0.5) / count for count in (12, 8))  # points along the cloth's edge and across it
    along, into = (along - 0.5) * fold.fingers.width, into * PAD
    points = place + (into[:, None, None] * fold.normal + along[None, :, None] * fold.crease.along).reshape(-1, 2)
    corners = fold.start[fold.garment.faces, :2]
    far = fold.fingers.width + PAD
    near = ((corners.min(axis=1) < place + far) & (corners.max(axis=1) > place - far)).all(axis=1)
    a, b, c = np.moveaxis(corners[near], 1, 0)
    turns = [_side_of(p, q, points) for p, q in ((a, b), (b, c), (c, a))]
    inside = np.all([turn >= -1e-12 for turn in turns], axis=0) | np.all([turn <= 1e-12 for turn in turns], axis=0)
    return float(inside.any(axis=1).mean())


def _side_of(start: np.ndarray, end: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return on which side of m edges, shapes (m, 2), k points lie, shape (k, m): positive for the left."""
    edge = end - start
    away = points[:, None] - start[None]
    return np.asarray(edge[:, 0] * away[..., 1] - edge[:, 1] * away[..., 0])


def _nearest(fold: Fold, vertex: int, place: np.ndarray) -> int:
    """Return the vertex of the moving side that is nearest to a point, `vertex` in a tie."""
    across, _ = fold.crease.split(fold.start)
    level = np.abs(fold.start[:, 2] - fold.start[vertex, 2]) < 0.5 * fold.garment.material.thickness
    near = np.flatnonzero((across < 0) & level)
    distance = np.linalg.norm(fold.start[near, :2] - place, axis=1)
    best = int(near[distance.argmin()])
    own = float(np.linalg.norm(fold.start[vertex, :2] - place))
    return vertex if own <= distance.min() + 1e-9 else best


def _floor(fold: Fold, vertex: int, moved: np.ndarray) -> np.ndarray:
    """Return the lowest possible vertical displacement of a hand at each of k instants [m], shape (k,).

    The table stops every hand. Layers of cloth stop described fingers, which are rigid bodies: they press into the
    layers by a quarter of a thickness before their arm yields.
    """
    thickness = fold.garment.material.thickness
    table = np.full(len(moved), 0.5 * thickness - float(fold.start[fold.patch(vertex), 2].min()))
    if not fold.fingers.stated:
        return table
    across, _ = fold.crease.split(fold.start[vertex] + moved)
    beyond = np.clip(across / NEAR, 0.0, 1.0)
    released = np.clip(1.0 - (across[-1] - across) / NEAR, 0.0, 1.0)
    layers = fold.stacks.under[vertex] + released * fold.held_thickness(vertex) - 0.25 * thickness
    return fold.fingers.lift + table + beyond * np.maximum(layers, 0.0)


def _turned(vectors: np.ndarray, angle: float) -> np.ndarray:
    """Return k vectors, shape (k, 3), rotated about the vertical by an angle [rad]."""
    if not angle:
        return vectors
    cos, sin = np.cos(angle), np.sin(angle)
    return vectors @ np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
