"""Every check passes on a simulator that knows the answer, and fails on one that is a little wrong."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial

import numpy as np
import pytest
from scipy.optimize import brentq

from tatamu.base.errors import SimulationError
from tatamu.simulation.heavy_strip import cantilever
from tatamu.simulation.material import Material
from tatamu.simulation.scene import Scene
from tests.fakes import Motion, still, subject
from tests.physics.chain import FoldedStrip
from tests.physics.check import Case
from tests.physics.checks import (
    CHECKS,
    air,
    bending,
    bodies,
    determinism,
    friction,
    hysteresis,
    motion,
    orthotropy,
    refinement,
    stack,
    stretch,
    symmetry,
    tangle,
)
from tests.physics.findings import Findings, Row
from tests.physics.frictional_strip import residual_curvature, turned_strip
from tests.physics.manipulations import half_fold_target
from tests.physics.plate import falling, hanging
from tests.physics.references import catenary, hang_displacement, off_axis_stiffness, shear_sag
from tests.physics.report import run
from tests.physics.subject import Subject

Question = Callable[[Subject], Findings]


def failures(question: Question, motion: Motion) -> list[str]:
    """Quantities beyond their limits."""
    return [row.quantity for row in rows(question, subject(motion)) if row.passed is False]


def rows(question: Question, simulator: Subject) -> list[Row]:
    return run(Case("", question), simulator).rows


def falls(scene: Scene, time: float, factor: float = 1.0) -> np.ndarray:
    return scene.cloth.vertices - [0, 0, 0.5 * factor * scene.gravity * time**2]


def breathes(scene: Scene, time: float, drift: float = 0.0) -> np.ndarray:
    """Vibrates about the mean of its vertices' masses, which may drift."""
    mass = motion.masses(scene)
    arm = scene.cloth.vertices - mass @ scene.cloth.vertices / mass.sum()
    return scene.cloth.vertices + 0.01 * np.sin(20 * time) * arm + np.array([drift * time, 0, 0])


def opens(scene: Scene, time: float, factor: float = 1.0) -> np.ndarray:
    """Moves to and fro with a peak kinetic energy that is a share of the bending energy."""
    curvature, rate = 8.0, 30.0
    speed = np.sqrt(0.8 * factor * scene.material.bending_rigidity * curvature**2 / scene.material.areal_density)
    return scene.cloth.vertices + np.array([0, 0, speed / rate * np.sin(rate * time)])


def falls_in_air(scene: Scene, time: float, faster: float = 1.0) -> np.ndarray:
    start = scene.cloth.vertices
    tilt = float(np.arctan2(start[0, 2] - start[-1, 2], start[-1, 0] - start[0, 0]))
    across, along = falling(scene.material, tilt, scene.gravity)
    normal = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    slope = np.array([np.cos(tilt), 0.0, -np.sin(tilt)])
    return start - faster * across.distance(time) * normal + faster * along.distance(time) * slope


def swings_in_air(scene: Scene, time: float, slower: float = 1.0, drag: float = 1.0) -> np.ndarray:
    rest = scene.cloth.rest
    dragged = scene.material.model_copy(update={"air_drag_normal": drag * scene.material.air_drag_normal})
    angles = hanging(dragged, air.LENGTH, air.ANGLE, np.array([0.0, max(time / slower, 1e-9)]), scene.gravity)
    return np.column_stack([np.sin(angles[-1]) * rest[:, 0], rest[:, 1], -np.cos(angles[-1]) * rest[:, 0]])


def hangs(scene: Scene, factor: float = 1.0) -> np.ndarray:
    start = scene.cloth.vertices
    down = hang_displacement(-start[:, 2], 0.3, scene.material, scene.gravity)
    return start - np.column_stack([0 * down, 0 * down, factor * down])


def hangs_off_axis(scene: Scene, degrees: float) -> np.ndarray:
    start = scene.cloth.vertices
    stiffness = off_axis_stiffness(scene.material, np.radians(degrees))
    along = scene.material.model_copy(update={"stretch_stiffness": stiffness})
    return start - np.column_stack([0 * start[:, :2], hang_displacement(-start[:, 2], 0.3, along, scene.gravity)])


def stays_rolled(scene: Scene, looser: float = 1.0) -> np.ndarray:
    curvature = residual_curvature(scene.material, 30.0) / looser
    return motion.rolled(0.1, 0.04, hysteresis.SPACING / 2, curvature)[0].vertices


def turns(scene: Scene, time: float, memory: bool = True) -> np.ndarray:
    """The turned strip, in the shapes where its clamp stands; without memory it comes down as it went up."""
    start = scene.cloth.vertices
    rows = np.unique(scene.cloth.rest[:, 0])
    behind = 0.5 * (rows[1] - rows[0])
    free = float(-start[:, 2].min()) + behind
    stop = next((k for k, (when, _) in enumerate(hysteresis.CLAMPS) if time <= when + hysteresis.REST), 2)
    angles = [np.radians(angle) for _, angle in hysteresis.CLAMPS]
    known = _turned(scene.material.model_dump_json(), free, tuple(angles))
    shape = known[stop if memory or stop < 2 else 0]
    arc = np.linspace(0, free, len(shape))
    at = np.maximum(-start[:, 2] + behind, 0.0)
    reach, drop = (np.interp(at, arc, column) for column in shape.T)
    back = behind * np.array([np.cos(angles[stop]), np.sin(angles[stop])])
    return np.column_stack([reach - back[0], start[:, 1], back[1] - drop])


@cache
def _turned(material: str, free: float, angles: tuple[float, ...]) -> list[np.ndarray]:
    return turned_strip(Material.model_validate_json(material), free, angles, 9.81)


def shears(scene: Scene, factor: float = 1.0) -> np.ndarray:
    start = scene.cloth.vertices
    down = shear_sag(start[:, 0], 0.1, scene.material, scene.gravity)
    return start - np.column_stack([0 * down, 0 * down, factor * down])


def pulls(scene: Scene, factor: float = 1.0) -> np.ndarray:
    nu = factor * scene.material.poisson_ratio
    return scene.cloth.vertices * [1.01, 1 - 0.01 * nu, 1]


def sags(scene: Scene, factor: float = 1.0) -> np.ndarray:
    x, y, _ = scene.cloth.vertices.T
    curve, arc = catenary(0.4, 0.5), np.linspace(0, 0.5, 201)
    there = np.interp(x, arc, curve[:, 0]) + 0.25
    return np.column_stack([there, y, factor * np.interp(x, arc, curve[:, 1])])


def droops(scene: Scene, behind: float = 0.0, softer: float = 1.0) -> np.ndarray:
    """The heavy elastica, clamped `behind` the line x = 0, on both sides of it."""
    x, y, _ = scene.cloth.vertices.T
    length = 0.1 + behind
    weight = scene.material.areal_density * scene.gravity
    curve = length * cantilever(softer * weight * length**3 / scene.material.bending_rigidity)
    arc = np.linspace(0, length, len(curve))
    free = np.sign(x) * (np.interp(np.abs(x) + behind, arc, curve[:, 0]) - behind)
    return np.column_stack([free, y, -np.interp(np.abs(x) + behind, arc, curve[:, 1])])


def loops(scene: Scene, higher: float = 1.0) -> np.ndarray:
    plan = scene.cloth.rest
    row = np.diff(np.unique(plan[:, 0]))[0]
    nodes = FoldedStrip(0.4 - 2 * row, scene.material.bending_length, 0.001, 0.004).solve(100)
    arc = np.linspace(row, 0.4 - row, len(nodes))
    x, z = (np.interp(plan[:, 0], arc, nodes[:, k]) for k in range(2))
    return np.column_stack([x + row, plan[:, 1], higher * z])


def slides(scene: Scene, time: float, rougher: float = 1.0, creep: float = 0.0) -> np.ndarray:
    assert scene.table
    tilt = scene.table.tilt
    pull = np.sin(tilt) - rougher * scene.material.friction_table * np.cos(tilt)
    way = 0.5 * max(0.0, scene.gravity * pull) * time**2 + creep * time
    return scene.cloth.vertices + way * np.array([np.cos(tilt), 0, -np.sin(tilt)])


def layers_slide(scene: Scene, time: float, rougher: float = 1.0) -> np.ndarray:
    """All but the lowest layer slide together."""
    assert scene.table
    tilt = scene.table.tilt
    over = scene.cloth.vertices @ [np.sin(tilt), 0, np.cos(tilt)] > scene.material.thickness
    pull = np.sin(tilt) - rougher * scene.material.friction_cloth * np.cos(tilt)
    way = over * 0.5 * max(0.0, scene.gravity * pull) * time**2
    return scene.cloth.vertices + way[:, None] * np.array([np.cos(tilt), 0, -np.sin(tilt)])


def rests(scene: Scene, time: float, squeezed: float = 1.0, creep: float = 0.0) -> np.ndarray:
    return scene.cloth.vertices * [1, 1, squeezed] + [creep * time, 0, 0]


def pokes(scene: Scene, time: float) -> np.ndarray:
    """A vertex of the upper layer goes through the lower one."""
    out = scene.cloth.vertices.copy()
    out[np.argmax(out[:, 2] > scene.material.thickness) + 60, 2] = -0.01
    return out


def sinks(scene: Scene, time: float) -> np.ndarray:
    """All layers come to lie in one plane, as without contact."""
    return scene.cloth.vertices * [1, 1, 0] + [0, 0, 0.0005]


def rides(scene: Scene, time: float, grip: float = 1.0) -> np.ndarray:
    box = scene.bodies[0]
    way = box.path(np.array([time]))[0][0, 0] - box.positions[0, 0]
    return scene.cloth.vertices + np.array([min(way, 0.5 * grip * box.friction * scene.gravity * time**2), 0, 0])


def is_dragged(scene: Scene, time: float, grip: float = 1.0) -> np.ndarray:
    table, _, finger = (body.friction for body in scene.bodies)
    return scene.cloth.vertices + np.array([0, 0.5 * grip * scene.gravity * (0.3 * finger - 0.7 * table) * time**2, 0])


def slips(scene: Scene, degrees: float, steeper: float = 1.0) -> np.ndarray:
    """Both straight parts stretched so that their tensions are as 1 to e^(mu theta)."""
    arc = scene.cloth.rest[:, 0]
    start = scene.cloth.vertices
    ratio = np.exp(steeper * scene.bodies[0].friction * np.radians(degrees))
    moved = start.copy()
    for end, tension in ((0.0, 1.0), (arc.max(), ratio)):
        stretch = brentq(lambda x, t=tension: 150.0 * x * (x * x - 1.0) - t, 1.0, 2.0)
        part = np.abs(arc - end) < bodies.FREE
        tip = start[np.isclose(arc, end)].mean(axis=0) * [1, 0, 1]
        moved[part] += (stretch - 1.0) * (start[part] * [1, 0, 1] - tip)
    return moved


def lies_on_sphere(scene: Scene, higher: float = 4e-4, aside: float = 0.0) -> np.ndarray:
    ball = scene.bodies[0]
    away = scene.cloth.vertices - ball.positions[0]
    far = ball.radius + 0.5 * scene.material.thickness + higher
    return ball.positions[0] + away * (far / np.linalg.norm(away, axis=1))[:, None] + np.array([aside, 0, 0])


def stops(scene: Scene, time: float) -> np.ndarray:
    raise SimulationError("the cloth was stretched to 2.00 times its length")


PAIRS: dict[str, tuple[Question, Motion, Motion]] = {
    "fall": (motion.free_fall, falls, partial(falls, factor=1.002)),
    "momentum": (motion.momentum, breathes, partial(breathes, drift=1e-5)),
    "spring": (motion.spring, opens, partial(opens, factor=1.4)),
    "spring that stays shut": (motion.spring, opens, partial(opens, factor=0.4)),
    "swing": (motion.swing, falls, partial(falls, factor=1.01)),
    "hang": (
        partial(stretch.hang, fabric="woven", layout="irregular"),
        still(hangs),
        still(partial(hangs, factor=1.02)),
    ),
    "air-fall": (partial(air.fall, tilt=0.5), falls_in_air, partial(falls_in_air, faster=1.003)),
    "air-swing": (
        partial(air.swing, air=air.SWINGS["added mass, linear and quadratic drag"]),
        swings_in_air,
        partial(swings_in_air, slower=1.01),
    ),
    "air-swing that decays": (
        partial(air.swing, air=air.SWINGS["added mass, linear drag"]),
        swings_in_air,
        partial(swings_in_air, drag=1.05),
    ),
    "carried": (partial(bodies.carried, mu=0.5), rides, partial(rides, grip=1.04)),
    "dragged": (partial(bodies.dragged, mu=1.0, table=0.1), is_dragged, partial(is_dragged, grip=1.1)),
    "capstan": (
        partial(bodies.capstan, mu=0.5, degrees=120.0),
        still(partial(slips, degrees=120.0)),
        still(partial(slips, degrees=120.0, steeper=1.1)),
    ),
    "obstacles": (
        partial(bodies.draped, obstacle="sphere"),
        still(lies_on_sphere),
        still(partial(lies_on_sphere, higher=-3e-4)),
    ),
    "obstacles that are asymmetric": (
        partial(bodies.draped, obstacle="sphere"),
        still(lies_on_sphere),
        still(partial(lies_on_sphere, aside=1e-3)),
    ),
    "obstacles that throw": (partial(bodies.dropped, obstacle="corner"), falls, partial(falls, factor=1.01)),
    "shear": (partial(stretch.shear, layout="staggered"), still(shears), still(partial(shears, factor=1.03))),
    "pull": (partial(stretch.pull, layout="staggered"), still(pulls), still(partial(pulls, factor=1.1))),
    "catenary": (stretch.hands, still(sags), still(partial(sags, factor=1.02))),
    "cantilever": (
        partial(bending.both_sides, gamma=10.0, layout="irregular"),
        still(droops),
        still(partial(droops, softer=1.1)),
    ),
    "clamp": (partial(bending.clamped, gamma=10.0, spacing=0.01), still(partial(droops, behind=0.005)), still(droops)),
    "crease": (
        partial(bending.crease, bending_length=0.037, spacing=0.02),
        still(loops),
        still(partial(loops, higher=1.1)),
    ),
    "woven-shear": (
        partial(stretch.shear, layout="staggered", plain=orthotropy.WOVEN),
        still(shears),
        still(partial(shears, factor=1.03)),
    ),
    "off-axis": (
        partial(orthotropy.pull, degrees=30),
        still(partial(hangs_off_axis, degrees=30)),
        still(partial(hangs_off_axis, degrees=35)),
    ),
    "bias-droop": (
        partial(orthotropy.droop, degrees=45),
        still(partial(droops, softer=1 / 0.6)),
        still(partial(droops, softer=1 / 0.5)),
    ),
    "roll": (partial(hysteresis.unroll, curvature=30.0), still(stays_rolled), still(partial(stays_rolled, looser=1.1))),
    "turn": (partial(hysteresis.turn, gamma=10.0), turns, partial(turns, memory=False)),
    "incline": (partial(friction.on_table, mu=0.6), slides, partial(slides, rougher=1.02)),
    "incline that creeps": (partial(friction.on_table, mu=0.6), slides, partial(slides, creep=2e-4)),
    "layers": (partial(friction.on_cloth, count=2), layers_slide, partial(layers_slide, rougher=1.1)),
    "stack": (partial(stack.at_rest, count=4, duration=2.0), rests, partial(rests, squeezed=0.8)),
    "stack that creeps": (partial(stack.at_rest, count=2, duration=2.0), rests, partial(rests, creep=1e-3)),
    "drag": (partial(tangle.press_and_drag, speed=1.0, press=0.0), rests, pokes),
    "drag without contact": (partial(tangle.press_and_drag, speed=1.0, press=0.0), rests, sinks),
}

LONG = ("obstacles", "air-swing", "air-swing that decays", "obstacles that are asymmetric")
"""Checks whose questions are asked of several meshes for many swings, or of many bodies: 15 to 25 s each."""
CASES = [pytest.param(name, marks=pytest.mark.slow if name in LONG else ()) for name in PAIRS]


@pytest.mark.parametrize("name", CASES)
def test_check_passes_on_the_right_answer(name: str) -> None:
    question, right, _ = PAIRS[name]
    judged = [q for q in failures(question, right) if "order" not in q]  # an exact answer has no order
    assert judged == []


@pytest.mark.parametrize("name", CASES)
def test_check_fails_on_a_wrong_answer(name: str) -> None:
    question, _, wrong = PAIRS[name]
    assert failures(question, wrong)


def test_order_is_one_when_the_error_halves_with_the_spacing() -> None:
    (row, _) = bending._order(subject(rests), "", [0.04, 0.02, 0.01])
    assert isinstance(row, Row) and row.passed and row.got == pytest.approx(1.0)
    (row, _) = bending._order(subject(rests), "", [0.04, 0.03, 0.02])
    assert isinstance(row, Row) and row.passed is False


def test_folds_that_cross_or_stop_are_counted() -> None:
    def crosses(scene: Scene, time: float) -> np.ndarray:
        folded = scene.cloth.vertices.copy()
        far = folded[:, 0] > 0.15
        folded[far] = folded[far] * [-1, 1, 1] + [0.3, 0.003, 0.0]
        folded[:, 2] += 0.01 * np.sin(40 * folded[:, 0]) * np.where(far, 1, -1)
        return folded

    question = partial(tangle.random_folds, seeds=range(2), fast=True, spacing=0.02)
    assert failures(question, rests) == []
    assert failures(question, crosses) == ["folds of 2 with a crossing in any frame"]

    assert failures(question, stops) == ["folds of 2 that ended in an error"]


@pytest.mark.parametrize("change", ["turned and shifted", "mirrored", "renumbered"])
def test_symmetry_notices_a_simulator_with_a_favourite_direction(change: str) -> None:
    def drifts(scene: Scene, time: float) -> np.ndarray:
        first = scene.cloth.vertices[0, 1]
        return scene.cloth.vertices + time * np.array([1e-4, 1e-4 + 1e-4 * first, -0.5])

    question = partial(symmetry.changed, change=symmetry.CHANGES[change])
    assert failures(question, falls) == []
    assert failures(question, drifts)


def test_a_distance_after_contact_is_explained_and_not_judged() -> None:
    """Of 5 mm at one vertex at 0.5 s, and 1 mm everywhere at the end."""
    apart = np.zeros((61, 4))
    apart[30, 2] = 0.005
    apart[-1] = 0.001
    said = symmetry._explained(apart, 60.0)
    assert said.startswith("one vertex, after 0.5 s; all of them then 0.0013 m on average, at the end 0.001 m")
    assert "not judged" in said


def test_determinism_notices_one_bit() -> None:
    calls = [0]

    def forgets(scene: Scene, time: float) -> np.ndarray:
        calls[0] += 1
        return scene.cloth.vertices * (1 + 1e-15 * calls[0])

    assert failures(determinism.again, rests) == []
    assert failures(determinism.again, forgets)
    assert failures(determinism.batch, rests) == []
    assert failures(determinism.batch, forgets)


def test_refinement_notices_another_order() -> None:
    def ends(scene: Scene, shuffled: bool) -> np.ndarray:
        """Somewhere that depends on the path of the hands, and on the mesh if shuffled."""
        reach = scene.grippers[0].displacements[-1, 0] * (len(scene.cloth.vertices) if shuffled else 1)
        target = half_fold_target(scene.cloth.rest[:, :2], scene.material.thickness)
        return target + np.array([0, 0, 0.02 + 0.02 * np.sin(50 * reach)])

    question = partial(refinement.half_the_mesh, spacing=0.04, count=12)
    assert failures(question, still(partial(ends, shuffled=False))) == []
    assert failures(question, still(partial(ends, shuffled=True)))


def test_a_simulation_that_fails_is_a_failed_row() -> None:
    (row,) = rows(motion.free_fall, subject(stops))
    assert row.passed is False and "2.00" in row.note


def test_no_check_is_left_without_a_test() -> None:
    tested = {name.split()[0] for name in PAIRS} | {"energy", "folds", "symmetry", "determinism", "refinement"}
    assert set(CHECKS) <= tested
