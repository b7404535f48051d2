"""Searches of many layers: a trial that can no longer win ends when its hands have arrived."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tatamu.folding.coarser import with_coarser
from tatamu.learning import learn
from tatamu.learning.evaluation import Evaluation, Pending, evaluate, submitted
from tatamu.learning.expectation import Demand, Standing
from tatamu.learning.learn import PENDING
from tatamu.results import ResultFolder

from tatamu.folding.fold import ideal_folds
from tatamu.folding.score import score
from tatamu.folding.task import Task, make_job
from tests.test_learning import task as small
from tests.test_learning_holds import X, usual

TRIALS = 10


@pytest.fixture(scope="module")
def many_layers() -> Task:
    """A task that says so; a towel, for the sake of time."""
    return replace(small(), ends_early=True)


@pytest.fixture(scope="module")
def whole(many_layers: Task) -> Evaluation:
    return evaluate(many_layers, many_layers.manipulation(X))


def test_a_trial_that_cannot_win_ends_as_its_hands_have_arrived(many_layers: Task, whole: Evaluation) -> None:
    manipulation = many_layers.manipulation(X)
    assert whole.outcome.rollout is not None and not whole.on_arrival
    frame = np.searchsorted(whole.outcome.rollout.times, manipulation.timing.arrives + 1e-6) - 1
    then = score(many_layers.fold, manipulation.trajectory_length, whole.outcome.rollout.positions[frame])
    early = evaluate(many_layers, manipulation, beaten=then.objective)
    assert early.on_arrival and early.outcome.score == then and early.outcome.rollout is None
    still = evaluate(many_layers, manipulation, beaten=then.objective + 1e-9)
    assert not still.on_arrival and still.objective == whole.objective


def _to_beat_nothing(task: Task) -> Evaluation:
    return evaluate(task, task.manipulation(X))


def _of_another_task(task: Task) -> Evaluation:
    return evaluate(replace(task, ends_early=False), task.manipulation(X), beaten=0.0)


def _in_disturbed_worlds(task: Task) -> Evaluation:
    expectation = usual(worlds=1)
    demand = Demand(expectation, expectation.drawn(0), Standing(0.0, 0.0))
    return evaluate(task, task.manipulation(X), demand=demand, beaten=0.0)


@pytest.mark.parametrize("evaluated", [_to_beat_nothing, _of_another_task, _in_disturbed_worlds])
def test_others_run_to_their_end(evaluated: Callable[[Task], Evaluation], many_layers: Task, whole: Evaluation) -> None:
    found = evaluated(many_layers)
    assert not found.on_arrival and found.outcome.objective == whole.objective


def test_one_that_fails_before_its_hands_have_arrived_has_failed(
    many_layers: Task, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Task, "_left_table", lambda *_: True)
    found = evaluate(many_layers, many_layers.manipulation(X), beaten=0.0)
    assert found.outcome.failed and not found.on_arrival


@pytest.fixture(scope="module")
def learned(many_layers: Task, tmp_path_factory: pytest.TempPathFactory) -> ResultFolder:
    folder = tmp_path_factory.mktemp("early")
    learn(many_layers, folder, trials=TRIALS)
    return ResultFolder(folder)


def test_a_study_says_which_trials_ended_early_and_the_best_is_none_of_them(learned: ResultFolder) -> None:
    result = learned.result
    early = [trial for trial in result.trials if trial.ended == "arrival"]
    assert early and len(early) < TRIALS
    assert result.best_trial.ended is None
    for trial in early:
        known = [each.objective or np.inf for each in result.trials[: trial.number - PENDING + 1]]
        assert known and trial.objective is not None and trial.objective >= min(known)
    assert all(baseline.state == "complete" for baseline in result.baselines)
    assert '"ended": "arrival"' in learned.result_file.read_text()
    assert "ended when its hands had arrived" in learned.report_file.read_text()


def test_an_interrupted_study_asks_as_much_of_its_trials_as_an_undisturbed_one(
    learned: ResultFolder, many_layers: Task, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    beaten = []

    def remembered(*arguments: Any, **options: Any) -> Pending:
        beaten.append(options.get("beaten", np.inf))
        return submitted(*arguments, **options)

    monkeypatch.setattr("tatamu.learning.runner.submitted", remembered)
    objectives = [trial.objective or np.inf for trial in learned.result.trials]
    telling = range(PENDING, TRIALS)  # after which the trials that were pending had found something better
    done = next(n for n in telling if min(objectives[:n]) < min(objectives[: n - PENDING + 1]))
    for trials in (done, TRIALS):
        learn(many_layers, tmp_path, trials=trials, baselines=False)
    known = [objectives[: max(0, number - PENDING + 1)] for number in range(TRIALS)]
    assert [each for each in beaten if each < np.inf] == [min(each) for each in known if each]
    assert [trial.objective for trial in ResultFolder(tmp_path).result.trials] == objectives


def test_from_the_third_step_of_a_plan_on_trials_may_end_early() -> None:
    plain = make_job("tshirt", fold="shop")
    ideals = [fold.target for fold in ideal_folds(plain.garment, plain.plan, plain.hands)]
    states = [None, *ideals[:2]]
    for job, early in ((with_coarser(plain), [False, False, True]), (plain, [False, False, False])):
        assert [job.task(number, state).ends_early for number, state in enumerate(states)] == early
