"""Checks of tangles: limp cloth that is pressed, dragged and folded must never pass through itself.

A crossing is a pair of an edge and a triangle that pass through each other. Crossings are counted in every frame. For
two separate layers, vertices on the wrong side are counted as well. If a vertex of the upper layer is under the lower
layer, it has passed through the lower layer, even if no edge crosses the lower layer any more.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from scipy.interpolate import LinearNDInterpolator

from tatamu.base.errors import SimulationError
from tatamu.simulation.material import Material
from tatamu.simulation.mesh.crossings import crossings_over_time
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Cloth, Gripper, Scene, Table
from tests.physics.check import Case, Check
from tests.physics.findings import Curve, Figure, Findings, small
from tests.physics.manipulations import PATCH, RandomFold, scene_of
from tests.physics.meshes import irregular, staggered
from tests.physics.scenes import joined, raised
from tests.physics.subject import Subject

LIMP = Material(areal_density=0.15, stretch_stiffness=200.0, bending_rigidity=2e-6, thickness=0.001)
SIDE = 0.2
SPACING = 0.012
"""Mesh spacing of the cloth in the random folds [m]."""
BATCH = 8


def dragged(speed: float, press: float) -> tuple[Scene, np.ndarray, np.ndarray]:
    """Return a scene with two sheets, and the vertices of the lower and of the upper sheet.

    A hand presses the middle of the upper sheet on the lower sheet and drags the upper sheet.

    Args:
        speed: Speed of the hand [m/s].
        press: Distance by which the hand goes down [m].
    """
    lower = staggered(SIDE, SIDE, 0.01)
    upper = irregular(0.7 * SIDE, 0.7 * SIDE, 0.01)
    plan = upper[0] - 0.35 * SIDE
    vertices, faces, members = joined(
        [(raised(lower[0] - SIDE / 2, 0.5 * LIMP.thickness), lower[1]), (raised(plan, 1.5 * LIMP.thickness), upper[1])]
    )
    patch = members[1][(np.abs(plan) < PATCH).all(axis=1)]
    stroke = 0.08
    down = 0.1
    hand = Gripper(
        vertices=patch.tolist(),
        times=[0.0, down, down + stroke / speed, down + 2 * stroke / speed],
        displacements=[[0, 0, 0], [0, 0, -press], [stroke, 0, -press], [stroke, stroke / 2, -press]],
    )
    scene = Scene(
        cloth=Cloth(vertices=vertices, faces=faces),
        material=LIMP,
        table=Table(),
        grippers=[hand],
        duration=down + 2 * stroke / speed + 0.3,
    )
    return scene, members[0], members[1]


def wrong_side(rollout: Rollout, lower: np.ndarray, upper: np.ndarray) -> int:
    """Return the number of vertices of the upper layer that are at or below the lower layer at the end."""
    end = rollout.positions[-1]
    surface = LinearNDInterpolator(end[lower, :2], end[lower, 2])
    below = surface(end[upper, :2])
    return int((end[upper, 2] <= below + 1e-6).sum())  # `below` is NaN outside the lower layer


def press_and_drag(subject: Subject, speed: float, press: float) -> Findings:
    """Check that a limp layer does not pass through the layer on which it is pressed and dragged."""
    scene, lower, upper = dragged(speed, press)
    rollout = subject.simulate(scene)
    counts = crossings_over_time(rollout.positions, rollout.faces)
    limit = subject.limit("crossings")
    yield small(
        "crossings, most in one frame", float(counts.max()), limit, "-", f"{(counts > 0).sum()} of {len(counts)} frames"
    )
    yield small("vertices on the wrong side at the end", float(wrong_side(rollout, lower, upper)), limit, "-")


def crossings_of_fold(
    simulate: Callable[[Scene], Rollout], seed: int, fast: bool, spacing: float = SPACING
) -> np.ndarray | None:
    """Return the number of crossings in each of f frames of a random fold of limp cloth, shape (f,).

    The result is None if the simulation fails.
    """
    try:
        rollout = simulate(scene_of(RandomFold.random(seed, fast), LIMP, spacing))
    except SimulationError:
        return None
    return crossings_over_time(rollout.positions, rollout.faces)


def random_folds(subject: Subject, seeds: range, fast: bool, spacing: float = SPACING) -> Findings:
    """Check that limp cloth does not pass through itself in several random folds."""
    counts = [crossings_of_fold(subject.simulate, seed, fast, spacing) for seed in seeds]
    found = np.array([np.nan if each is None else float(each.max()) for each in counts])
    limit = subject.limit("crossings")
    stopped = int(np.isnan(found).sum())
    yield small(
        f"folds of {len(found)} with a crossing in any frame",
        float((found > 0).sum()),
        limit,
        "-",
        f"most crossings in one frame {np.nanmax(found, initial=0):.0f}",
    )
    yield small(f"folds of {len(found)} that ended in an error", float(stopped), limit, "-")
    yield Curve("folds", "fast" if fast else "slow", np.array(seeds), np.nan_to_num(found))


def _fold_cases() -> tuple[Case, ...]:
    cases = []
    for fast in (True, False):
        for first in range(0, 32, BATCH):
            seeds = range(first, first + BATCH)
            label = f"{'fast' if fast else 'slow'} folds {first + 1} to {first + BATCH}"
            cases.append(Case(label, partial(random_folds, seeds=seeds, fast=fast), quick=False))
    return tuple(cases)


CHECKS = (
    Check(
        "drag",
        "Limp layers pressed and dragged",
        "no vertex on the wrong side, ever",
        tuple(
            Case(
                f"{speed:g} m/s, pressed {1e3 * press:g} mm",
                partial(press_and_drag, speed=speed, press=press),
                quick=(speed, press) == (0.5, 0.0),
            )
            for speed in (0.1, 0.5, 1.0)
            for press in (0.0, 0.0005)
        ),
    ),
    Check(
        "folds",
        "64 random folds of limp cloth, B = 2e-6 N m",
        "no vertex on the wrong side, ever",
        _fold_cases(),
        {"folds": Figure("Most crossings in one frame", "fold", "crossings")},
    ),
)
