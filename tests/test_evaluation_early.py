"""Searches of many layers: a trial that can no longer win ends when its hands have arrived."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tatamu import CoarseFirst, LearnOptions, Nominal, Result, Task, learn, make_task
from tatamu.evaluation import Evaluation, Evaluator, Incumbent, ends_early
from tatamu.folding.fold import ideal_folds
from tatamu.folding.score import score
from tatamu.study.options import USUAL_PENDING
from tatamu.study.setup import make_evaluator, resolve
from tests.small_studies import X, over_worlds, plain, towel

TRIALS = 10
EARLY = Nominal(towel(), ends_early=True)
"""A task whose trials may end early; a towel, for the sake of time."""


@pytest.fixture(scope="module")
def whole() -> Evaluation:
    return EARLY(X)


def test_a_trial_that_cannot_win_ends_as_its_hands_have_arrived(whole: Evaluation) -> None:
    manipulation = EARLY.task.manipulation(X)
    assert whole.rollout is not None and whole.ended is None
    frame = np.searchsorted(whole.rollout.times, manipulation.timing.arrives + 1e-6) - 1
    then = score(EARLY.task.fold, manipulation.trajectory_length, whole.rollout.positions[frame])
    early = EARLY(X, Incumbent(then.objective))
    assert early.ended == "arrival" and early.score == then and early.rollout is None
    still = EARLY(X, Incumbent(then.objective + 1e-9))
    assert still.ended is None and still.objective == whole.objective


def _to_beat_nothing() -> Evaluation:
    return EARLY(X)


def _of_another_task() -> Evaluation:
    return Nominal(EARLY.task)(X, Incumbent(0.0))


def _in_disturbed_worlds() -> Evaluation:
    return replace(over_worlds(EARLY.task, worlds=1), inner=EARLY)(X, Incumbent(0.0))


@pytest.mark.parametrize("evaluated", [_to_beat_nothing, _of_another_task, _in_disturbed_worlds])
def test_others_run_to_their_end(evaluated: Callable[[], Evaluation], whole: Evaluation) -> None:
    found = evaluated()
    assert found.ended is None and found.nominal == whole.objective


def test_one_that_fails_before_its_hands_have_arrived_has_failed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tatamu.evaluation.nominal._left_table", lambda *_: True)
    found = EARLY(X, Incumbent(0.0))
    assert found.failed and found.ended is None


@pytest.fixture(scope="module")
def learned(tmp_path_factory: pytest.TempPathFactory) -> Result:
    return learn_early(tmp_path_factory.mktemp("early"), TRIALS, baselines=True)


def learn_early(out: Path, trials: int, baselines: bool = False, evaluator: Evaluator = EARLY) -> Result:
    result = learn(towel(), plain(trials=trials, baselines=baselines), out=out, evaluate=evaluator)
    assert isinstance(result, Result)
    return result


def test_a_study_says_which_trials_ended_early_and_the_best_is_none_of_them(learned: Result) -> None:
    record = learned.record
    early = [trial for trial in record.trials if trial.ended == "arrival"]
    assert early and len(early) < TRIALS
    assert record.best_trial.ended is None
    for trial in early:
        known = [each.objective or np.inf for each in record.trials[: trial.number - USUAL_PENDING + 1]]
        assert known and trial.objective is not None and trial.objective >= min(known)
    assert all(baseline.state == "complete" for baseline in record.baselines)
    assert learned.folder is not None
    assert '"ended": "arrival"' in (learned.folder / "result.json").read_text()
    assert "ended when its hands had arrived" in (learned.folder / "report.html").read_text()


def test_an_interrupted_study_asks_as_much_of_its_trials_as_an_undisturbed_one(
    learned: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    beaten = []
    submit = Nominal.submit

    def remembered(self: Nominal, executor: Any, parameters: Any, beat: Incumbent, *, keep: bool = False) -> Any:
        beaten.append(beat.objective)
        return submit(self, executor, parameters, beat, keep=keep)

    monkeypatch.setattr(Nominal, "submit", remembered)
    objectives = [trial.objective or np.inf for trial in learned.trials]
    telling = range(USUAL_PENDING, TRIALS)  # after which the trials that were pending had found something better
    done = next(n for n in telling if min(objectives[:n]) < min(objectives[: n - USUAL_PENDING + 1]))
    for trials in (done, TRIALS):
        again = learn_early(tmp_path, trials)
    known = [objectives[: max(0, number - USUAL_PENDING + 1)] for number in range(TRIALS)]
    assert [each for each in beaten if each < np.inf] == [min(each) for each in known if each]
    assert [trial.objective for trial in again.trials] == objectives


def test_from_the_third_step_of_a_plan_on_trials_may_end_early() -> None:
    shop = make_task("tshirt", fold="shop")
    ideals = [fold.target for fold in ideal_folds(shop.garment, shop.plan, shop.hands)]
    states = [None, *ideals[:2]]

    def may_end_early(task: Task) -> list[bool]:
        return [ends_early(task.at(number, state)) for number, state in enumerate(states)]

    assert may_end_early(shop) == [False, False, True]
    given = make_task("tshirt", fold="shop", spacing=shop.garment.spacing)
    assert may_end_early(given) == [False, False, False], "on a mesh that the user asked for, nothing ends early"
    last = shop.at(2, states[2])
    for coarse in (True, False):
        options = resolve(LearnOptions(disturbances="none", coarse=coarse), last, None)
        evaluator = make_evaluator(last, options)
        inner = evaluator.inner if isinstance(evaluator, CoarseFirst) else evaluator
        assert isinstance(inner, Nominal) and inner.ends_early == coarse
