"""Check of refinement: whether a mesh of half the spacing changes which manipulation is best.

Thirty random folds of one towel are simulated on a mesh and on a mesh of half its spacing. The score of a fold is the
mean distance of its vertices from the towel that is folded exactly in half. A search depends on the order of these
scores.

In the first case, hands hold only the edge, as in tatamu's own folds, and the cloth turns about the edge. In the second
case, hands hold several rows of vertices, and so they also fix the slope of the corner. The hands then lay the corner
down with its hem turned up, and the corner jumps when the hands open. The jump differs between any two meshes, so the
second case is separate. A halved time step is not compared, because a scene has no time step: every simulator chooses
its own.
"""

from __future__ import annotations

from functools import partial

import numpy as np
from scipy.stats import spearmanr

from tatamu.base.errors import SimulationError
from tatamu.simulation.material import Material
from tatamu.simulation.scene import Scene
from tests.physics.check import Case, Check
from tests.physics.findings import Curve, Figure, Findings, Row, absolute, small
from tests.physics.manipulations import EDGE, LENGTH, PATCH, RandomFold, half_fold_target, scene_of
from tests.physics.scenes import vertex_areas
from tests.physics.subject import Subject

TOWEL = Material(areal_density=0.2, stretch_stiffness=300.0, bending_rigidity=1e-4)
COUNT = 30


def score(subject: Subject, scene: Scene) -> float:
    """Return the area-weighted mean distance between the final cloth and a towel that is folded exactly in half [m].

    The result is half the towel's length if the simulation fails.
    """
    try:
        end = subject.simulate(scene).positions[-1]
    except SimulationError:
        return LENGTH / 2
    plan = scene.cloth.rest[:, :2]
    distance = np.linalg.norm(end - half_fold_target(plan, scene.material.thickness), axis=1)
    return float(np.average(distance, weights=vertex_areas(scene.cloth.rest, scene.cloth.faces)))


def half_the_mesh(subject: Subject, spacing: float, depth: float = EDGE, count: int = COUNT) -> Findings:
    """Compare two meshes: the order of random folds by their scores, and the best fold.

    Hands hold the cloth within `depth` metres of the edge.
    """
    folds = [RandomFold.random(100 + seed, fast=False) for seed in range(count)]
    coarse, fine = (
        np.array([score(subject, scene_of(fold, TOWEL, s, depth)) for fold in folds]) for s in (spacing, spacing / 2)
    )
    least = subject.limit("rank correlation")
    found = float(spearmanr(coarse, fine).statistic)
    yield Row(
        "rank correlation of the scores",
        least,
        found,
        1 - found,
        None if least is None else 1 - least,
        "-",
        "error is 1 minus it",
    )
    limit = subject.limit("best", 1e3)
    yield absolute(
        f"best score of {count} [mm]",
        1e3 * float(fine.min()),
        1e3 * float(coarse.min()),
        limit,
        "mm",
        "reference: finer mesh",
    )
    chosen = float(fine[np.argmin(coarse)] - fine.min())
    yield small("finer mesh's score of the coarse mesh's best, above the best [mm]", 1e3 * chosen, limit, "mm")
    held = "" if depth == EDGE else f", held {1e3 * depth:g} mm deep"
    yield Curve("refinement", f"{1e3 * spacing:g} mm{held}", 1e3 * fine, 1e3 * coarse)
    ends = 1e3 * np.array([fine.min(), fine.max()])
    yield Curve("refinement", "equal", ends, ends, reference=True)


CHECKS = (
    Check(
        "refinement",
        "30 random manipulations on half the mesh spacing",
        "the same order, the same best",
        (
            Case("20 and 10 mm", partial(half_the_mesh, spacing=0.02), quick=False),
            Case("held 25 mm deep", partial(half_the_mesh, spacing=0.02, depth=PATCH), quick=False),
        ),
        {"refinement": Figure("Scores of random folds", "finer mesh [mm]", "coarser mesh [mm]", equal=True)},
    ),
)
