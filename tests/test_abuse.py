"""Scenes that nobody should make end in a rollout or in a clear error."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tatamu.base.errors import InputError
from tatamu.simulation.mesh.topology import Topology
from tatamu.simulation.scene import Scene
from tatamu.simulation.simulators import simulate
from tests import abuse
from tests.physics.meshes import staggered
from tests.physics.scenes import sewn
from tests.scenes import scene

BATCH = 50


@pytest.mark.parametrize(
    "first", [0, *(pytest.param(first, marks=pytest.mark.slow) for first in range(BATCH, 200, BATCH))]
)
def test_random_scenes_end_in_a_rollout_or_a_clear_error(first: int) -> None:
    wrong = {seed: kind for seed in range(first, first + BATCH) if not abuse.acceptable(kind := abuse.outcome(seed))}
    assert not wrong


def test_a_seed_is_one_scene() -> None:
    assert abuse.scene(15).model_dump_json() == abuse.scene(15).model_dump_json() != abuse.scene(2).model_dump_json()


def test_a_rollout_that_is_not_finite_is_told_from_one_that_is() -> None:
    rollout = simulate(scene(duration=1 / 60))
    broken = replace(rollout, positions=rollout.positions * np.nan)
    assert abuse.acceptable(abuse.judged(rollout))
    assert not abuse.acceptable(abuse.judged(broken))


def test_scenes_are_as_varied_as_the_docs_say() -> None:
    drawn = [made for seed in range(300) if (made := _drawn(seed)) is not None]
    for name, (low, high) in abuse.DECADES.items():
        values = np.array([getattr(made.material, name) for made in drawn])
        some = values[values > 0.0]
        assert low <= some.min() < 10 * low and 0.1 * high < some.max() <= high, name
    faces = [len(made.cloth.faces) for made in drawn]
    assert min(faces) <= 4 and max(faces) > 4000
    assert {len(made.grippers) for made in drawn} == {0, 1, 2, 3, 4}
    assert max(abs(made.table.tilt) for made in drawn if made.table) == pytest.approx(np.radians(80.0))
    assert any(len(made.cloth.seams) for made in drawn) and any(made.table is None for made in drawn)


def test_a_sewn_sheet_is_a_tube() -> None:
    plan, faces = staggered(0.2, 0.1, 0.02)
    vertices, both, seams = sewn((plan, faces), 0.002)
    side = np.isclose(plan[:, 1], 0.0) | np.isclose(plan[:, 1], plan[:, 1].max())
    assert len(vertices) == 2 * len(plan) - side.sum() and len(both) == 2 * len(faces)
    ends = np.isclose(vertices[Topology(both).border][..., 0] % 0.2, 0.0)
    assert ends.all()
    assert len(seams) == side.sum() - 2
    assert scene(cloth={"vertices": vertices, "faces": both, "seams": seams}).cloth.seams.shape == seams.shape


def _drawn(seed: int) -> Scene | None:
    try:
        return abuse.scene(seed)
    except InputError:
        return None
