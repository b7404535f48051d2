"""Checks of air: a sheet that falls, and a stiff sheet that hangs and swings."""

from __future__ import annotations

from functools import partial

import numpy as np

from tatamu.simulation.material import GRAVITY, Material
from tatamu.simulation.scene import Cloth, Scene
from tests.physics.check import Case, Check
from tests.physics.findings import Curve, Figure, Findings, absolute, relative
from tests.physics.meshes import staggered
from tests.physics.plate import falling, hanging, swing_of
from tests.physics.scenes import held, on_incline, raised
from tests.physics.subject import Subject

CLOTH = Material(areal_density=0.2, stretch_stiffness=300.0, bending_rigidity=1e-4)
STIFF = Material(areal_density=0.2, stretch_stiffness=1000.0, bending_rigidity=1.0)
"""A stiff material. Its own weight bends a sheet by less than a thousandth of the sheet's length."""

DIRECTED = {
    "air_drag": 0.1,
    "air_drag_normal": 0.3,
    "air_drag_tangential": 0.05,
    "air_drag_quadratic": 0.9,
    "air_drag_quadratic_tangential": 0.04,
    "air_added_mass": 0.08,
}
SWINGS = {
    "in a vacuum": {},
    "added mass": {"air_added_mass": 0.08},
    "added mass, linear drag": {"air_added_mass": 0.08, "air_drag_normal": 0.2},
    "added mass, linear and quadratic drag": {
        "air_added_mass": 0.08,
        "air_drag_normal": 0.1,
        "air_drag_quadratic": 1.5,
    },
    "added mass, drag since it turned": {"air_added_mass": 0.08, "air_drag_quadratic": 1.5, "air_drag_turning": 0.6},
}
LENGTH = 0.3
ANGLE = 0.3
"""Angle at which the hanging plate is released [rad]."""
RATE = 200.0


def fall(subject: Subject, tilt: float) -> Findings:
    """Check a sheet that falls at a constant tilt, with different drag along its normal and along its surface."""
    material = CLOTH.model_copy(update=DIRECTED)
    plan, faces = staggered(0.2, 0.15, 0.02)
    slope = np.array([np.cos(tilt), 0.0, -np.sin(tilt)])
    normal = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    start = on_incline(plan, 0.0, tilt)
    scene = Scene(cloth=Cloth(vertices=start, faces=faces), material=material, duration=1.5, frame_rate=100)
    rollout = subject.simulate(scene)
    moved = (rollout.positions - start).mean(axis=1)
    speed = (moved[-1] - moved[-2]) * scene.frame_rate
    across, along = falling(material, tilt, scene.gravity)
    for name, direction, ideal in (("along the normal", -normal, across), ("along the sheet", slope, along)):
        if ideal.force < 1e-9:
            continue
        end = rollout.times[-1]
        late = ideal.distance(end) - ideal.distance(rollout.times[-2])
        limit = subject.limit("air speed")
        note = f"terminal speed {ideal.terminal_speed:.4g} m/s"
        yield relative(f"speed {name} [m/s]", late * scene.frame_rate, float(speed @ direction), limit, note)
        yield relative(
            f"distance {name} [m]", ideal.distance(end), float(moved[-1] @ direction), subject.limit("air path")
        )


def swing(subject: Subject, air: dict[str, float]) -> Findings:
    """Check a stiff sheet that hangs from its upper edge and is released at an angle."""
    material = STIFF.model_copy(update=air)
    plan, faces = staggered(LENGTH, 0.1, 0.03)
    tilted = np.column_stack([np.sin(ANGLE) * plan[:, 0], plan[:, 1], -np.cos(ANGLE) * plan[:, 0]])
    cloth = Cloth(vertices=tilted, faces=faces, rest_vertices=raised(plan))
    hand = held(np.flatnonzero(plan[:, 0] == 0))
    scene = Scene(cloth=cloth, material=material, grippers=[hand], duration=5.0, frame_rate=RATE)
    rollout = subject.simulate(scene)
    lowest = plan[:, 0] > LENGTH - 1e-9
    angle = np.arcsin(rollout.positions[:, lowest, 0].mean(axis=1) / LENGTH)
    wanted = hanging(material, LENGTH, ANGLE, rollout.times, GRAVITY)
    got = swing_of(rollout.times, angle)
    ideal = swing_of(rollout.times, wanted)
    yield relative("period [s]", ideal.period, got.period, subject.limit("swing period"))
    limit = subject.limit("swing decrement")
    for number, name in ((0, "first"), (min(3, len(ideal.decrement) - 1), "later")):
        right = float(ideal.decrement[number])
        yield absolute(f"{name} decrement [-]", right, float(got.decrement[number]), limit, "-")
    yield Curve("plate", "rigid plate", rollout.times, np.degrees(wanted), reference=True)
    yield Curve("plate", subject.name, rollout.times[::20], np.degrees(angle[::20]))


CHECKS = (
    Check(
        "air-fall",
        "Sheet that falls through air",
        "M dv/dt = f - c v - q v², along the normal with added mass and along the sheet",
        tuple(Case(f"tilted by {tilt} degrees", partial(fall, tilt=np.radians(tilt))) for tilt in (0, 30, 60)),
    ),
    Check(
        "air-swing",
        "Stiff sheet that hangs and swings in air",
        "rigid plate: (rho + m_a) L³/3 a'' = -rho g L²/2 sin a - c L³/3 a' - int max(q, k / (r b)^(1/3)) r³ dr |a'| a'",
        tuple(Case(name, partial(swing, air=air), quick=name != "added mass") for name, air in SWINGS.items()),
        {"plate": Figure("Hanging plate", "time [s]", "angle [degrees]")},
    ),
)
