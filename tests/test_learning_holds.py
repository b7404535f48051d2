"""Learning in expectation: worlds are simulated where they decide, and the same study comes out again."""

from __future__ import annotations

import json
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import optuna
import pytest
from tatamu.folding.coarser import larger_on_finer_mesh, on_coarser_mesh
from tatamu.learning import Expectation, as_begun, learn
from tatamu.learning.evaluation import submitted
from tatamu.learning.expectation import Added, Demand, Expected, Standing, counted, expected
from tatamu.learning.place import NAME
from tatamu.results import ResultFolder, read_fold

from tatamu import InputError
from tatamu.disturbances import CALM, Disturbances, Limits, World, load_disturbances
from tatamu.folding.manipulation import Manipulation
from tatamu.folding.score import Score
from tatamu.folding.task import Outcome, Task
from tatamu.report.page import page
from tests.test_learning import task, timeless

X = {"x1": 0.05, "z1": 0.2, "x2": 0.4, "z2": 0.1, "g1": 0, "g2": 0}


def usual(**more: Any) -> Expectation:
    disturbances = load_disturbances("default")
    assert disturbances is not None
    return Expectation(disturbances, **{"worlds": 4, **more})


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[World]:
    """Worlds that were simulated, in which a fold is worse by how far its hands are off upwards."""
    worlds: list[World] = []

    def known(task: Task, manipulation: Manipulation, world: World) -> Outcome:
        worlds.append(world)
        return Outcome(None, 1.0 + abs(world["hands.offset.up"]), None, None)

    monkeypatch.setattr("tatamu.learning.expectation.outcome_in", known)
    return worlds


class Calm(Outcome):
    @property
    def failed(self) -> bool:
        return False


def found(standing: Standing | None, hardest: tuple[int, ...] = (), **more: Any) -> Any:
    expectation = Expectation(Disturbances.model_validate({"hands": {"offset": [0, 0, 0.1]}}), worlds=12, **more)
    demand = Demand(expectation, expectation.drawn(0), standing, hardest)
    small = task()
    return expected(small, small.manipulation(X), Calm(None, 1.0, None, None), demand), demand


def test_the_first_trial_is_simulated_in_all_worlds(asked: list[World]) -> None:
    result, demand = found(None)
    assert asked == list(demand.worlds) and result.worlds == 13
    assert result.objective == pytest.approx(1.0 + np.mean([abs(w["hands.offset.up"]) for w in asked]))


def test_a_quantile_takes_the_place_of_the_mean(asked: list[World]) -> None:
    result, demand = found(None, quantile=0.9)
    assert result.objective == pytest.approx(
        np.quantile([1 + abs(w["hands.offset.up"]) for w in demand.worlds], 0.9, method="weibull")
    )


def test_another_world_is_beyond_the_quantile_as_often_as_it_says() -> None:
    """Of 20 and one more, 1 of 21 is beyond the worst of the 20, and 2 beyond the second."""
    assert usual(worlds=20, quantile=0.95).of(range(20)) == pytest.approx(0.95 * 19 + 0.05 * 18)
    assert usual(worlds=4, quantile=0.95).of(range(4)) == 3.0
    assert [usual(worlds=n, quantile=0.95).making for n in (1, 4, 20, 40)] == [1, 1, 2, 3]


def test_later_steps_look_for_folds_that_hold_in_more_worlds() -> None:
    first, second = (usual(quantile=0.9, worlds=20).of_step(step) for step in (1, 2))
    assert (first.quantile, first.worlds) == (0.9, 20)
    assert (second.quantile, second.worlds) == (pytest.approx(0.95), 40)
    assert second.drawn(0)[:20] == first.drawn(0)
    assert usual().of_step(2) == usual()


def test_later_steps_are_asked_in_more_worlds_on_their_own_mesh() -> None:
    usually = usual(worlds=20, quantile=0.95)
    assert [usually.checked(step) for step in (1, 2, 3)] == [2, 8, 8]


@pytest.mark.parametrize(
    ("distance", "overlap", "objective"), [(0.0124, 0.81, 1.3), (0.0126, 0.81, 2.1), (0.0124, 0.79, 2.1)]
)
def test_errors_of_a_fold_that_does_not_hold_count_twice(distance: float, overlap: float, objective: float) -> None:
    measured = Score(1.3, 0.5, 80.0, distance, overlap, 0.0, 0.0, 0.0)
    assert counted(Outcome(measured, 1.3, None, None)) == pytest.approx(objective)
    assert counted(Outcome(None, 9.0, "torn", None)) == 9.0


def test_a_trial_that_is_worse_where_nothing_is_off_is_simulated_once(asked: list[World]) -> None:
    result, _ = found(Standing(0.95, 0.07))
    assert not asked and result.worlds == 1 and result.objective == pytest.approx(1.07)


def test_a_trial_ends_when_it_can_no_longer_win(asked: list[World]) -> None:
    result, _ = found(Standing(1.0001, 0.0))
    assert len(asked) == 1 and result.worlds == 2 and result.objective > 1.0001
    whole, _ = found(Standing(2.0, 0.0))
    assert whole.worlds == 13 and whole.objective < 2.0


@pytest.mark.parametrize("quantile", [None, 0.9])
def test_the_hardest_worlds_come_first_and_end_a_trial_sooner(asked: list[World], quantile: float | None) -> None:
    whole, demand = found(None, quantile=quantile)
    offsets = [abs(world["hands.offset.up"]) for world in demand.worlds]
    assert list(whole.hardest) == sorted(range(12), key=lambda number: -offsets[number])
    better = Standing(1.0 + 0.6 * (whole.objective - 1.0), 0.0)
    asked.clear()
    in_order, _ = found(better, quantile=quantile)
    assert asked == list(demand.worlds)[: len(asked)]
    asked.clear()
    sooner, _ = found(better, whole.hardest, quantile=quantile)
    assert asked == [demand.worlds[number] for number in whole.hardest[: len(asked)]]
    assert sooner.worlds < in_order.worlds and sooner.hardest == ()
    assert better.expected <= sooner.objective <= whole.objective + 1e-9


def test_the_hardest_few_worlds_are_enough_for_a_quantile(asked: list[World]) -> None:
    whole, demand = found(None, quantile=0.9)
    asked.clear()
    half, _ = found(Standing(2.0, 0.0), demand.expectation.hardest([whole.hardest]), quantile=0.9)
    assert len(asked) == 4 and half.worlds == 5
    assert (half.objective, half.hardest) == (whole.objective, whole.hardest[:4])


def test_the_worlds_that_were_hardest_for_any_trial_are_simulated() -> None:
    high, low = (6, 0, 8, 19, 4, 10), (4, 10, 13, 3, 6, 0)
    assert usual(worlds=20, quantile=0.95).hardest([high, low]) == (6, 4, 0, 10, 8, 13, 19, 3)
    assert usual(worlds=6).hardest([high, low]) == (6, 4, 0, 10, 8, 13, 19, 3), "the mean takes all"
    assert usual().hardest([]) == ()


def test_the_mean_needs_all_worlds_in_any_order(asked: list[World]) -> None:
    whole, _ = found(None)
    assert found(Standing(2.0, 0.0), tuple(range(11, -1, -1)))[0] == whole


def test_worlds_that_were_simulated_on_the_coarser_mesh_are_not_simulated_again(
    asked: list[World], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Task, "evaluate", lambda *_: Calm(None, 1.5, None, None))
    own = replace(task(spacing=0.02), coarser=task())
    demand = Demand(usual(), usual().drawn(0), added=Added(0.25, 5, (3, 1, 0, 2)))
    with ThreadPoolExecutor(1) as pool:
        fine = submitted(pool, own, own.manipulation(X), np.inf, X, demand=demand).ended("")
    assert not asked and fine.expected == Expected(1.75, 5, (3, 1, 0, 2))


def test_the_hardest_worlds_are_simulated_on_the_own_mesh_too(
    asked: list[World], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The coarser mesh adds too little for this fold, and its worst worlds are not those of the own mesh."""
    monkeypatch.setattr(Task, "evaluate", lambda *_: Calm(None, 1.0, None, None))
    own = replace(task(spacing=0.02), coarser=task(), step=(2, 2))
    expectation = usual(worlds=12, quantile=0.9)
    worlds = expectation.drawn(0)
    offsets = [abs(world["hands.offset.up"]) for world in worlds]
    worst = tuple(sorted(range(12), key=lambda number: -offsets[number]))[:6]
    coarsely = worst[::-1]

    def fine(added: float, standing: Standing | None = None) -> Expected | None:
        asked.clear()
        demand = Demand(expectation, worlds, standing, added=Added(added, 7, coarsely))
        with ThreadPoolExecutor(1) as pool:
            return submitted(pool, own, own.manipulation(X), np.inf, X, demand=demand).ended("").expected

    least = fine(1e-6)
    assert least is not None and (least.worlds, least.hardest) == (13, worst)
    assert least.objective == pytest.approx(np.quantile(1.0 + np.array(offsets), 0.9, method="weibull"))
    assert asked == [worlds[number] for number in coarsely]
    assert fine(0.5) == Expected(1.5, 13, worst), "the own mesh only adds to it"
    assert fine(0.5, Standing(1.4, 0.0)) == Expected(1.5, 7, coarsely) and not asked, "it could not win"
    sooner = fine(1e-6, Standing(1.0 + 1e-5, 0.0))
    assert sooner is not None and len(asked) == sooner.worlds - 7 < 6, "it can no longer win"
    assert sorted(sooner.hardest) == sorted(coarsely)


def test_a_failed_trial_needs_no_worlds(asked: list[World]) -> None:
    small = task()
    demand = Demand(usual(), usual().drawn(0))
    result = expected(small, small.manipulation(X), Outcome(None, 9.0, "tore", None), demand)
    assert (result.objective, result.worlds, asked) == (9.0, 1, [])


def test_worlds_that_fail_count_with_the_penalty(monkeypatch: pytest.MonkeyPatch) -> None:
    small = task()
    manipulation = small.manipulation(X)
    wild = Disturbances.model_validate({"grasp": {"into": 0.05, "along": 0.2}})
    demand = Demand(Expectation(wild, worlds=8), Expectation(wild, worlds=8).drawn(0))
    calm = small.evaluate(manipulation)
    result = expected(small, manipulation, calm, demand)
    assert result.worlds == 9 and result.objective > calm.objective + 0.1


def test_worlds_are_simulated_on_the_coarser_mesh_in_the_numbers_of_the_finer_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("tatamu.learning.expectation.LIMITS", Limits(1.0, 0.0))  # on either mesh errors count once
    own = replace(task(spacing=0.02), coarser=task())
    demand = Demand(usual(worlds=12), usual(worlds=12).drawn(0))
    calm = Demand(usual(), (CALM,) * 4)
    with ThreadPoolExecutor(2) as pool:
        manipulation = own.manipulation(X)
        fine = submitted(pool, own, manipulation, np.inf, X, demand=demand).ended("")
        still = submitted(pool, own, manipulation, np.inf, X, demand=calm).ended("")
        alone = submitted(pool, own, manipulation, demand=demand).ended("")
        coarse = submitted(pool, task(), on_coarser_mesh(own, manipulation, X), demand=demand).ended("")
    assert fine.expected is not None and still.expected is not None and alone.expected is not None
    assert coarse.expected is not None
    assert still.expected.objective == pytest.approx(still.outcome.objective)
    added = fine.expected.objective - fine.outcome.objective
    there = coarse.expected.objective - coarse.outcome.objective
    assert added == pytest.approx(larger_on_finer_mesh(own) * there, rel=1e-9)
    assert 0.5 < added / (alone.expected.objective - alone.outcome.objective) < 2.0, "cells of 40 mm are a rough guess"


@pytest.fixture(scope="module", autouse=True)
def judged_briefly() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tatamu.learning.runner.JUDGED", 6)
        yield


@pytest.fixture(scope="module")
def learned(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("holds")
    learn(task(), folder, trials=5, expectation=usual(), baselines=False)
    return folder


def test_the_folder_says_what_was_expected(learned: Path) -> None:
    data = json.loads((learned / "result.json").read_text())
    assert Disturbances.model_validate(data["disturbances"]) == load_disturbances("default")
    best = data["trials"][data["best"]]
    assert best["expected_objective"] == min(trial["expected_objective"] for trial in data["trials"])
    assert best["worlds"] == 5 and {trial["worlds"] for trial in data["trials"]} <= {0, 1, 5}
    assert best["objective"] == pytest.approx(best["trajectory_length"] + 0.01 * best["shape_distance"])
    assert data["judged"]["draws"] == 6
    least = ResultFolder(learned).result.least_objective
    assert least is not None and least.objective == min(t["objective"] for t in data["trials"] if t["objective"])


def test_the_page_says_how_sure_the_fold_is(learned: Path) -> None:
    judged = ResultFolder(learned).result.judged
    assert judged is not None and judged.headline in page(read_fold(learned))


def test_a_study_is_the_same_in_parts_and_on_other_workers(learned: Path, tmp_path: Path) -> None:
    with ThreadPoolExecutor(1) as pool:
        learn(task(), tmp_path, trials=2, expectation=usual(), baselines=False, executor=pool)
    learn(task(), tmp_path, trials=5, expectation=usual(), baselines=False)
    assert timeless(tmp_path) == timeless(learned)


def test_later_trials_are_simulated_in_the_worlds_that_were_hardest_for_any_before(tmp_path: Path) -> None:
    expectation = usual(worlds=10, quantile=0.9)
    high = {**X, "z1": 0.35, "z2": 0.35}
    low = {**X, "x1": 0.0, "z1": 0.05, "z2": 0.0}
    learn(task(), tmp_path, trials=4, first=[high, low, X, X], parallel=2, expectation=expectation, baselines=False)
    study = optuna.load_study(study_name=NAME, storage=f"sqlite:///{tmp_path}/study.db")
    orders = [trial.user_attrs["hardest"] for trial in study.trials]
    assert set(orders[0]) == set(orders[1]) == set(range(10)), "they know of no other"
    assert set(orders[3]) == {*orders[0][:4], *orders[1][:4]} != {*orders[0][:4]}


def test_a_study_of_other_disturbances_is_another(learned: Path) -> None:
    for other in (None, usual(quantile=0.9), usual(worlds=8)):
        with pytest.raises(InputError, match="another study"):
            learn(task(), learned, trials=6, expectation=other)
    assert as_begun(learned) == (True, usual())


def test_where_nothing_is_off_nothing_is_said_of_it(tmp_path: Path) -> None:
    learn(task(), tmp_path, trials=2, baselines=False)
    text = (tmp_path / "result.json").read_text()
    assert not any(word in text for word in ("worlds", "disturbances", "expected", "judged", "quantile"))
    assert as_begun(tmp_path) == (True, None)


def test_quantiles_are_shares() -> None:
    with pytest.raises(InputError, match="quantile"):
        usual(quantile=1.0)
