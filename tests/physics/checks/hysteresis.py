"""Checks of bending hysteresis: a roll that is released, and a heavy strip that is bent by turning its clamp."""

from __future__ import annotations

from functools import partial

import numpy as np

from tatamu.simulation.material import GRAVITY, Material
from tatamu.simulation.mesh.meshing import ROW
from tatamu.simulation.scene import Cloth, Gripper, Scene
from tests.physics.check import Case, Check
from tests.physics.checks.bending import LENGTH, WIDTH, chord_of, strip_material, tip_of
from tests.physics.checks.motion import rolled
from tests.physics.findings import Curve, Figure, Findings, absolute
from tests.physics.frictional_strip import loop, residual_curvature, turned_strip
from tests.physics.meshes import staggered
from tests.physics.scenes import hanging, raised
from tests.physics.subject import Subject

FRICTION = 10.0
"""Ratio HB / B of the strips [1/m]: frictional moment of bending HB divided by bending rigidity B. Cotton has about 50,
and worsteds have 20 (Matsudaira et al. 2015)."""
SPACING = 0.01
ROLLS = (1.0, 30.0)
"""Initial curvatures of two rolled sheets [1/m]. The first is below the curvatures at which the friction of bending
yields, and the second far above them. At an initial curvature between these two, the remaining curvature depends on
whether the ends or the middle of the roll open first."""
ROLL_DRAG = 60.0
"""Air drag of the roll [N s/m^3], which is above critical damping."""
TURNING_DRAG = 1.0
"""Air drag of the strip whose clamp turns [N s/m^3]. The strip moves so slowly that this drag is a hundredth of the
strip's weight."""
CLAMPS = ((5.0, 45.0), (11.0, 0.0), (17.0, 45.0))
"""Times at which the clamp stops [s], and its angles below the horizontal at these times [degrees]. At the start, the
angle is 90 degrees."""
REST = 1.0
"""Time for which the clamp rests after each turn [s]."""


def frictional(plain: Material) -> Material:
    """Return a copy of a material, with friction of bending added."""
    return Material.model_validate(plain.model_dump() | {"bending_hysteresis": FRICTION * plain.bending_rigidity})


def unroll(subject: Subject, curvature: float) -> Findings:
    """Check a rolled sheet that is released without gravity. The sheet opens until its friction of bending stops it."""
    fabric = Material(areal_density=0.2, stretch_stiffness=300.0, bending_rigidity=1e-4, air_drag=ROLL_DRAG)
    material = frictional(fabric)
    cloth, _ = rolled(0.1, 0.04, SPACING / 2, curvature)
    scene = Scene(cloth=cloth, material=material, gravity=0.0, duration=4.0)
    end = subject.simulate(scene).positions[-1]
    got = _mean_curvature(cloth.rest[:, 0], end)
    wanted = residual_curvature(material, curvature)
    yield absolute("curvature that stays [1/m]", wanted, got, subject.limit("residual curvature"), "1/m")
    path = np.concatenate([np.linspace(0, curvature, 61), np.linspace(curvature, wanted, 61)])
    moments = 1e3 * loop(material, path.tolist())
    yield Curve("loop", f"from {curvature:g} / m", path, moments, reference=True)
    yield Curve("loop", subject.name, np.array([got]), np.array([0.0]))


def _mean_curvature(along: np.ndarray, points: np.ndarray) -> float:
    """Return the mean curvature of the middle of a strip [1/m].

    `along` is the unstrained distance of each vertex from the strip's end [m].
    """
    rows = np.unique(along)
    centres = np.array([points[along == row].mean(axis=0) for row in rows])
    links = np.diff(centres, axis=0)
    first, last = len(links) // 4, len(links) - 1 - len(links) // 4
    cosine = links[first] @ links[last] / (np.linalg.norm(links[first]) * np.linalg.norm(links[last]))
    middles = 0.5 * (rows[1:] + rows[:-1])
    return float(np.arccos(np.clip(cosine, -1.0, 1.0)) / (middles[last] - middles[first]))


def turn(subject: Subject, gamma: float) -> Findings:
    """Check a hanging strip whose clamp turns slowly up until it is level, and down again."""
    plain = strip_material(gamma, LENGTH)[0]
    material = frictional(plain).model_copy(update={"air_drag": TURNING_DRAG})
    plan, faces = staggered(LENGTH + 2 * ROW * SPACING, WIDTH, SPACING)
    rows = np.unique(plan[:, 0])
    along = plan[:, 0] - rows[2]  # three rows of vertices are held
    hands = [_turning(np.flatnonzero(plan[:, 0] == row), row - rows[2]) for row in rows[:3]]
    cloth = Cloth(vertices=hanging(np.column_stack([along, plan[:, 1]])), faces=faces, rest_vertices=raised(plan))
    scene = Scene(cloth=cloth, material=material, grippers=hands, duration=CLAMPS[-1][0] + REST, frame_rate=20)
    rollout = subject.simulate(scene)
    behind = 0.5 * (rows[1] - rows[0])  # the clamp is half a cell behind the last held row
    free = float(along.max()) + behind
    wanted = turned_strip(material, free, [np.radians(angle) for _, angle in CLAMPS], GRAVITY)
    without = turned_strip(plain, free, [np.radians(angle) for _, angle in CLAMPS], GRAVITY)
    for (time, angle), shape, elastic in zip(CLAMPS, wanted, without, strict=True):
        frame = round((time + REST) * scene.frame_rate)
        back = behind * np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
        tip = tip_of(along, rollout.positions[frame][:, ::2] * [1, -1], float(along.max())) + back
        right, got, plainly = (chord_of(p) for p in (shape[-1], tip, elastic[-1]))
        note = f"without hysteresis {plainly:.1f}"
        limit = subject.limit("frictional chord")
        yield absolute(f"chord, clamp at {angle:g} degrees [deg]", right, got, limit, "deg", note)


def _turning(vertices: np.ndarray, distance: float) -> Gripper:
    """Return a hand that holds one row of vertices in a clamp that turns.

    The clamp turns about the last held row. The held row is at the distance `distance` [m] from the last held row.
    """
    knots = np.linspace(0.0, CLAMPS[-1][0] + REST, 401)
    turns = [0.0] + [time + rest for time, _ in CLAMPS for rest in (0.0, REST)]
    angles = [90.0] + [angle for _, angle in CLAMPS for _ in (0, 1)]
    at = np.radians(np.interp(knots, turns, angles))
    moved = distance * np.column_stack([np.cos(at), 0 * at, 1.0 - np.sin(at)])
    return Gripper(vertices=vertices.tolist(), times=knots.tolist(), displacements=moved)


CHECKS = (
    Check(
        "roll",
        "Roll that does not open",
        "moment of Prandtl's elements, zero where it stays",
        tuple(
            Case(f"from {curvature:g} / m", partial(unroll, curvature=curvature), quick=curvature > 10.0)
            for curvature in ROLLS
        ),
        {"loop": Figure("Moment against curvature", "curvature [1/m]", "moment per width [mN]")},
    ),
    Check(
        "turn",
        "Heavy strip with hysteresis, its clamp turned up and down",
        "chain of joints with the same moments",
        (Case("Γ = 10", partial(turn, gamma=10.0)),),
    ),
)
