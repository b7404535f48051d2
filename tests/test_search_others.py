"""Searches beside the default: Levenberg-Marquardt after Li et al. (2015), CMA-ES, Optuna's samplers."""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import replace
from itertools import repeat
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tatamu.api import Result, learn
from tatamu.evaluation import Evaluation, Nominal
from tatamu.folding.baselines import LI_2015, li_2015
from tatamu.folding.score import ALPHA, residuals, shape_distance
from tatamu.folding.task import Task, make_task
from tatamu.options import LearnOptions
from tatamu.search import Bounds, Observation, Search, Space, find_search
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


def test_residuals_are_those_whose_squares_sum_to_the_unknown_part_of_the_objective() -> None:
    errors = np.random.default_rng(1).exponential(0.02, 300)
    vector = residuals(errors)
    assert float(vector @ vector) == pytest.approx(ALPHA * shape_distance(errors))


SPACE = Space({"x": Bounds(-1.0, 3.0), "y": Bounds(0.0, 0.5), "g": Bounds(0, 6, whole=True)})


def bowl(x: Mapping[str, float]) -> float:
    return float((x["x"] - 0.5) ** 2 + 20.0 * (x["y"] - 0.2) ** 2 + 0.1 * (x["g"] - 4) ** 2)


def searched_bowl(search: Search, count: int) -> list[float]:
    """Objectives of a bowl, in the order in which a search asks for them."""
    for _ in range(count):
        x = search.ask()
        SPACE.check(x)
        search.tell(x, bowl(x))
    return [each.objective for each in search.told]


def test_the_strategy_learns_from_whole_generations_only() -> None:
    random = np.random.default_rng(3)
    seen = [Observation(SPACE.parameters(SPACE.snap(random.random((1, 3)))[0]), float(each)) for each in range(20)]
    size = replay_strategy(SPACE, []).population_size
    for count in range(20):
        assert replay_strategy(SPACE, seen[:count]).generation == count // size


def test_evolution_ends_nearer_to_the_least_than_it_began() -> None:
    runs = [searched_bowl(CMASearch(SPACE, seed), 84) for seed in range(8)]
    assert np.median([np.median(values[-14:]) / np.median(values[:14]) for values in runs]) < 0.1


def test_evolution_depends_on_trials_and_seed_alone() -> None:
    searches = [CMASearch(SPACE, seed) for seed in (7, 7, 8)]
    asked = []
    for search in searches:
        searched_bowl(search, 16)
        asked.append(dict(search.ask()))
    assert asked[0] == asked[1] != asked[2]
    assert isinstance(asked[0]["g"], int)


@pytest.mark.parametrize("name", ["tpe", "random", "cmaes", "gp"])
def test_a_search_that_is_told_the_same_again_asks_the_same_again(name: str) -> None:
    first, again = (find_search(name)(SPACE, 5) for _ in range(2))
    for _ in range(14):
        x = first.ask()
        first.tell(x, bowl(x))
        y = again.ask()
        assert dict(x) == dict(y)
        again.tell(y, bowl(y))
    resumed = find_search(name)(SPACE, 5)
    for each in first.told:
        resumed.tell(each.parameters, each.objective)
    assert dict(resumed.ask()) == dict(first.ask())


def task() -> Task:
    return make_task("towel", spacing=0.04, size=(0.24, 0.5))


def options(**given: Any) -> LearnOptions:
    return LearnOptions(**{"disturbances": "none", "baselines": False, **given})


def timeless(folder: Path) -> str:
    """result.json without its times."""
    data = json.loads((folder / "result.json").read_text())
    del data["wall_seconds"]
    for record in data["trials"]:
        del record["seconds"]
    return json.dumps(data)


@pytest.mark.parametrize("sampler", ["gp", "cmaes", "lm"])
def test_a_garment_with_one_candidate_for_each_hand_is_learned(sampler: str) -> None:
    one = make_task("towel", spacing=0.06, size=(0.30, 0.50))
    assert one.fold.candidates == 1
    result = learn(one, options(trials=3, sampler=sampler, parallel=1))
    assert isinstance(result, Result)
    assert all(trial.parameters["g1"] == trial.parameters["g2"] == 0 for trial in result.trials)


@pytest.mark.parametrize("sampler", ["lm", "cmaes"])
def test_an_interrupted_study_ends_as_an_undisturbed_one(tmp_path: Path, sampler: str) -> None:
    for trials in (3, 8, 14):
        learn(task(), options(trials=trials, sampler=sampler), out=tmp_path / "paused")
    learn(task(), options(trials=14, sampler=sampler), out=tmp_path / "at-once")
    assert timeless(tmp_path / "paused") == timeless(tmp_path / "at-once")


def test_the_method_of_li_begins_with_their_curve_at_the_corners_and_leads_down() -> None:
    result = learn(task(), options(trials=16, sampler="lm", parallel=1))
    assert isinstance(result, Result)
    assert all(trial.parameters["g1"] == trial.parameters["g2"] == 0 for trial in result.trials)
    fold = task().fold
    first = result.trials[0].parameters
    assert [first["x1"], first["z1"]] == pytest.approx(np.array(LI_2015[0]) * fold.span)
    assert result.trials[0].objective == pytest.approx(Nominal(task()).fixed(li_2015(fold)).objective)
    objectives = [trial.minimised for trial in result.trials]
    assert min(objectives[5:]) < min(objectives[:5])


def test_the_method_of_li_continues_after_a_failed_trial(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = iter(range(100))
    honest = Nominal.__call__

    def sometimes(self: Nominal, parameters: Mapping[str, float], *more: Any) -> Evaluation:
        found = honest(self, parameters, *more)
        return replace(self.fail(parameters, "blew up"), objective=3.0) if next(calls) in (2, 5) else found

    monkeypatch.setattr(Nominal, "__call__", sometimes)
    result = learn(task(), options(trials=8, sampler="lm", parallel=1))
    assert isinstance(result, Result)
    assert sum(trial.state == "failed" for trial in result.trials) == 2
    assert len({json.dumps(trial.parameters) for trial in result.trials}) == 8
