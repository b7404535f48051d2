"""Checks of free motion: time, momentum and energy of a cloth that touches nothing, or only a table."""

from __future__ import annotations

from functools import partial

import numpy as np

from tatamu.simulation.material import Material
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Cloth, Scene, Table
from tests.physics.check import Case, Check
from tests.physics.findings import Curve, Figure, Findings, relative, small
from tests.physics.meshes import right, staggered
from tests.physics.references import arc_energy, fall
from tests.physics.scenes import flat, held, raised, vertex_areas
from tests.physics.subject import Subject

FABRIC = Material(areal_density=0.2, stretch_stiffness=300.0, bending_rigidity=1e-4)


def masses(scene: Scene) -> np.ndarray:
    """Return the mass of each vertex [kg], shape (n,): a third of the mass of each triangle around it."""
    return scene.material.areal_density * vertex_areas(scene.cloth.rest, scene.cloth.faces)


def velocities(rollout: Rollout) -> np.ndarray:
    """Return the mean velocities of n vertices between f frames [m/s], shape (f - 1, n, 3)."""
    return np.diff(rollout.positions, axis=0) / np.diff(rollout.times)[:, None, None]


def kinetic(scene: Scene, rollout: Rollout) -> np.ndarray:
    """Return the kinetic energy of the mean velocities between f frames [J], shape (f - 1,).

    This energy is never larger than the mean of the true kinetic energy between two frames.
    """
    return 0.5 * np.einsum("fnk,fnk,n->f", *[velocities(rollout)] * 2, masses(scene))


def mechanical(scene: Scene, rollout: Rollout) -> np.ndarray:
    """Return the sum of kinetic and gravitational energy between f frames [J], shape (f - 1,).

    It is zero at the start.
    """
    height = scene.gravity * (rollout.positions[:, :, 2] - rollout.positions[0, :, 2]) @ masses(scene)
    return kinetic(scene, rollout) + 0.5 * (height[1:] + height[:-1])


def rolled(length: float, width: float, spacing: float, curvature: float) -> tuple[Cloth, float]:
    """Return a sheet that is rolled along x without stretch, and its area [m^2]."""
    plan, faces = right(length, width, spacing)
    rows = np.unique(plan[:, 0])
    heading = curvature * (rows[:-1] + 0.5 * np.diff(rows))
    x = np.concatenate([[0.0], np.cumsum(np.diff(rows) * np.cos(heading))])
    z = np.concatenate([[0.0], np.cumsum(np.diff(rows) * np.sin(heading))])
    row = np.searchsorted(rows, plan[:, 0])
    bent = np.column_stack([x[row], plan[:, 1], z[row]])
    return Cloth(vertices=bent, faces=faces, rest_vertices=raised(plan)), length * width


def free_fall(subject: Subject) -> Findings:
    """Check the height of a level cloth that falls freely for half a second."""
    scene = Scene(cloth=flat(staggered(0.2, 0.15, 0.02)), material=FABRIC, duration=0.5, frame_rate=100)
    rollout = subject.simulate(scene)
    height = rollout.positions[:, :, 2]
    wanted = fall(rollout.times, scene.gravity)
    worst = height[-1, np.argmax(np.abs(height[-1] - wanted[-1]))]
    yield relative("height after 0.5 s [m]", float(wanted[-1]), float(worst), subject.limit("fall"))
    course = float(np.abs(height - wanted[:, None]).max() / -wanted[-1])
    yield small("largest error on the way / height", 100 * course, subject.limit("fall", 100), "%")
    yield Curve("fall", "z = -g t²/2", rollout.times, wanted, reference=True)
    yield Curve("fall", subject.name, rollout.times[::5], height[::5].mean(axis=1))


def momentum(subject: Subject) -> Findings:
    """Check the momentum of a bent, stretched and twisted strip that is released without gravity."""
    plan, faces = right(0.2, 0.1, 0.02)
    bent = rolled(0.2, 0.1, 0.02, 6.0)[0].vertices * [1.01, 1.02, 1.0]
    twisted = bent + np.column_stack([0 * plan, 2.0 * plan[:, 0] * (plan[:, 1] - 0.03)])
    cloth = Cloth(vertices=twisted, faces=faces, rest_vertices=raised(plan))
    scene = Scene(cloth=cloth, material=FABRIC, gravity=0.0, duration=0.5, frame_rate=2000)
    rollout = subject.simulate(scene)
    mass = masses(scene)
    v = velocities(rollout)
    scale = float((np.linalg.norm(v, axis=2) @ mass).max())
    total = float(np.linalg.norm(np.einsum("n,fnk->fk", mass, v), axis=1).max())
    yield small("|sum m v| / sum m |v|", total / max(scale, 1e-30), subject.limit("momentum"), "-")
    arm = 0.5 * (rollout.positions[1:] + rollout.positions[:-1])
    arm = arm - arm.mean(axis=1, keepdims=True)
    spin = np.linalg.norm(np.einsum("n,fnk->fk", mass, np.cross(arm, v)), axis=1)
    turn = float((np.linalg.norm(arm, axis=2) * np.linalg.norm(v, axis=2) @ mass).max())
    yield small(
        "|sum m x × v| / sum m |x| |v|",
        float(spin.max()) / max(turn, 1e-30),
        subject.limit("angular momentum"),
        "-",
        "velocities are differences of frames",
    )


def spring(subject: Subject) -> Findings:
    """Check a rolled sheet that opens without gravity. Its kinetic energy must not exceed its bending energy."""
    cloth, area = rolled(0.2, 0.1, 0.02, 8.0)
    scene = Scene(cloth=cloth, material=FABRIC, gravity=0.0, duration=4.0, frame_rate=200)
    energy = kinetic(scene, subject.simulate(scene)) / arc_energy(FABRIC, 8.0, area)
    limit = subject.limit("energy")
    yield small(
        "kinetic energy above B k² A / 2",
        max(0.0, float(energy.max()) - 1),
        limit,
        "-",
        f"largest {energy.max():.3f} of it; at least 0.5 must come free",
    )
    yield small("bending energy that never came free", max(0.0, 0.5 - float(energy.max())), limit, "-")
    half = len(energy) // 2
    grown = float(energy[half:].max() - energy[:half].max())
    yield small("growth of the kinetic peaks", max(0.0, grown), limit, "-")


def swing(subject: Subject) -> Findings:
    """Check the energy of a level strip that is held at one edge and swings down."""
    mesh = staggered(0.3, 0.1, 0.02)
    grippers = [held(np.flatnonzero(mesh[0][:, 0] == 0))]
    scene = Scene(cloth=flat(mesh), material=FABRIC, grippers=grippers, duration=2.0, frame_rate=200)
    yield from _never_up(subject, scene, 0.3)


def drop(subject: Subject) -> Findings:
    """Check the energy of a slanting cloth that falls on a table."""
    plan, faces = staggered(0.2, 0.15, 0.02)
    slanting = np.column_stack([0.95 * plan[:, 0], plan[:, 1], 0.05 + np.sqrt(1 - 0.95**2) * plan[:, 0]])
    cloth = Cloth(vertices=slanting, faces=faces, rest_vertices=raised(plan))
    scene = Scene(cloth=cloth, material=FABRIC, table=Table(), duration=1.0, frame_rate=200)
    yield from _never_up(subject, scene, 0.1)


def _never_up(subject: Subject, scene: Scene, height: float) -> Findings:
    """Check that the sum of kinetic and gravitational energy never exceeds the sum at the start.

    At the start, the cloth is unstrained, so it has no other energy.
    """
    energy = mechanical(scene, subject.simulate(scene))
    scale = float(masses(scene).sum()) * scene.gravity * height
    over = max(0.0, float(energy.max()) / scale)
    yield small("energy above the start / m g h", over, subject.limit("energy"), "-")


CHECKS = (
    Check(
        "fall",
        "Free fall",
        "z = -g t² / 2",
        (Case("level cloth", free_fall),),
        {"fall": Figure("Free fall", "time [s]", "height [m]")},
    ),
    Check("momentum", "Momentum", "constant; zero from rest without outer forces", (Case("free strip", momentum),)),
    Check(
        "energy",
        "Energy",
        "never above what was there at the start",
        tuple(
            Case(label, partial(run))
            for label, run in [("rolled sheet springs open", spring), ("strip swings", swing), ("cloth drops", drop)]
        ),
    ),
)
