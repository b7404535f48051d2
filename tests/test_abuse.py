"""Scenes that nobody should make end in a rollout or in a clear error."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tatamu.simulation.simulators import simulate
from tests import abuse
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
