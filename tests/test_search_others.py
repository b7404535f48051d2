"""Searches beside the default: Levenberg-Marquardt after Li et al. (2015), CMA-ES, and Optuna's samplers."""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Callable, Mapping
from itertools import repeat
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tatamu import Nominal, SimulationError
from tatamu.folding.baselines import li_2015
from tatamu.folding.score import ALPHA, residuals, shape_distance
from tatamu.search import Bounds, Search, Space, find_search
from tatamu.search.cma import CMASearch, replay_strategy
from tatamu.search.levenberg_marquardt import (
    DIFFERENCE,
    Key,
    Residuals,
    key_of,
    least_squares,
    neighbours,
    next_point,
)
from tatamu.search.lm import LI_2015
from tatamu.search.search import Observation
from tatamu.simulation.scene import Scene
from tatamu.simulation.simulators import simulate
from tatamu.study.trial import _pack, _unpack
from tests.small_studies import learn_plain, timeless, towel

LEAST = np.array([0.3, 0.55])


def valley(point: np.ndarray) -> np.ndarray:
    """Residuals of Rosenbrock's curved valley, whose least value, zero, is at `LEAST`."""
    x, y = 4.0 * (point - LEAST) + 1.0
    return np.array([10.0 * (y - x * x), 1.0 - x])


def searched(
    function: Callable[[np.ndarray], Residuals], count: int, pending: int = 1, start: tuple[float, float] = (0.9, 0.1)
) -> list[np.ndarray]:
    """The points that are asked for, each `pending` - 1 evaluations late."""
    known: dict[Key, Residuals] = {}
    running: deque[np.ndarray] = deque()
    asked = []
    for _ in range(count):
        if len(running) == pending:
            ended = running.popleft()
            known[key_of(ended)] = function(ended)
        starts = [np.array(start), *repeat(np.array([0.5, 0.5]), 1), *np.random.default_rng(0).random((99, 2))]
        point = next_point(starts, known, {key_of(each) for each in running})
        running.append(point)
        asked.append(point)
    return asked


def best_distance(points: list[np.ndarray]) -> float:
    return min(float(np.abs(point - LEAST).max()) for point in points)


def test_the_first_points_are_the_start_and_one_neighbour_along_each_coordinate() -> None:
    first, *around = searched(valley, 3)
    assert first.tolist() == [0.9, 0.1]
    assert [(each - first).round(9).tolist() for each in around] == [[DIFFERENCE, 0.0], [0.0, DIFFERENCE]]


def test_neighbours_stay_in_the_cube() -> None:
    for point in (np.array([1.0, 0.0]), np.array([0.995, 0.2])):
        around = np.array(neighbours(point))
        assert around.min() >= 0.0 and around.max() <= 1.0
        assert np.abs(around - point).sum(axis=1) == pytest.approx(DIFFERENCE)


def test_a_linear_problem_is_solved_by_its_first_steps() -> None:
    matrix = np.array([[1.0, 2.0], [3.0, -1.0], [0.5, 0.5]])
    points = searched(lambda point: matrix @ (point - LEAST), 8)
    assert best_distance(points) < 1e-3


def test_a_curved_valley_is_followed_to_its_end() -> None:
    assert best_distance(searched(valley, 60)) < 1e-3


def test_steps_end_at_the_border_where_the_least_lies_beyond_it() -> None:
    points = searched(lambda point: point - np.array([1.4, 0.5]), 12)
    assert any(point[0] == 1.0 and abs(point[1] - 0.5) < 0.02 for point in points)
    assert max(point.max() for point in points) <= 1.0


def test_what_has_converged_is_followed_by_the_next_start() -> None:
    points = searched(lambda point: point - LEAST, 20)
    assert any((point == 0.5).all() for point in points)
    assert len({key_of(point) for point in points}) == len(points), "no point is evaluated twice"


@pytest.mark.parametrize("pending", [2, 4, 7])
def test_pending_evaluations_are_never_asked_for_again_and_the_least_is_still_found(pending: int) -> None:
    points = searched(valley, 90, pending)
    assert len({key_of(point) for point in points}) == len(points)
    assert best_distance(points) < 2e-3


def test_a_step_that_fails_is_made_shorter() -> None:
    def partly(point: np.ndarray) -> Residuals:
        return None if point[0] < 0.29 else valley(point)

    assert best_distance(searched(partly, 80)) < 0.01


def test_a_start_that_fails_is_given_up() -> None:
    search = least_squares(np.array([0.9, 0.1]))
    wanted = next(search)
    with pytest.raises(StopIteration):
        search.send([None] * len(wanted))


def test_residuals_are_those_whose_squares_sum_to_what_errors_add_to_the_objective() -> None:
    errors = np.random.default_rng(1).exponential(0.02, 300)
    vector = residuals(errors)
    assert float(vector @ vector) == pytest.approx(ALPHA * shape_distance(errors))


def test_errors_survive_being_kept() -> None:
    errors = np.random.default_rng(2).exponential(0.02, 300)
    assert _unpack(_pack(errors)) == pytest.approx(errors, rel=1e-6)
    assert _pack(_unpack(_pack(errors))) == _pack(errors)


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


@pytest.mark.parametrize(("sampler", "coarse"), [("gp", False), ("gp", True), ("cmaes", False), ("lm", False)])
def test_a_garment_with_one_candidate_for_each_hand_is_learned(
    monkeypatch: pytest.MonkeyPatch, sampler: str, coarse: bool
) -> None:
    one, other = (towel(spacing=spacing, size=(0.30, 0.50)) for spacing in (0.06, 0.07))
    assert one.fold.candidates == other.fold.candidates == 1
    if coarse:
        monkeypatch.setattr("tatamu.garments.garment.Garment.spacing_given", False)
        monkeypatch.setattr("tatamu.evaluation.coarse.coarser_task", lambda *_: other)
    result = learn_plain(one, None, trials=10 if coarse else 3, sampler=sampler, coarse=coarse, parallel=1,
                         baselines=False)  # fmt: skip
    assert (result.record.coarse is not None) == coarse
    assert all(trial.parameters["g1"] == trial.parameters["g2"] == 0 for trial in result.trials)


@pytest.mark.parametrize("sampler", ["lm", *(pytest.param(name, marks=pytest.mark.slow) for name in ("cmaes", "tpe"))])
def test_an_interrupted_study_ends_as_an_undisturbed_one(tmp_path: Path, sampler: str, small_pictures: None) -> None:
    for trials in (3, 14):
        learn_plain(towel(), tmp_path / "paused", trials=trials, sampler=sampler, baselines=False)
    learn_plain(towel(), tmp_path / "at-once", trials=14, sampler=sampler, baselines=False)
    assert timeless(tmp_path / "paused") == timeless(tmp_path / "at-once")


def test_the_method_of_li_starts_with_their_curve_at_the_corners_and_leads_down() -> None:
    trials = learn_plain(towel(), None, trials=16, sampler="lm", baselines=False, parallel=1).trials
    assert all(trial.parameters["g1"] == trial.parameters["g2"] == 0 for trial in trials)
    fold = towel().fold
    first = trials[0].parameters
    assert [first["x1"], first["z1"]] == pytest.approx(np.array(LI_2015[0]) * fold.span)
    assert trials[0].objective == pytest.approx(Nominal(towel()).fixed(li_2015(fold)).objective)
    objectives = [trial.objective for trial in trials if trial.objective is not None]
    assert min(objectives[5:]) < min(objectives[:5])


def test_the_method_of_li_goes_on_after_a_failed_trial(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = iter(range(100))

    def sometimes(scene: Scene, name: str) -> Any:
        if next(calls) in (2, 5):
            raise SimulationError("blew up")
        return simulate(scene, name)

    monkeypatch.setattr("tatamu.evaluation.nominal.simulate", sometimes)
    trials = learn_plain(towel(), None, trials=8, sampler="lm", baselines=False, parallel=1).trials
    assert [trial.state for trial in trials].count("failed") == 2
    assert len({json.dumps(trial.parameters) for trial in trials}) == 8
