"""Searches beside the default: CMA-ES and Optuna's samplers."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tatamu.search import Bounds, Search, Space, find_search
from tatamu.search.cma import CMASearch, replay_strategy
from tatamu.search.search import Observation
from tests.small_studies import learn_plain, timeless, towel

SPACE = Space({"x": Bounds(-1.0, 3.0), "y": Bounds(0.0, 0.5), "g": Bounds(0, 6, whole=True)})


def bowl(parameters: Mapping[str, float]) -> float:
    x, y, g = (parameters[name] for name in ("x", "y", "g"))
    return (x - 0.5) ** 2 + 20.0 * (y - 0.2) ** 2 + 0.1 * (g - 4) ** 2


def told(make: Any, count: int, seed: int = 0) -> Search:
    """A search of a bowl after so many trials."""
    search: Search = make(SPACE, seed)
    for _ in range(count):
        proposal = search.ask()
        search.tell(proposal, bowl(proposal))
    return search


def test_the_strategy_learns_from_whole_generations_only() -> None:
    drawn = [Observation(SPACE.random(number), float(number)) for number in range(20)]
    size = replay_strategy(SPACE, []).population_size
    for count in range(20):
        assert replay_strategy(SPACE, drawn[:count]).generation == count // size


def test_evolution_ends_nearer_to_the_least_than_it_started() -> None:
    gains = []
    for seed in range(5):
        values = [each.objective for each in told(CMASearch, 84, seed).told]
        gains.append(np.median(values[-14:]) / np.median(values[:14]))
    assert np.median(gains) < 0.1


@pytest.mark.parametrize("name", ["tpe", "cmaes", "random"])
def test_proposals_depend_on_trials_and_seed_alone(name: str) -> None:
    make = find_search(name)
    known = told(make, 16).told
    proposals = []
    for seed in (7, 7, 8):
        search = make(SPACE, seed)
        for each in known:
            search.tell(each.parameters, each.objective)
        proposals.append(dict(search.ask()))
    one, other, third = proposals
    assert one == other != third
    assert isinstance(one["g"], int)


@pytest.mark.parametrize("name", ["gp", "tpe", "cmaes", "random"])
def test_a_resumed_search_proposes_the_same_beside_trials_that_still_run(name: str) -> None:
    first = [SPACE.random(number) for number in range(4)]
    search = find_search(name)(SPACE, 0, first)
    running = [search.ask(), search.ask()]
    for _ in range(16):
        search.tell(running[0], bowl(running[0]))
        again = find_search(name)(SPACE, 0, first)
        for each in search.told:
            again.tell(each.parameters, each.objective)
        again.expect(running[1])
        running = [running[1], search.ask()]
        assert dict(again.ask()) == dict(running[1])


@pytest.mark.parametrize("sampler", ["gp", "cmaes"])
def test_a_garment_with_one_candidate_for_each_hand_is_learned(sampler: str) -> None:
    one = towel(spacing=0.06, size=(0.30, 0.50))
    assert one.fold.candidates == 1
    result = learn_plain(one, None, trials=3, sampler=sampler, parallel=1, baselines=False)
    assert all(trial.parameters["g1"] == trial.parameters["g2"] == 0 for trial in result.trials)


@pytest.mark.slow
@pytest.mark.parametrize("sampler", ["cmaes", "tpe"])
def test_an_interrupted_study_ends_as_an_undisturbed_one(tmp_path: Path, sampler: str) -> None:
    for trials in (3, 14):
        learn_plain(towel(), tmp_path / "paused", trials=trials, sampler=sampler, baselines=False)
    learn_plain(towel(), tmp_path / "at-once", trials=14, sampler=sampler, baselines=False)
    assert timeless(tmp_path / "paused") == timeless(tmp_path / "at-once")
