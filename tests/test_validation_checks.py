"""Every check can fail: on a cloth that shakes as no cloth does, or on one that stands still."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

from tatamu.base.errors import SimulationError
from tatamu.simulation.scene import Scene
from tests.fakes import Motion, subject
from tests.physics.check import Case
from tests.physics.checks import CHECKS, bodies, determinism, motion, refinement, tangle
from tests.physics.findings import Row
from tests.physics.report import run

SHORT = {
    "folds": Case("", partial(tangle.random_folds, seeds=range(2), fast=True, spacing=0.02)),
    "obstacles": Case("", partial(bodies.dropped, obstacle="corner")),
    "refinement": Case("", partial(refinement.half_the_mesh, spacing=0.04, count=12)),
}
"""Shorter questions of checks whose cases take minutes."""


def stands(scene: Scene, time: float) -> np.ndarray:
    return scene.cloth.vertices


def shaking() -> Motion:
    """By another centimetre at every call."""
    random = np.random.default_rng(0)
    return lambda scene, time: scene.cloth.vertices + 0.01 * random.normal(size=scene.cloth.vertices.shape)


def rows(case: Case, motion: Motion) -> list[Row]:
    return run(case, subject(motion)).rows


@pytest.mark.parametrize("name", CHECKS)
def test_a_check_fails_on_a_wrong_answer(name: str) -> None:
    case = SHORT.get(name) or next((case for case in CHECKS[name].cases if case.quick), CHECKS[name].cases[0])
    assert any(row.passed is False for wrong in (shaking(), stands) for row in rows(case, wrong))


def test_determinism_notices_one_bit() -> None:
    calls = iter(range(10**6))

    def forgets(scene: Scene, time: float) -> np.ndarray:
        return scene.cloth.vertices * (1 + 1e-15 * next(calls))

    for question in (determinism.again, determinism.batch):
        assert [row.passed for row in rows(Case("", question), stands)] == [True]
        assert [row.passed for row in rows(Case("", question), forgets)] == [False]


def test_a_simulation_that_fails_is_a_failed_row() -> None:
    def stops(scene: Scene, time: float) -> np.ndarray:
        raise SimulationError("the cloth was stretched to 2.00 of its length")

    (row,) = rows(Case("", motion.free_fall), stops)
    assert row.passed is False and "2.00" in row.note
