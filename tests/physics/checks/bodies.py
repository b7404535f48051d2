"""Checks of cloth on rigid bodies: friction on bodies at rest and in motion, penetration, symmetry and energy.

The capstan check has a strip around a cylinder. The strip touches the cylinder over an angle theta. T0 and T1 are the
tensions per width on both sides, and mu is the friction coefficient. When the strip slips:

    T1 / T0 = e^(mu theta)

This is the formula of Euler and Eytelwein, which holds for any radius. Both ends of the strip are held, and both are
moved along the strip with the same speed. The tensions follow from the strains of the straight parts.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from tatamu.base.errors import SimulationError
from tatamu.simulation.body import Body
from tatamu.simulation.clearance import distances
from tatamu.simulation.material import GRAVITY, Material
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Cloth, Gripper, Scene
from tests.physics.check import Case, Check
from tests.physics.checks.friction import threshold
from tests.physics.checks.motion import masses, mechanical
from tests.physics.findings import Curve, Figure, Findings, relative, small
from tests.physics.meshes import mirrored, right, staggered
from tests.physics.scenes import flat, held, raised
from tests.physics.subject import Subject

FABRIC = Material(areal_density=0.2, stretch_stiffness=300.0, bending_rigidity=1e-6, poisson_ratio=0.0)
DRAPED = FABRIC.model_copy(update={"bending_rigidity": 1e-4, "air_drag": 2.0})
"""Material with air drag, so that its cloth soon comes to rest."""
HALF = 0.5 * FABRIC.thickness
RADIUS = 0.03
"""Radius of the cylinder [m]."""
FREE = 0.1
"""Length of each straight part of the strip around the cylinder [m]."""
ROW = 0.005
STRAIN = 0.02
"""Strain of the strip around the cylinder before the strip is moved [-]."""
PULL = 0.1
"""Time after which the strip around the cylinder is fully stretched and starts to move [s]."""
SPEED = 0.05
"""Speed at which the strip is moved around the cylinder [m/s]."""
ALONG_Y = [np.sqrt(0.5), -np.sqrt(0.5), 0.0, 0.0]
"""Orientation that rotates the z axis to the y axis."""
TIPPED = 0.5 * np.arccos(np.sqrt(1.0 / 3.0))
ON_A_CORNER = [np.cos(TIPPED), np.sin(TIPPED) * np.sqrt(0.5), -np.sin(TIPPED) * np.sqrt(0.5), 0.0]
"""Orientation in which the corner (1, 1, 1) of a cube is its highest point."""
SMALL = 0.06
"""Half the side of a cloth that hangs down on all sides of a sphere without buckling [m]. A larger cloth would buckle,
and would not stay symmetric for long."""
POKE = 0.6
"""Speed of a finger that is pushed into cloth [m/s]."""
SLIPPED = 1e-3
"""Largest displacement of a strip of cloth relative to the box on which it is carried [m]. If the displacement is
larger, the strip counts as left behind."""


def strip_around(mu: float, angle: float) -> Scene:
    """Return a scene in which a strip is stretched around a cylinder and then pulled around the cylinder.

    The cylinder lies along y, and the strip touches it over an angle [rad].
    """
    radius = RADIUS + HALF
    length = radius * angle + 2 * FREE
    plan, faces = right(length, 0.02, ROW)
    arc = plan[:, 0] - 0.5 * length
    turned = np.clip(arc / radius, -0.5 * angle, 0.5 * angle)
    beyond = arc - radius * turned
    points = np.column_stack(
        [
            radius * np.sin(turned) + beyond * np.cos(turned),
            plan[:, 1] - 0.01,
            radius * np.cos(turned) - beyond * np.sin(turned),
        ]
    )
    grippers = []
    for side in (-1.0, 1.0):
        end = np.flatnonzero(np.isclose(plan[:, 0], 0.0 if side < 0 else length))
        ahead = np.array([np.cos(0.5 * angle), 0.0, -side * np.sin(0.5 * angle)])  # along the arc of contact
        stretched = 0.5 * STRAIN * length * side * ahead
        moved = stretched + 0.4 * FREE * ahead
        times = [0.0, PULL, PULL + 0.4 * FREE / SPEED]
        grippers.append(Gripper(vertices=end.tolist(), times=times, displacements=[np.zeros(3), stretched, moved]))
    cylinder = Body(
        name="cylinder",
        shape="capsule",
        size=[RADIUS, 0.05],
        friction=mu,
        positions=[[0, 0, 0]],
        orientations=[ALONG_Y],
    )
    return Scene(
        cloth=Cloth(vertices=points, faces=faces, rest_vertices=raised(plan)),
        material=FABRIC,
        grippers=grippers,
        bodies=[cylinder],
        gravity=0.0,
        duration=PULL + 0.4 * FREE / SPEED,
        frame_rate=100,
    )


def tensions(scene: Scene, rollout: Rollout) -> np.ndarray:
    """Return the tension per width of both straight parts of a strip around a cylinder [N/m], shape (f, 2).

    Each row is for one of the f frames.
    """
    along = scene.cloth.rest[:, 0]
    length = along.max()
    found = []
    for near, far in ((0.01, 0.04), (length - 0.01, length - 0.04)):
        rows = [np.unique(along)[np.argmin(np.abs(np.unique(along) - x))] for x in (near, far)]
        ends = [rollout.positions[:, np.isclose(along, row)].mean(axis=1) for row in rows]
        stretch = np.linalg.norm(ends[1] - ends[0], axis=1) / abs(rows[1] - rows[0])
        found.append(0.5 * scene.material.stretch_stiffness * stretch * (stretch**2 - 1.0))
    return np.column_stack(found)


def capstan(subject: Subject, mu: float, degrees: float) -> Findings:
    """Check the ratio of the tensions on both sides of a cylinder around which a strip slips."""
    scene = strip_around(mu, np.radians(degrees))
    rollout = subject.simulate(scene)
    pulled = tensions(scene, rollout)
    late = rollout.times > PULL + 0.2 * FREE / SPEED
    got = float(pulled[late, 1].mean() / pulled[late, 0].mean())
    wanted = float(np.exp(mu * np.radians(degrees)))
    yield relative("T1 / T0", wanted, got, subject.limit("capstan"), f"{degrees:g} deg, μ = {mu:g}")
    yield Curve("capstan", f"μ = {mu:g}", np.array([degrees]), np.array([got]))
    angles = np.linspace(0.0, 200.0, 41)
    yield Curve("capstan", f"e^({mu:g} θ)", angles, np.exp(mu * np.radians(angles)), reference=True)


def on_moving_box(mu: float, acceleration: float) -> Scene:
    """Return a scene in which a strip of cloth lies on a box that moves with a constant acceleration [m/s^2]."""
    mesh = right(0.1, 0.04, 0.02)
    times = np.arange(501) * 1e-3
    way = 0.5 * acceleration * times**2
    positions = np.column_stack([way + 0.05, 0 * way + 0.02, 0 * way - 0.01])
    box = Body(name="box", shape="box", size=[0.2, 0.1, 0.01], friction=mu, times=times.tolist(), positions=positions)
    return Scene(cloth=flat(mesh, HALF), material=FABRIC, bodies=[box], duration=0.5, frame_rate=100)


def left_behind(subject: Subject, mu: float, acceleration: float) -> float:
    """Return the distance by which a strip of cloth stays behind the moving box on which it lies [m].

    The distance is measured half a second after the box starts to move.

    Args:
        subject: The simulator that is checked.
        mu: Friction coefficient of strip and box.
        acceleration: Acceleration of the box [m/s^2].
    """
    scene = on_moving_box(mu, acceleration)
    moved = subject.simulate(scene).positions[-1] - scene.cloth.vertices
    return float(scene.bodies[0].path(np.array([0.5]))[0][0, 0] - 0.05 - moved[:, 0].mean())


def carried(subject: Subject, mu: float) -> Findings:
    """Check a strip of cloth that lies on an accelerated box.

    Two numbers are compared with theory. The first number is the acceleration at which the strip starts to slip, mu g,
    where g is the acceleration of gravity. The second number is the distance by which the strip slips at 1.1 times this
    acceleration.
    """
    wanted = mu * GRAVITY
    found = threshold(lambda a: left_behind(subject, mu, a) > SLIPPED, wanted, 0.1 * wanted, 0.002 * wanted)
    yield relative("acceleration at which it is left behind [m/s²]", wanted, found, subject.limit("carried"))
    slip = 0.5 * 0.1 * wanted * 0.25
    yield relative("way behind at 1.1 μ g [m]", slip, left_behind(subject, mu, 1.1 * wanted), subject.limit("carried"))


def drawn_out(mu: float, table: float) -> Scene:
    """Return a scene with a cloth on three boxes, from under which the middle box is pulled out.

    The boxes have level tops. The middle box, a long finger, is moved along y.
    """
    mesh = right(0.2, 0.1, 0.02)
    fixed = [
        Body(name=side, shape="box", size=[0.2, 0.5, 0.01], friction=table, positions=[[x, 0.05, -0.01]])
        for side, x in (("left", -0.13), ("right", 0.33))
    ]
    finger = Body(
        name="finger",
        shape="box",
        size=[0.03, 0.8, 0.01],
        friction=mu,
        times=[0.0, 0.2],
        positions=[[0.1, -0.3, -0.01], [0.1, 0.1, -0.01]],
    )
    return Scene(cloth=flat(mesh, HALF), material=FABRIC, bodies=[*fixed, finger], duration=0.2, frame_rate=100)


def dragged(subject: Subject, mu: float, table: float) -> Findings:
    """Check how far a finger that is pulled out from under a cloth drags the cloth along.

    The acceleration of the cloth is a = g (phi mu - (1 - phi) mu_table). g is the acceleration of gravity, and phi is
    the fraction of the cloth's mass over the finger. The finger has the friction coefficient mu, and the other boxes
    have the friction coefficient mu_table.
    """
    scene = drawn_out(mu, table)
    under = np.abs(scene.cloth.vertices[:, 0] - 0.1) < 0.03
    share = masses(scene)[under].sum() / masses(scene).sum()
    wanted = 0.5 * GRAVITY * (share * mu - (1.0 - share) * table) * 0.2**2
    moved = subject.simulate(scene).positions[-1] - scene.cloth.vertices
    got = float(masses(scene) @ moved[:, 1] / masses(scene).sum())
    yield relative("way that it is dragged [m]", float(wanted), got, subject.limit("dragged"))


OBSTACLES = {
    "sphere": Body(name="sphere", shape="sphere", size=[0.1], positions=[[0, 0, -0.1]]),
    "cylinder": Body(
        name="cylinder", shape="capsule", size=[0.02, 0.2], positions=[[0, 0, -0.02]], orientations=[ALONG_Y]
    ),
    "finger": Body(name="finger", shape="box", size=[0.01, 0.05, 0.004], positions=[[0, 0, -0.004]]),
    "corner": Body(
        name="corner",
        shape="box",
        size=[0.05, 0.05, 0.05],
        positions=[[0, 0, -0.05 * np.sqrt(3.0)]],
        orientations=[ON_A_CORNER],
    ),
}
"""Bodies on which a cloth falls, by name. Their highest point is the origin."""


def over(obstacle: str, height: float, duration: float, side: float = 0.1) -> Scene:
    """Return a scene with a square cloth that falls on an obstacle. The cloth is symmetric in x and y.

    `side` is half of the length of the cloth's sides [m].
    """
    quarter = right(side, side, 0.2 * side)
    half = mirrored(quarter)
    plan, faces = mirrored((half[0][:, ::-1], half[1][:, ::-1]))
    cloth = flat((plan, faces), height + HALF)
    return Scene(cloth=cloth, material=DRAPED, bodies=[OBSTACLES[obstacle]], duration=duration, frame_rate=100)


def penetration(scene: Scene, points: np.ndarray) -> float:
    """Return how deep a cloth is in a body, in thicknesses of the cloth [-].

    The result is 0 if the cloth rests on the body, or is farther away.
    """
    gap = distances(
        scene.bodies[0], points, scene.cloth.faces, scene.duration, below=0.45 * scene.material.thickness
    ).min()
    return float(max(0.0, 0.5 - gap / scene.material.thickness))


def draped(subject: Subject, obstacle: str) -> Findings:
    """Check the penetration of a cloth into an obstacle, at rest and during the motion."""
    scene = over(obstacle, 0.0, 1.5, SMALL if obstacle == "sphere" else 0.1)
    rollout = subject.simulate(scene)
    limit = subject.limit("penetration")
    yield small("penetration at rest / thickness", penetration(scene, rollout.positions[-1]), limit, "-")
    worst = max(penetration(scene, points) for points in rollout.positions)
    yield small("penetration in any frame / thickness", worst, None, "-")
    if obstacle == "sphere":
        yield small("asymmetry [mm]", 1e3 * asymmetry(scene, rollout.positions[-1]), subject.limit("drape"), "mm")


def asymmetry(scene: Scene, points: np.ndarray) -> float:
    """Return the largest deviation of a cloth from mirror symmetry [m].

    The mirror planes are x = 0 and y = 0. Each vertex is compared with the mirror image of the vertex on the opposite
    side.
    """
    start = scene.cloth.vertices
    worst = 0.0
    for mirror in ([-1.0, 1.0, 1.0], [1.0, -1.0, 1.0]):
        apart = np.linalg.norm(start[:, None] * mirror - start[None], axis=2)
        partner = np.argmin(apart, axis=1)
        worst = max(worst, float(np.linalg.norm(points[partner] - points * mirror, axis=1).max()))
    return worst


def dropped(subject: Subject, obstacle: str) -> Findings:
    """Check that a cloth that falls on an obstacle gains no energy."""
    scene = over(obstacle, 0.05, 0.6)
    undamped = scene.material.model_copy(update={"air_drag": 0.0})
    scene = scene.model_copy(update={"material": undamped})
    energy = mechanical(scene, subject.simulate(scene))
    scale = float(masses(scene).sum()) * scene.gravity * 0.05
    yield small("energy above the start / m g h", max(0.0, float(energy.max()) / scale), subject.limit("energy"), "-")


def poked(seed: int) -> Scene:
    """Return a scene with a limp cloth that is held at two sides, and a thin finger.

    The finger moves around the cloth and is pushed into the cloth, at 0.6 m/s.
    """
    random = np.random.default_rng(seed)
    plan, faces = staggered(0.16, 0.16, float(random.choice([0.013, 0.026])))
    sides = np.flatnonzero((plan[:, 0] < 1e-9) | (plan[:, 0] > plan[:, 0].max() - 1e-9))
    points = np.column_stack([0.85 * (plan[:, 0] - 0.08), plan[:, 1] - 0.08, -0.3 * plan[:, 0] * (0.16 - plan[:, 0])])
    cloth = Cloth(vertices=points, faces=faces, rest_vertices=raised(plan))
    stops = random.uniform(-0.06, 0.06, (5, 3)) * [0.5, 1.0, 0.7]  # away from the held sides, which cannot give way
    stops[0, 2] = 0.06 * random.choice([-1.0, 1.0])
    times = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(stops, axis=0), axis=1) / POKE)])
    turn = random.normal(size=4)
    shape, size = [("box", [0.004, 0.01, 0.02]), ("capsule", [0.004, 0.02]), ("sphere", [0.004])][random.integers(3)]
    finger = Body(
        name="finger",
        shape=shape,
        size=size,
        friction=float(random.uniform(0.0, 1.0)),
        times=times.tolist(),
        positions=stops,
        orientations=np.tile(turn / np.linalg.norm(turn), (len(times), 1)),
    )
    limp = FABRIC.model_copy(update={"bending_rigidity": 2e-6})
    return Scene(
        cloth=cloth, material=limp, grippers=[held(sides)], bodies=[finger], duration=times[-1] + 0.1, frame_rate=100
    )


def deepest_poke(simulate: Callable[[Scene], Rollout], seed: int) -> float | None:
    """Return the largest depth of a finger in a cloth, in thicknesses of the cloth, in the scene `poked`.

    The result is None if the simulation fails.
    """
    scene = poked(seed)
    try:
        rollout = simulate(scene)
    except SimulationError:
        return None
    gaps = [
        distances(scene.bodies[0], points, scene.cloth.faces, time, below=0.45 * scene.material.thickness).min()
        for points, time in zip(rollout.positions, rollout.times, strict=True)
    ]
    return float(max(0.0, 0.5 - min(gaps) / scene.material.thickness))


CHECKS = (
    Check(
        "capstan",
        "A strip around a cylinder",
        "slips where T1 / T0 > e^(μ θ)",
        tuple(
            Case(f"{degrees:g} deg, μ = {mu:g}", partial(capstan, mu=mu, degrees=degrees), quick=degrees == 120.0)
            for mu in (0.2, 0.5)
            for degrees in (60.0, 120.0, 180.0)
        ),
        {"capstan": Figure("Tensions of a strip that slips around a cylinder", "angle [deg]", "T1 / T0")},
    ),
    Check(
        "carried",
        "A strip on a box that moves off",
        "is carried below μ g, and left behind above",
        tuple(Case(f"μ = {mu:g}", partial(carried, mu=mu), quick=mu == 0.5) for mu in (0.2, 0.5)),
    ),
    Check(
        "dragged",
        "A finger drawn out from under a cloth",
        "a = g (φ μ - (1 - φ) μ_table), φ the share of the weight on the finger",
        tuple(
            Case(f"μ = {mu:g}, the rest {table:g}", partial(dragged, mu=mu, table=table))
            for mu, table in ((1.0, 0.1), (0.6, 0.0))
        ),
    ),
    Check(
        "obstacles",
        "Cloth over bodies",
        "rests half a thickness from them, as symmetric as it began, with no more energy",
        (
            *(Case(f"{name}, at rest", partial(draped, obstacle=name)) for name in OBSTACLES),
            *(Case(f"{name}, dropped", partial(dropped, obstacle=name)) for name in OBSTACLES),
        ),
    ),
)
