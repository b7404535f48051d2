"""Checks of Coulomb friction: cloth on an inclined table, and cloth on cloth.

The threshold is the tilt at which a cloth starts to slide. It is found by bisection of an interval of tilts. A cloth
counts as sliding if its middle moves faster than `SLIDING` after one second. At 0.01 degrees above the threshold, the
cloth moves this fast.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from tatamu.simulation.material import GRAVITY, Material
from tatamu.simulation.scene import Cloth, Scene, Table
from tests.physics.check import Case, Check
from tests.physics.findings import Curve, Figure, Findings, absolute, relative, small
from tests.physics.meshes import right, staggered
from tests.physics.references import incline_acceleration, incline_threshold
from tests.physics.scenes import joined, on_incline
from tests.physics.subject import Subject

COEFFICIENTS = (0.2, 0.4, 0.6, 0.8, 1.0)
FABRIC = Material(areal_density=0.2, stretch_stiffness=300.0, bending_rigidity=1e-4)
SLIDING = 1e-3
"""Largest speed of a cloth that counts as at rest on the table [m/s]. A faster cloth counts as sliding."""
SHIFTED = 1e-3
"""Largest distance that a layer of a stack moves in 0.4 s if it counts as at rest [m]. A layer that moves farther
counts as sliding. At 0.1 degrees above the tilt at which sliding starts, layers move farther."""
GRIP = 3.0
"""Friction coefficient of the table under stacks. It is so large that the lowest layer does not slide."""


def incline(mu: float, tilt: float, duration: float) -> Scene:
    """Return a scene with a square cloth at rest on a tilted table."""
    plan, faces = right(0.1, 0.1, 0.02)
    material = FABRIC.model_copy(update={"friction_table": mu})
    cloth = Cloth(vertices=on_incline(plan, material.thickness / 2, tilt), faces=faces)
    return Scene(cloth=cloth, material=material, table=Table(tilt=tilt), duration=duration)


def layers(count: int, mu: float, tilt: float, duration: float) -> tuple[Scene, list[np.ndarray]]:
    """Return a scene with a stack of square cloths on a tilted table, and the vertices of each cloth.

    Each cloth is smaller than the cloth below it.
    """
    material = FABRIC.model_copy(update={"friction_table": GRIP, "friction_cloth": mu})
    parts = []
    for layer in range(count):
        side = 0.10 + 0.04 * (count - 1 - layer)
        plan, faces = staggered(side, side, 0.02)
        distance = (layer + 0.5) * material.thickness
        parts.append((on_incline(plan - side / 2, distance, tilt), faces))
    vertices, faces, members = joined(parts)
    scene = Scene(
        cloth=Cloth(vertices=vertices, faces=faces), material=material, table=Table(tilt=tilt), duration=duration
    )
    return scene, members


def travel(subject: Subject, scene: Scene, members: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Return two arrays over the f frames of a simulation: times [s], and distances down the incline [m].

    The distance is how far the mean position of the vertices `members` has moved; None for all vertices of the cloth.
    """
    rollout = subject.simulate(scene)
    tilt = scene.table.tilt if scene.table else 0.0
    middle = rollout.positions[:, slice(None) if members is None else members].mean(axis=1)
    return rollout.times, (middle - middle[0]) @ [np.cos(tilt), 0.0, -np.sin(tilt)]


def final_speed(times: np.ndarray, distance: np.ndarray) -> float:
    """Return the mean speed of a cloth during the last fifth of its simulated motion [m/s]."""
    late = len(times) * 4 // 5
    return float((distance[-1] - distance[late]) / (times[-1] - times[late]))


def threshold(slides: Callable[[float], bool], guess: float, within: float, to: float) -> float:
    """Return the tilt at which a cloth starts to slide [rad], found by bisection.

    The first interval is from guess - within to guess + within. The last interval is not longer than `to`.
    """
    low = guess - within
    high = guess + within
    while high - low > to:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if slides(middle) else (middle, high)
    return 0.5 * (low + high)


def on_table(subject: Subject, mu: float) -> Findings:
    """Check when and how a cloth on a tilted table slides.

    The quantities are the tilt at which the cloth starts to slide, its creep below this tilt, and its acceleration
    above.
    """
    wanted = incline_threshold(mu)

    def slides(tilt: float) -> bool:
        return final_speed(*travel(subject, incline(mu, tilt, 1.0))) > SLIDING

    found = threshold(slides, wanted, np.radians(2.0), np.radians(0.05))
    yield absolute(
        "threshold [deg]", float(np.degrees(wanted)), float(np.degrees(found)), subject.limit("threshold"), "deg"
    )
    yield Curve("threshold", subject.name, np.array([mu]), np.degrees([found]))
    around = np.linspace(mu - 0.1, mu + 0.1, 21)
    yield Curve("threshold", "arctan μ", around, np.degrees(np.arctan(around)), reference=True)
    creep = abs(final_speed(*travel(subject, incline(mu, wanted - np.radians(0.2), 2.0))))
    yield small("creep 0.2 deg below [mm/s]", 1e3 * creep, subject.limit("creep", 1e3), "mm/s")
    for degrees in (1.0, 10.0):
        tilt = wanted + np.radians(degrees)
        acceleration = incline_acceleration(tilt, mu, GRAVITY)
        times, distance = travel(subject, incline(mu, tilt, 0.5))
        got = _acceleration(times, distance)
        yield relative(f"acceleration {degrees:g} deg above [m/s²]", acceleration, got, subject.limit("acceleration"))
        if degrees == 10.0:
            yield Curve("acceleration", f"μ = {mu:g}", times[::3], distance[::3])
            yield Curve(
                "acceleration", "g (sin θ - μ cos θ) t² / 2", times, 0.5 * acceleration * times**2, reference=True
            )


def _acceleration(times: np.ndarray, distance: np.ndarray) -> float:
    """Return the acceleration of a sliding cloth [m/s^2], from its distances at given times.

    The acceleration is twice the leading coefficient of a parabola through the second half of the motion.
    """
    half = len(times) // 2
    return float(2 * np.polyfit(times[half:], distance[half:], 2)[0])


def on_cloth(subject: Subject, count: int, mu: float = 0.5) -> Findings:
    """Check when the top cloth of a stack on a tilted table slides.

    The quantities are the tilt at which the cloth starts to slide, and its creep below this tilt.
    """
    wanted = incline_threshold(mu)

    def slides(tilt: float) -> bool:
        scene, members = layers(count, mu, tilt, 0.4)  # so short that no layer slides off the layer below
        _, distance = travel(subject, scene, members[-1])
        return float(distance.max()) > SHIFTED

    found = threshold(slides, wanted, np.radians(4.0), np.radians(0.25))
    limit = subject.limit("threshold between layers")
    yield absolute(
        "threshold of the top layer [deg]", float(np.degrees(wanted)), float(np.degrees(found)), limit, "deg"
    )
    for degrees in (1.0, 5.0):
        scene, members = layers(count, mu, wanted - np.radians(degrees), 2.0)
        creep = abs(final_speed(*travel(subject, scene, members[-1])))
        yield small(f"creep of the top layer {degrees:g} deg below [mm/s]", 1e3 * creep, None, "mm/s")
    scene, members = layers(count, mu, wanted + np.radians(3.0), 0.25)
    if count == 2:
        acceleration = incline_acceleration(wanted + np.radians(3.0), mu, GRAVITY)
        got = _acceleration(*travel(subject, scene, members[-1]))
        yield relative("acceleration 3 deg above [m/s²]", acceleration, got, None, "before it leaves the lower layer")


_SWEEP = tuple(Case(f"μ = {mu:g}", partial(on_table, mu=mu), quick=mu in (0.2, 1.0)) for mu in COEFFICIENTS)

CHECKS = (
    Check(
        "incline",
        "Cloth on a tilted table",
        "sticks iff tan(θ) < μ; slides with g (sin θ - μ cos θ)",
        _SWEEP,
        {
            "threshold": Figure("Where a cloth begins to slide", "μ", "tilt [deg]"),
            "acceleration": Figure("10 deg above the threshold", "time [s]", "way [m]"),
        },
    ),
    Check(
        "layers",
        "Cloth on cloth on a tilted table",
        "sticks iff tan(θ) < μ between all layers",
        tuple(Case(f"{count} layers", partial(on_cloth, count=count), quick=False) for count in (2, 4)),
    ),
)
