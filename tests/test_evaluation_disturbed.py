"""Learning under disturbances: worlds are simulated where they decide, and the same study comes out again."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import optuna
import pytest

from tatamu import (
    CoarseFirst,
    Disturbances,
    Disturbed,
    InputError,
    LearnOptions,
    Limits,
    Nominal,
    Result,
    Score,
    Task,
    learn,
    load_disturbances,
)
from tatamu.evaluation import NOTHING, Evaluation, Evaluator, Incumbent, on_coarser_mesh
from tatamu.evaluation.disturbances import World
from tatamu.evaluation.disturbed import LEAST_GAIN
from tatamu.folding.parameters import arched_inwards, later_curves
from tatamu.report.page import page
from tatamu.search import HIGH, LOW, Proposal
from tests.small_studies import X, learn_plain, over_worlds, timeless, towel

GOOD = Score(
    objective=1.0,
    trajectory_length=0.5,
    shape_distance=50.0,
    mean_vertex_distance=0.0,
    mask_iou=1.0,
    area_error=0.0,
    slip=0.0,
    residual_bend=0.0,
)


class Known(Nominal):
    """A fold that is as good as `nominal` says, and worse by how far its hands are off."""

    nominal = 1.0
    error: str | None = None
    asked: list[World]

    def __init__(self, task: Task, nominal: float = 1.0, asked: list[World] | None = None) -> None:
        super().__init__(task)
        object.__setattr__(self, "nominal", nominal)
        object.__setattr__(self, "asked", [] if asked is None else asked)

    def __call__(self, parameters: Mapping[str, int | float], beat: Incumbent = NOTHING) -> Evaluation:
        return self.at(parameters, self.nominal)

    def at(self, parameters: Mapping[str, int | float], value: float) -> Evaluation:
        return Evaluation(dict(parameters), 0.5, value, value, GOOD.model_copy(update={"objective": value}))

    def on(self, task: Task) -> Known:
        return Known(task, self.nominal, self.asked)

    def in_world(self, parameters: Mapping[str, int | float], world: World) -> Evaluation:
        self.asked.append(world)
        return self.at(parameters, 1.0 + abs(world["hands.offset.along"]))


class Fragile(Known):
    """One that does not hold where its hands are off at all: there its errors count twice. The yardstick holds."""

    def in_world(self, parameters: Mapping[str, int | float], world: World) -> Evaluation:
        found = super().in_world(parameters, world)
        assert found.score is not None
        if parameters != X:
            self.asked.remove(world)
            return found
        return replace(found, score=found.score.model_copy(update={"mask_iou": 0.0}))


class Failing(Known):
    def __call__(self, parameters: Mapping[str, int | float], beat: Incumbent = NOTHING) -> Evaluation:
        return Evaluation(dict(parameters), 0.5, 9.0, 9.0, None, "tore")


OTHER = {**X, "z1": X["z1"] + 0.01}


@pytest.fixture(autouse=True)
def _one_after_another(monkeypatch: pytest.MonkeyPatch) -> None:
    """Worlds are simulated in one thread, so that the order in which they are asked for is known."""
    monkeypatch.setattr("tatamu.evaluation.disturbed.processors", lambda: 1)


HANDS_OFF = Disturbances.model_validate({"hands": {"offset": [0.1, 0, 0]}})


def disturbed(inner: Evaluator | None = None, worlds: int = 12, quantile: float | None = None) -> Disturbed:
    usual = Known(towel()) if quantile is None else Fragile(towel())
    return Disturbed(inner or usual, HANDS_OFF, quantile, worlds)


def asked(evaluator: Disturbed) -> list[World]:
    assert isinstance(evaluator.inner, Known)
    return evaluator.inner.asked


def offsets(evaluator: Disturbed) -> list[float]:
    return [abs(world["hands.offset.along"]) for world in evaluator.sample]


def test_the_first_trial_is_simulated_in_all_worlds() -> None:
    evaluator = disturbed()
    found = evaluator(X)
    assert asked(evaluator) == list(evaluator.sample) and found.simulations == 13
    assert found.objective == pytest.approx(1.0 + np.mean(offsets(evaluator)))
    assert found.nominal == 1.0 and found.cost == found.objective - 1.0


def test_a_quantile_takes_the_place_of_the_mean() -> None:
    """Nominally l_x = 0.5 and alpha D = 0.5; twice what they are in a world in which the fold does not hold."""
    evaluator = disturbed(quantile=0.9)
    doubled = [0.5 + 2.0 * (0.5 + each) for each in offsets(evaluator)]
    assert evaluator(X).objective == pytest.approx(np.quantile(doubled, 0.9, method="weibull"))


def test_folds_that_hold_are_compared_by_their_nominal_objective_alone() -> None:
    """Their hardest worlds are known all the same, for others may fail there."""
    evaluator = disturbed(Known(towel(), 1.2), quantile=0.9)
    found = evaluator(X)
    assert found.objective == found.nominal == 1.2 and found.cost == 0.0
    off = offsets(evaluator)
    assert list(found.hardest) == sorted(range(12), key=lambda number: -off[number])
    assert evaluator(X, Incumbent(1.1)).simulations == 1


def test_another_world_is_beyond_the_quantile_as_often_as_it_says() -> None:
    """Of 20 and one more, 1 of 21 is beyond the worst of the 20, and 2 beyond the second."""
    assert disturbed(worlds=20, quantile=0.95).aggregate(range(20)) == pytest.approx(0.95 * 19 + 0.05 * 18)
    assert disturbed(worlds=4, quantile=0.95).aggregate(range(4)) == 3.0
    assert [disturbed(worlds=n, quantile=0.95).n_tail_worlds for n in (1, 4, 20, 40)] == [1, 1, 2, 3]


@pytest.mark.parametrize(
    ("distance", "overlap", "objective"), [(0.0124, 0.81, 1.3), (0.0126, 0.81, 2.1), (0.0124, 0.79, 2.1)]
)
def test_errors_of_a_fold_that_does_not_hold_count_twice(distance: float, overlap: float, objective: float) -> None:
    changes = {"objective": 1.3, "mean_vertex_distance": distance, "mask_iou": overlap}
    measured = Evaluation(X, 0.5, 1.3, 1.3, GOOD.model_copy(update=changes))
    assert disturbed()._penalise(measured) == pytest.approx(objective)
    assert disturbed()._penalise(Evaluation(X, 0.5, 9.0, 9.0, None, "torn")) == 9.0


class Beaten(Fragile):
    """One that the arched curve, the yardstick, does as badly as in some worlds."""

    def in_world(self, parameters: Mapping[str, int | float], world: World) -> Evaluation:
        found = super().in_world(parameters, world)
        lost = parameters == X or world["hands.offset.along"] > 0.0
        assert found.score is not None
        return replace(found, score=found.score.model_copy(update={"mask_iou": 0.0 if lost else 1.0}))


def test_a_fold_need_hold_only_where_the_yardstick_does() -> None:
    evaluator = disturbed(Beaten(towel()), quantile=0.9)
    own = [2.0 * abs(off) for world in evaluator.sample if (off := world["hands.offset.along"]) <= 0.0]
    expected = np.quantile([*(1.5 + each for each in own), *[1.0] * (12 - len(own))], 0.9, method="weibull")
    assert evaluator(X).objective == pytest.approx(expected)
    lost = disturbed(Fragile(towel()), quantile=0.9)
    assert lost(X).objective > evaluator(X).objective, "it holds in every world"
    assert lost.yardstick is not None and lost(lost.yardstick).objective == 1.0


class Lost(Known):
    """One that holds in no disturbed world, whatever the manipulation."""

    def in_world(self, parameters: Mapping[str, int | float], world: World) -> Evaluation:
        return replace(super().in_world(parameters, world), score=None)


def test_the_yardstick_is_simulated_once_in_each_world() -> None:
    evaluator = disturbed(Lost(towel()), quantile=0.9)
    assert evaluator.yardstick is not None
    evaluator(evaluator.yardstick)
    assert asked(evaluator) == list(evaluator.sample)


def test_the_yardstick_is_the_first_curve_that_succeeds_without_disturbances() -> None:
    arched, high = arched_inwards(towel().fold), later_curves(towel().fold)[1]

    class Low(Known):
        """One whose hands must rise high."""

        def __call__(self, parameters: Mapping[str, int | float], beat: Incumbent = NOTHING) -> Evaluation:
            found = super().__call__(parameters, beat)
            return found if parameters["z1"] >= high["z1"] else replace(found, score=None, error="torn")

    assert disturbed(Known(towel())).yardstick == arched
    assert disturbed(Low(towel())).yardstick == high


def test_a_yardstick_that_fails_without_disturbances_says_nothing() -> None:
    class Torn(Beaten):
        def __call__(self, parameters: Mapping[str, int | float], beat: Incumbent = NOTHING) -> Evaluation:
            found = super().__call__(parameters, beat)
            return found if parameters == X else replace(found, score=None, error="torn")

    assert disturbed(Torn(towel()), quantile=0.9)(X) == disturbed(quantile=0.9)(X)


def test_a_hand_that_cannot_do_its_part_loses_its_world_without_a_simulation() -> None:
    beside = Disturbances.model_validate({"grasp": {"along": 0.1}})
    evaluator = Disturbed(Known(towel()), beside, None, 8)
    found = evaluator(X)
    misses = 8 - len(asked(evaluator))
    failed = evaluator.fail(X, "missed").nominal
    assert misses > 0 and found.simulations == 9
    assert found.objective == pytest.approx((misses * failed + (8 - misses)) / 8)


def test_a_trial_whose_nominal_fold_is_worse_is_simulated_once() -> None:
    evaluator = disturbed()
    found = evaluator(X, Incumbent(0.95, 0.07))
    assert not asked(evaluator) and found.simulations == 1 and found.objective == pytest.approx(1.07)


def test_a_trial_that_could_gain_only_a_little_is_simulated_once() -> None:
    evaluator = disturbed()
    little = evaluator(X, Incumbent(1.0 / (1.0 - 0.9 * LEAST_GAIN), 0.0))
    assert not asked(evaluator) and little.simulations == 1
    assert little.objective == 1.0 / (1.0 - 0.9 * LEAST_GAIN), "it is no better than the best trial"
    evaluator(X, Incumbent(1.0 / (1.0 - 1.1 * LEAST_GAIN), 0.0))
    assert asked(evaluator)
    below_zero = disturbed(Known(towel(), -1.0))
    assert below_zero(X, Incumbent(-1.0 - 0.9 * LEAST_GAIN)).simulations == 1
    assert below_zero(X, Incumbent(-1.0 + 0.9 * LEAST_GAIN)).simulations == 1


def test_a_trial_ends_when_it_can_no_longer_win() -> None:
    evaluator = disturbed()
    hard_first = (1, 0, *range(2, 12))
    found = evaluator(X, Incumbent(1.0051, 0.0, hard_first))
    assert len(asked(evaluator)) == 1 and found.simulations == 2 and found.objective > 1.0051
    whole = evaluator(X, Incumbent(2.0, 0.0))
    assert whole.simulations == 13 and whole.objective < 2.0


@pytest.mark.parametrize(("quantile", "part"), [(None, 0.6), (0.9, 0.9)])
def test_the_hardest_worlds_come_first_and_end_a_trial_sooner(quantile: float | None, part: float) -> None:
    evaluator = disturbed(quantile=quantile)
    whole = evaluator(X)
    off = offsets(evaluator)
    assert list(whole.hardest) == sorted(range(12), key=lambda number: -off[number])
    better = Incumbent(1.0 + part * (whole.objective - 1.0), 0.0)
    asked(evaluator).clear()
    in_order = evaluator(X, better)
    assert asked(evaluator) == list(evaluator.sample)[: len(asked(evaluator))]
    asked(evaluator).clear()
    sooner = evaluator(X, replace(better, hardest=whole.hardest))
    assert asked(evaluator) == [evaluator.sample[number] for number in whole.hardest[: len(asked(evaluator))]]
    assert sooner.simulations < in_order.simulations and sooner.hardest == ()
    assert better.objective <= sooner.objective <= whole.objective + 1e-9


def test_the_hardest_few_worlds_are_enough_for_a_quantile() -> None:
    evaluator = disturbed(quantile=0.9)
    whole = evaluator(X)
    asked(evaluator).clear()
    assert len(whole.failed_in) == 12
    raced = evaluator.incumbent([replace(whole, failed_in=())], OTHER).hardest
    half = evaluator(X, Incumbent(2.0, 0.0, raced))
    assert len(asked(evaluator)) == 6 and half.simulations == 7
    assert (half.objective, half.hardest) == (whole.objective, whole.hardest[:6])


def test_the_worlds_that_were_hardest_for_any_trial_are_simulated() -> None:
    high, low = (
        Evaluation(X, 0.5, objective, 1.0, GOOD, hardest=hardest)
        for objective, hardest in ((1.1, (6, 0, 8, 19, 4, 10)), (1.2, (4, 10, 13, 3, 6, 0)))
    )
    lost = Evaluation(X, 0.5, 1.05, 1.0, GOOD)
    quantile = disturbed(worlds=20, quantile=0.95).incumbent([low, lost, high], OTHER)
    assert quantile.hardest == (6, 4, 0, 10, 8, 13), "no more than three times the tail"
    assert (quantile.objective, quantile.cost) == (1.1, pytest.approx(0.1)), "one that ended early has not won"
    assert disturbed(worlds=20).incumbent([high, low], OTHER).hardest == (6, 4, 0, 10, 8, 13, 19, 3), (
        "the mean takes all"
    )
    assert disturbed().incumbent([], X) == disturbed().incumbent([lost], OTHER) == NOTHING, "nothing is known of worlds"


def test_a_trial_is_simulated_in_every_world_in_which_a_known_trial_failed() -> None:
    evaluator = disturbed(worlds=20, quantile=0.95)
    best = Evaluation(X, 0.5, 1.1, 1.0, GOOD, hardest=(6, 0, 8, 19, 4, 10, 2))
    ended = [Evaluation(OTHER, 0.5, 1.2, 1.0, GOOD, failed_in=failed) for failed in ((3, 5), (5, 11))]
    third = {**X, "z1": X["z1"] + 0.02}
    assert evaluator.incumbent([best, *ended], third).hardest == (5, 3, 11, 6, 0, 8), "the most often failed come first"
    many = replace(ended[0], failed_in=tuple(range(9)))
    assert evaluator.incumbent([best, many], third).hardest == tuple(range(9)), "none of them is left out"


def test_a_coarse_trial_is_simulated_in_the_harder_half_of_the_worlds_and_a_fine_trial_in_few() -> None:
    evaluator = disturbed(worlds=20, quantile=0.95)
    hardest = (6, 0, *(number for number in range(20) if number not in (6, 0)))
    known = [
        Evaluation(X, 0.5, 1.1, 1.0, GOOD, hardest=hardest, fidelity=LOW),
        Evaluation(OTHER, 0.5, 1.2, 1.0, GOOD, failed_in=(13,), fidelity=LOW),
    ]
    worlds = (13, *(number for number in hardest if number != 13))
    third = {**X, "z1": X["z1"] + 0.02}
    assert evaluator.incumbent(known, Proposal(third, LOW)).hardest == worlds[:10]
    assert evaluator.incumbent(known, Proposal(third, HIGH)).hardest == worlds[:6]
    often = [*known, replace(known[1], failed_in=tuple(range(12)))]
    assert evaluator.incumbent(often, Proposal(third, LOW)).hardest == (*range(12), 13), "none of them is left out"


def test_threads_change_no_result(monkeypatch: pytest.MonkeyPatch) -> None:
    for quantile in (None, 0.9):
        evaluator = disturbed(quantile=quantile)
        incumbents = (NOTHING, Incumbent(1.05, 0.0), Incumbent(2.0, 0.0, (3, 1, 4, 5)))
        alone = [evaluator(X, beat) for beat in incumbents]
        assert {each.simulations for each in alone} >= {5, 13} and alone[1].simulations < 13, "some end early"
        monkeypatch.setattr("tatamu.evaluation.disturbed.processors", lambda: 4)
        assert [evaluator(X, beat) for beat in incumbents] == alone
        monkeypatch.setattr("tatamu.evaluation.disturbed.processors", lambda: 1)


def test_the_mean_needs_all_worlds_in_any_order() -> None:
    evaluator = disturbed()
    whole = evaluator(X)
    assert evaluator(X, Incumbent(2.0, 0.0, tuple(range(11, -1, -1)))) == whole


@pytest.fixture
def two_meshes(monkeypatch: pytest.MonkeyPatch) -> None:
    """The task on cells of 40 mm is the coarser mesh of that on cells of 20 mm."""
    monkeypatch.setattr("tatamu.garments.garment.Garment.spacing_given", False)
    monkeypatch.setattr(
        "tatamu.evaluation.coarse.coarser_task",
        lambda task, settings: replace(towel(), number=task.number, state=None, plan=task.plan),
    )


def test_a_failed_trial_needs_no_worlds() -> None:
    evaluator = disturbed(Failing(towel()), worlds=4)
    found = evaluator(X)
    assert (found.objective, found.simulations, found.error, asked(evaluator)) == (9.0, 1, "tore", [])


def test_worlds_that_fail_count_with_the_penalty() -> None:
    wild = Disturbances.model_validate({"grasp": {"into": 0.05, "along": 0.2}})
    evaluator = Disturbed(Nominal(towel()), wild, None, 8)
    found = evaluator(X)
    assert found.simulations == 9 and found.objective > found.nominal + 0.1


def test_a_trial_on_the_own_mesh_has_to_beat_its_like_in_the_worlds_that_decide_on_either(two_meshes: None) -> None:
    evaluator = CoarseFirst(disturbed(Known(towel(spacing=0.02)), worlds=6, quantile=0.9))
    coarse = [Evaluation(X, 0.5, 1.1 + n, 1.0, GOOD, hardest=(n, 5), fidelity=LOW) for n in (0, 1)]
    fine = [Evaluation(X, 0.5, 1.3 + n, 1.0, GOOD, hardest=(2, 3)) for n in (0, 1)]
    first = evaluator.incumbent(coarse, Proposal(OTHER, HIGH))
    assert (first.objective, first.hardest) == (np.inf, (0, 1, 5))
    later = evaluator.incumbent([*coarse, *fine], Proposal(OTHER, HIGH))
    assert (later.objective, later.hardest) == (1.3, (0, 2, 1))
    assert evaluator.incumbent([*coarse, *fine], Proposal(OTHER, LOW)).objective == 1.1


def test_worlds_are_simulated_on_the_coarser_mesh_in_the_numbers_of_the_finer_one(two_meshes: None) -> None:
    lenient = Limits(mean_vertex_distance=1.0, mask_iou=0.0)  # on either mesh errors count once
    inner = replace(over_worlds(towel(spacing=0.02), 12), limits=lenient)
    evaluator = CoarseFirst(inner)
    assert evaluator.coarse is not None
    low = evaluator(Proposal(X, LOW))
    alone = inner(X)
    assert evaluator(Proposal(X, HIGH)).objective == alone.objective
    coarse = evaluator.coarse(on_coarser_mesh(inner.task, evaluator.coarse.task, X))
    assert low.cost == pytest.approx(evaluator.ratio * coarse.cost, rel=1e-9)
    assert 0.5 < low.cost / alone.cost < 2.0, "cells of 40 mm are a rough guess"
    calm = CoarseFirst(replace(inner, disturbances=Disturbances(), worlds=1))(Proposal(X, LOW))
    assert calm.objective == pytest.approx(calm.nominal)


@pytest.fixture(scope="module", autouse=True)
def validated_briefly() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tatamu.study.loop.VALIDATION_WORLDS", 6)
        yield


def learn_over_worlds(out: Path | None, trials: int, quantile: Any = "mean", **places: Any) -> Result:
    """Learn with the mean over few worlds."""
    options = LearnOptions(trials=trials, quantile=quantile, baselines=False)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tatamu.study.setup.Disturbed", Few)
        result = learn(towel(), options, out=out, **places)
    assert isinstance(result, Result)
    return result


@dataclass(frozen=True)
class Few(Disturbed):
    """Four worlds unless others are asked for."""

    worlds: int = 4


@pytest.fixture(scope="module")
def learned(tmp_path_factory: pytest.TempPathFactory) -> Result:
    return learn_over_worlds(tmp_path_factory.mktemp("holds"), 5)


def folder_of(result: Result) -> Path:
    assert result.folder is not None
    return result.folder


def test_the_folder_says_what_was_minimised(learned: Result) -> None:
    data = json.loads((folder_of(learned) / "result.json").read_text())
    assert Disturbances.model_validate(data["disturbances"]) == load_disturbances("default")
    best = data["trials"][data["best"]]
    assert best["expected_objective"] == min(trial["expected_objective"] for trial in data["trials"])
    assert best["worlds"] == 5 and {trial["worlds"] for trial in data["trials"]} <= set(range(6))
    assert best["objective"] == pytest.approx(best["trajectory_length"] + 0.01 * best["shape_distance"])
    assert data["judged"]["draws"] == 6
    least = learned.record.lowest_objective
    assert least is not None and least.objective == min(t["objective"] for t in data["trials"] if t["objective"])


def test_the_page_says_how_sure_the_fold_is(learned: Result) -> None:
    assert learned.held is not None and learned.held.headline in page(learned)


def test_a_study_is_the_same_in_parts_and_on_other_workers(learned: Result, tmp_path: Path) -> None:
    with ThreadPoolExecutor(1) as pool:
        learn_over_worlds(tmp_path, 2, executor=pool)
    learn_over_worlds(tmp_path, 5)
    assert timeless(tmp_path) == timeless(folder_of(learned))


def test_later_trials_are_simulated_in_the_worlds_in_which_any_failed_or_that_were_hardest(tmp_path: Path) -> None:
    curves = [{**X, "z1": height, "z2": height} for height in (0.37, 0.35, 0.33)]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(import_module("tatamu.study.learn"), "first_curves", lambda fold: [*curves, X])
        options = LearnOptions(trials=4, quantile=0.9, parallel=2, baselines=False)
        learn(towel(), options, out=tmp_path, evaluate=over_worlds(towel(), 10, 0.9))
    study = optuna.load_study(study_name=None, storage=f"sqlite:///{tmp_path}/study.db")
    first, *later = (trial.user_attrs["hardest"] for trial in study.trials)
    failed = study.trials[0].user_attrs["failed_in"]
    assert set(first) == set(range(10)), "it knows of no other"
    assert 0 < len(failed) < 10 and all(set(failed) <= set(each) != set(first) for each in later)


def test_a_study_of_other_disturbances_is_another(learned: Result) -> None:
    folder = folder_of(learned)
    for other in ({"disturbances": "none"}, {"disturbances": "default", "quantile": 0.9}, {"quantile": "mean"}):
        with pytest.raises(InputError, match="another study"):
            learn(towel(), LearnOptions(trials=6, baselines=False, **other), out=folder)


def test_a_study_that_is_resumed_keeps_its_own_disturbances(learned: Result) -> None:
    resumed = learn_over_worlds(folder_of(learned), 5, quantile=None)
    assert (resumed.record.worlds, resumed.record.quantile) == (4, None)


def test_where_nothing_is_disturbed_nothing_is_said_of_it(tmp_path: Path) -> None:
    learn_plain(towel(), tmp_path, trials=2, baselines=False)
    text = (tmp_path / "result.json").read_text()
    assert not any(word in text for word in ("worlds", "disturbances", "expected", "judged", "quantile"))
    again = learn(towel(), LearnOptions(trials=2, baselines=False), out=tmp_path)
    assert isinstance(again, Result) and again.record.disturbances is None


def test_quantiles_are_shares() -> None:
    for make in (lambda: LearnOptions(quantile=1.0), lambda: over_worlds(towel(), quantile=1.0)):
        with pytest.raises(InputError, match="quantile"):
            make()
    with pytest.raises(InputError, match="worlds"):
        over_worlds(towel(), worlds=0)
