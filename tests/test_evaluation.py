"""Evaluators: scenarios of an orthogonal array, the rule of their values, the aim, and causes of failure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tatamu import Ask, Evaluation, InputError, LearnOptions, Nominal, Scenarios, learn
from tatamu.evaluation.array import orthogonal_array
from tatamu.evaluation.disturbances import Disturbances, Scenario, default_disturbances, disturbed_hands, hand_failure
from tatamu.evaluation.disturbances.aim import aim_for
from tatamu.evaluation.disturbances.scenario import deviations, sample_scenarios
from tatamu.evaluation.evaluator import Evaluator
from tatamu.evaluation.outcome import (
    BESIDE_CLOTH,
    BESIDE_TARGET,
    CRUSHED,
    HELP,
    SLIPPED,
    TABLE,
    UNDONE,
    UNSIMULATED,
    Outcome,
)
from tatamu.evaluation.scenarios import array_scenarios
from tatamu.folding.aim import Aim
from tatamu.folding.fingers import Fingers
from tatamu.folding.parameters import arched_inwards, initial_curves
from tatamu.folding.score import ALPHA, Limits, Score, score
from tatamu.folding.task import Task
from tatamu.search import Parameters
from tatamu.simulation.rollout import Rollout
from tatamu.study.loop import order_scenarios
from tatamu.study.result import Result
from tests.small_studies import X, plain, towel

GOOD = {"trajectory_length": 0.5, "shape_distance": 0.1, "mask_iou": 0.95, "area_error": 0.0, "slip": 0.0}


def evaluation(parameters: Parameters, objective: float, distance: float = 0.001) -> Evaluation:
    found = Score(objective=objective, mean_vertex_distance=distance, residual_bend=0.0, **GOOD)
    return Evaluation(parameters, 0.5, objective, objective, found)


class Scripted(Nominal):
    """An evaluator whose fold has a given objective, and fails in given scenarios."""

    def __init__(self, objective: float, failing: set[int] = frozenset(), distance: float = 0.001) -> None:  # type: ignore[assignment]
        super().__init__(towel())
        self.__dict__.update(objective=objective, failing=failing, distance=distance, asked=[])

    def __call__(self, ask: Ask | Mapping[str, int | float]) -> Evaluation:
        return evaluation(Ask.of(ask).parameters, self.__dict__["objective"], self.__dict__["distance"])

    def simulate(self, parameters: Mapping[str, int | float], scenario: Scenario) -> Evaluation:
        index = SCENARIOS.index(scenario)
        self.__dict__["asked"].append(index)
        far = 0.1 if index in self.__dict__["failing"] else 0.001
        return evaluation(dict(parameters), 1.0, far)


DISTURBANCES = default_disturbances()
SCENARIOS = array_scenarios(DISTURBANCES)
SPAN = ALPHA * len(towel().fold.start) * Limits().mean_vertex_distance


@pytest.mark.parametrize("columns", range(1, 48))
def test_arrays_are_balanced_and_orthogonal_with_the_next_multiple_of_four_above(columns: int) -> None:
    array = orthogonal_array(columns)
    assert array.shape == (4 * (columns // 4 + 1), columns)
    assert (array.T @ array == len(array) * np.eye(columns)).all()
    assert not array.sum(axis=0).any()


def test_scenarios_have_every_disturbance_at_plus_or_minus_the_level() -> None:
    known = deviations(DISTURBANCES)
    found = array_scenarios(DISTURBANCES, 2.0)
    assert len(found) == 20 and len(known) == 19
    for name, deviation in known.items():
        assert sorted({round(each[name] / deviation, 9) for each in found}) == [-2.0, 2.0]
    assert found == array_scenarios(DISTURBANCES, 2.0)


def test_correlated_disturbances_keep_their_covariance() -> None:
    names = ["hands.offset.along", "hands.offset.across"]
    given = Disturbances.model_validate(
        {
            "hands": {"offset": [0.004, 0.002, 0.001]},
            "correlation": {"parameters": names, "matrix": [[1.0, 0.8], [0.8, 1.0]]},
        }
    )
    values = np.array([[each[name] for name in names] for each in array_scenarios(given, 1.0)])
    assert values.T @ values / len(values) == pytest.approx(np.array([[16.0, 6.4], [6.4, 4.0]]) * 1e-6)


def test_no_disturbance_is_refused() -> None:
    with pytest.raises(InputError, match="deviation above 0"):
        array_scenarios(Disturbances())


@pytest.mark.parametrize(("objective", "value"), [(0.95, 0.95), (0.9, 0.9), (0.899, 0.9)])
def test_a_fold_that_gains_less_than_half_a_per_cent_is_not_simulated_in_scenarios(
    objective: float, value: float
) -> None:
    inner = Scripted(objective)
    found = Scenarios(inner, DISTURBANCES)(Ask(X, beat=0.9))
    assert (found.objective, found.nominal, inner.__dict__["asked"]) == (value, objective, [])


def test_the_value_falls_with_the_scenarios_passed_and_never_beats_the_best() -> None:
    scenarios, values = tuple(range(10)), []
    for failing in (9, 5, 0):
        found = Scenarios(Scripted(0.5, {failing}), DISTURBANCES)(Ask(X, scenarios, beat=0.8))
        assert found.failed_in == (failing,) and found.scenarios >= failing + 1
        assert found.objective == pytest.approx(0.8 + SPAN * (1.0 + 1.0 - failing / 10))
        values.append(found.objective)
    assert values == sorted(values) and values[0] > 0.8
    passed = Scenarios(Scripted(0.5), DISTURBANCES)(Ask(X, scenarios, beat=0.8))
    assert (passed.objective, passed.failed_in, passed.scenarios) == (0.5, (), 10)


def test_with_nothing_to_beat_every_scenario_is_simulated() -> None:
    inner = Scripted(0.5, {3, 7})
    found = Scenarios(inner, DISTURBANCES)(X)
    assert (found.scenarios, found.failed_in, sorted(inner.__dict__["asked"])) == (20, (3, 7), list(range(20)))
    assert found.objective == pytest.approx(0.5 + SPAN * 1.1)


def test_scenarios_in_which_the_reference_fails_are_left_out_and_hard_ones_come_first() -> None:
    reference = replace(evaluation(X, 0.9), failed_in=(1,))
    others = [replace(evaluation(X, 0.9), failed_in=(index,)) for index in (4, 2, 4)]
    assert order_scenarios(reference, others, 6) == (4, 2, 0, 3, 5)


@pytest.mark.parametrize(("spans", "failed_in"), [(0.2, ()), (0.1, (2, 3))])
def test_a_fold_passes_a_scenario_that_only_puts_it_down_beside_the_target(
    spans: float, failed_in: tuple[int, ...]
) -> None:
    task = towel(size=(0.30, 0.60), spacing=0.03)
    errors = {"hands": {"offset": [0.016, 0.0, 0.0]}, "material": {"friction_table": 0.5}}
    off = Disturbances.model_validate(errors)
    evaluator, parameters = Scenarios(Nominal(task), off, level=1.0), arched_inwards(task.fold, spans)
    far = [evaluator.inner.simulate(parameters, scenario).score for scenario in evaluator.sample]
    assert not any(each is not None and each.succeeds for each in far)
    assert evaluator(parameters).failed_in == failed_in  # there, the cloth slips


class Later(Evaluator):
    """An evaluator whose first initial curve fails without disturbances, and whose others fail in one scenario each."""

    scenario_count = 20

    def __init__(self) -> None:
        self.task = towel()
        self.curves = initial_curves(self.task.fold, robust=False)[1:]  # the first two are equal on this mesh
        self.scenarios: dict[int, tuple[int, ...] | None] = {}

    def on(self, task: Task) -> Later:
        return self

    def __call__(self, ask: Ask | Mapping[str, int | float]) -> Evaluation:
        ask = Ask.of(ask)
        number = self.curves.index(ask.parameters)
        self.scenarios[number] = ask.scenarios
        score, failed_in = evaluation({}, 1.0, 0.001 if number else 0.1).score, ((), (3,), (3,), (4,))[number]
        objective = 2.0 if failed_in else 1.0
        return replace(Nominal(self.task)(ask), objective=objective, nominal=1.0, score=score, failed_in=failed_in)


def test_trials_that_began_before_the_reference_fold_was_known_are_judged_by_it() -> None:
    evaluator = Later()
    found = learn(towel(), plain(trials=4, parallel=3, baselines=False), evaluate=evaluator)
    assert evaluator.scenarios == dict.fromkeys(range(4))  # three began together
    assert [each.minimised for each in found.trials] == [1.0, 1.0, 1.0, 2.0]  # type: ignore[union-attr]


def test_the_aim_keeps_hands_off_the_table_and_on_the_cloth() -> None:
    task = replace(towel(size=(0.34, 0.80), spacing=0.026), fingers=DISTURBANCES.fingers)
    aim = aim_for(DISTURBANCES, task.fingers)
    assert 0.002 < aim.height < 0.006 and 0.001 < aim.into < 0.006 and 0.003 < aim.from_end < 0.01
    scenarios = sample_scenarios(DISTURBANCES, 200, 5, 0)  # type: ignore[arg-type]

    def failures(one: Any, grasp: int) -> int:
        parameters = {**arched_inwards(one.fold), "g1": grasp, "g2": grasp}
        manipulation = one.manipulation(parameters)
        return sum(hand_failure(disturbed_hands(one.fold, manipulation, each)) is not None for each in scenarios)

    for grasp in (0, (task.fold.candidates - 1) // 2):
        assert failures(replace(task, aim=aim), grasp) <= 2 < failures(task, grasp)


def test_aims_grow_with_disturbances_and_never_reach_beyond_the_fingers() -> None:
    def aim(scale: float) -> Aim:
        grasp = {"along": 0.005 * scale, "into": 0.003 * scale}
        given = Disturbances.model_validate({"hands": {"offset": [0, 0, 0.003 * scale]}, "grasp": grasp})
        return aim_for(given, Fingers(thickness=0.008, length=0.02))

    assert aim(0.1) == Aim()
    assert aim(1.0).height < aim(2.0).height and aim(1.0).from_end < aim(2.0).from_end
    assert aim(10.0).into == pytest.approx(0.01)


def test_a_deeper_grasp_puts_the_cloth_down_at_the_same_place() -> None:
    flat = towel(size=(0.30, 0.60), spacing=0.03)
    aimed = replace(flat, aim=Aim(into=0.006))
    ends = [Nominal(each)(arched_inwards(each.fold)).rollout for each in (flat, aimed)]
    away = [each.positions[-1] - flat.fold.target for each in ends if each is not None]
    moved = ~flat.fold.still()
    assert abs(away[1][moved, 0].mean() - away[0][moved, 0].mean()) < 0.0015


def outcome(**changes: Any) -> Outcome:
    given = {"mean_vertex_distance": 0.02, "mask_iou": 0.9, "aligned_distance": 0.02, "slip": 0.0, "undone": 0.0}
    return Outcome(**{**given, **changes})


@pytest.mark.parametrize(
    ("found", "cause"),
    [
        (outcome(mean_vertex_distance=0.001), None),
        (Outcome(None, None, "the left hand meets the table: the hand is 9.0 mm too low"), TABLE),
        (Outcome(None, None, "the right hand grasps beside the cloth"), BESIDE_CLOTH),
        (Outcome(None, None, "the cloth was stretched by 41 %"), UNSIMULATED),
        (outcome(aligned_distance=0.003), BESIDE_TARGET),
        (outcome(slip=0.03), SLIPPED),
        (outcome(aligned_distance=0.003, slip=0.03), SLIPPED),
        (outcome(undone=0.6), UNDONE),
        (outcome(), CRUSHED),
    ],
)
def test_failures_have_a_cause_and_a_remedy(found: Outcome, cause: str | None) -> None:
    assert found.cause(Limits()) == cause
    assert cause is None or HELP[cause]


def test_a_perfect_fold_that_is_shifted_and_turned_is_put_down_beside_the_target() -> None:
    fold, angle = towel().fold, np.radians(25.0)
    turn = np.array([[np.cos(angle), np.sin(angle), 0.0], [-np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]])
    off = fold.target @ turn + [0.02, 0.01, 0.0]
    final = np.where(fold.still()[:, None], fold.target, off)
    rollout = Rollout(np.array([0.0]), final[None], fold.garment.faces, {})
    found = Outcome.of(Evaluation({}, 1.0, 1.0, 1.0, score(fold, 1.0, final), rollout=rollout), fold)
    assert found.cause(Limits()) == BESIDE_TARGET


def nan_for_low_curves(parameters: Mapping[str, int | float]) -> float:
    return float("nan") if parameters["z1"] < 10.0 else 1.0


def test_an_own_objective_that_is_not_finite_is_named_with_its_value_and_parameters() -> None:
    with pytest.raises(
        InputError, match=r"nan_for_low_curves must return a finite number, but returned nan for .*'x1'"
    ):
        learn(towel(), plain(trials=1, baselines=False), evaluate=nan_for_low_curves)


def test_a_study_over_scenarios_resumes_and_reports_all_it_did(tmp_path: Path) -> None:
    seen: list[str] = []
    options = LearnOptions(trials=3, seed=1, baselines=False)
    task = towel(size=(0.30, 0.60), spacing=0.03)
    first = learn(task, options, out=tmp_path, progress=lambda now: seen.append(now.stage))
    assert seen.index("first") < seen.index("success") and (tmp_path / "report.html").exists()
    more = learn(task, LearnOptions(trials=5, seed=1, baselines=False), out=tmp_path)
    at_once = learn(task, LearnOptions(trials=5, seed=1, baselines=False))
    assert [each.minimised for each in more.trials] == [each.minimised for each in at_once.trials]  # type: ignore[union-attr]
    reference = first.trials[0]  # type: ignore[union-attr]
    assert reference.scenarios is not None and reference.scenarios.simulated == 20
    success = more.success  # type: ignore[union-attr]
    assert success is not None and success.succeeded + sum(success.causes.values()) == success.simulations
    moves_no_cloth = {TABLE, BESIDE_CLOTH}
    assert set(more.failures) == set(success.causes) - moves_no_cloth != set()  # type: ignore[union-attr]
    assert more.failures.keys() == Result.load(tmp_path).failures.keys()  # type: ignore[union-attr]
    page = (tmp_path / "report.html").read_text()
    assert all(f"<b>{cause}</b>" in page for cause in more.failures)  # type: ignore[union-attr]
    assert more.record.aim == aim_for(DISTURBANCES, DISTURBANCES.fingers)  # type: ignore[union-attr]
