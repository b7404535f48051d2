"""Evaluation on two meshes: searches that start on a coarser one, and those that end by themselves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from tatamu import (
    CoarseFirst,
    GPSearch,
    InputError,
    LearnOptions,
    Nominal,
    PlanResult,
    Progress,
    Result,
    SimulationError,
    Space,
    Task,
    TwoFidelitySearch,
    learn,
    load,
    make_task,
)
from tatamu.evaluation import CoarseMesh, Evaluator, coarser_task, on_coarser_mesh
from tatamu.evaluation.nominal import penalty
from tatamu.folding.fold import ideal_folds
from tatamu.folding.interpolation import interpolated
from tatamu.folding.manipulation import SETTLE
from tatamu.folding.parameters import search_space
from tatamu.garments import make_garment
from tatamu.search import HIGH, LOW, Proposal, Schedule
from tatamu.simulation.material import Material
from tatamu.study.folder import ResultFolder
from tatamu.study.record import StudyRecord
from tatamu.study.setup import LATER_SHARE, ROBUST_SHARE, make_schedule
from tests.small_studies import timeless

PARAMETERS: dict[str, int | float] = {"x1": 0.1, "z1": 0.15, "x2": 0.3, "z2": 0.1, "g1": 1, "g2": 0}
SMALL = CoarseMesh(fewest=20)
"""Small meshes have coarser ones, for the sake of time."""


def small_is_enough(patch: pytest.MonkeyPatch) -> None:
    patch.setattr("tatamu.study.setup.CoarseFirst", lambda inner: CoarseFirst(inner, SMALL))


@pytest.fixture(autouse=True)
def _small_is_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    small_is_enough(monkeypatch)


def towel(fold: str = "half", **changes: Any) -> Task:
    return make_task("towel", **{"fold": fold, "size": (0.16, 0.40), **changes})


def learned(
    out: Path | None,
    trials: Any = 12,
    asked: Task | None = None,
    progress: Callable[[Progress], object] = lambda _: None,
    **options: Any,
) -> Result:
    wanted = LearnOptions(trials=trials, baselines=False, disturbances="none", **options)
    result = learn(asked or towel(), wanted, out=out, progress=progress)
    assert isinstance(result, Result)
    return result


def coarse_of(task: Task, settings: CoarseMesh = SMALL) -> Task:
    coarse = coarser_task(task, settings)
    assert coarse is not None
    return coarse


@pytest.fixture(scope="module")
def two_meshes(tmp_path_factory: pytest.TempPathFactory) -> Result:
    with pytest.MonkeyPatch.context() as patch:
        small_is_enough(patch)
        return learned(tmp_path_factory.mktemp("two"))


def folder_of(result: Result) -> Path:
    assert result.folder is not None
    return result.folder


def test_the_last_trials_run_on_the_default_mesh_and_one_of_them_is_the_best(two_meshes: Result) -> None:
    record = two_meshes.record
    spacings = [trial.spacing for trial in record.trials]
    assert spacings == [record.coarse] * 7 + [record.task.spacing] * 5
    assert record.best is not None and record.best >= 7
    fine = [trial.objective for trial in record.trials[7:] if trial.objective is not None]
    assert record.best_trial.objective == min(fine)
    assert len(two_meshes.rollout.extra["error_first"]) == len(two_meshes.scene.cloth.vertices)


def test_objectives_of_both_meshes_are_made_alike(two_meshes: Result) -> None:
    for trial in two_meshes.trials:
        assert trial.trajectory_length is not None and trial.score is not None
        assert trial.objective == pytest.approx(trial.trajectory_length + 0.01 * trial.score.shape_distance)


def test_the_first_fine_trials_are_the_best_coarse_ones_and_the_last_curve(two_meshes: Result) -> None:
    trials = two_meshes.trials
    first = two_meshes.record.first
    assert [trial.parameters for trial in trials[:4]] == first[:4]
    known = trials[: 7 - 1]  # the last one was running when it was proposed
    assert trials[7].parameters == min(known, key=lambda trial: trial.objective or np.inf).parameters
    assert trials[9].parameters == first[4]


def test_a_search_on_two_meshes_goes_on_as_it_would_have(two_meshes: Result, tmp_path: Path) -> None:
    class Killed(Exception):
        pass

    def killed_after(done: int) -> Callable[[Progress], None]:
        def kill(progress: Progress) -> None:
            if progress.done == done:
                raise Killed

        return kill

    for done in (4, 9):
        with pytest.raises(Killed):
            learned(tmp_path, progress=killed_after(done))
    learned(tmp_path)
    assert timeless(tmp_path) == timeless(folder_of(two_meshes))
    before = (tmp_path / "result.json").read_bytes()
    learned(tmp_path)
    assert (tmp_path / "result.json").read_bytes() == before


def test_the_best_never_gets_worse_without_the_word_that_the_mesh_changed() -> None:
    """Objectives of both meshes cannot be compared: after the change the best may be worse, and the line says so."""
    from tatamu.cli.progress import best

    seen: list[Progress] = []
    learned(None, progress=seen.append)
    known = [each for each in seen if each.best is not None]
    assert [each.coarse for each in known] == sorted((each.coarse for each in known), reverse=True)
    assert {each.coarse for each in known} == {True, False}
    for each in known:
        assert (" on the coarse mesh" in best(each)) == each.coarse
    for before, after in pairwise(known):
        assert before.best is not None and after.best is not None
        assert after.best <= before.best or (before.coarse and not after.coarse)


def test_a_study_of_one_mesh_goes_on_on_it(tmp_path: Path, small_pictures: None) -> None:
    first = learned(tmp_path, trials=2, coarse=False)
    assert first.record.coarse is None and first.trials[0].spacing is None
    assert learned(tmp_path, trials=11).record.coarse is None
    with pytest.raises(InputError, match="coarse is null there"):
        learned(tmp_path, trials=12, coarse=True)


def test_a_mesh_that_the_user_asked_for_is_the_only_one() -> None:
    assert coarser_task(towel(), SMALL) is not None
    assert CoarseFirst(Nominal(towel()), SMALL).fidelities == 2
    assert CoarseFirst(Nominal(towel(spacing=0.02)), SMALL).fidelities == 1


@pytest.mark.parametrize("changes", [{"simulator": "mujoco"}, {"size": (0.12, 0.28)}])
def test_not_every_task_has_a_coarser_mesh(changes: dict[str, Any]) -> None:
    assert coarser_task(towel(**changes)) is None
    asked = towel(**changes)
    evaluator: Evaluator = CoarseFirst(Nominal(asked))
    assert evaluator.fidelities == 1 and evaluator.low_fidelity(PARAMETERS) is None


@pytest.mark.parametrize("garment", ["towel", "tshirt"])
def test_a_plan_of_several_steps_has_cells_of_three_quarters_of_a_bending_length(garment: str) -> None:
    fold = {"towel": "quarters", "tshirt": "shop"}[garment]
    material = {"towel": "terry", "tshirt": "jersey"}[garment]  # limper cloth has the cells of 3,000 vertices
    coarse = coarse_of(make_task(garment, fold=fold, material=material), CoarseMesh())
    once = coarse_of(make_task(garment, material=material), CoarseMesh())
    bending_length = coarse.garment.material.bending_length
    assert coarse.garment.spacing == pytest.approx(0.75 * bending_length, rel=0.01)
    assert coarse.garment.spacing < once.garment.spacing


def test_from_the_third_step_on_a_search_stays_on_the_own_mesh() -> None:
    shop = make_task("tshirt", fold="shop")
    ideals = [fold.target for fold in ideal_folds(shop.garment, shop.plan, shop.hands)]
    states = [None, *ideals[:2]]
    evaluator = CoarseFirst(Nominal(shop))
    assert [evaluator.on(shop.at(number, state)).fidelities for number, state in enumerate(states)] == [2, 2, 1]


def test_the_same_parameters_are_the_same_motion_on_both_meshes() -> None:
    task = towel()
    coarser = coarse_of(task)
    fine = task.manipulation(PARAMETERS)
    coarse = coarser.manipulation(on_coarser_mesh(task, coarser, PARAMETERS))
    apart = [np.linalg.norm(a - b) for a, b in zip(fine.positions, coarse.positions, strict=True)]
    assert max(apart) < 0.7 * coarser.garment.spacing
    assert coarse.trajectory_length == pytest.approx(fine.trajectory_length, rel=0.02)


@pytest.mark.parametrize("name", ["towel", "tshirt"])
def test_the_coarser_mesh_is_softer_so_that_it_locks_as_the_finer_one(name: str) -> None:
    woven = Material(
        areal_density=0.2,
        stretch_stiffness=1000.0,
        stretch_stiffness_weft=600.0,
        shear_stiffness=20.0,
        bending_rigidity=1e-5,
    )
    fine = make_task(name, material=woven)
    coarse = coarse_of(fine).garment
    for field in ("stretch_stiffness", "stretch_stiffness_weft", "shear_stiffness"):
        times_area = getattr(coarse.material, field) * coarse.spacing**2
        assert times_area == pytest.approx(getattr(woven, field) * fine.garment.spacing**2)
    plain = coarse.material.model_copy(update={"stretch_stiffness": 1000.0, "stretch_stiffness_weft": 600.0})
    assert plain.model_copy(update={"shear_stiffness": 20.0}) == woven


def test_a_coarse_trial_ends_soon_after_the_hands_have_opened_and_others_later() -> None:
    evaluator = CoarseFirst(Nominal(towel()), SMALL)
    low = evaluator.low_fidelity(PARAMETERS)
    assert low is not None
    opens = {LOW: low[0].task.manipulation(low[1]).timing.opens, HIGH: towel().manipulation(PARAMETERS).timing.opens}
    lasted = {}
    for fidelity in (LOW, HIGH):
        found = evaluator(Proposal(PARAMETERS, fidelity))
        assert found.rollout is not None and found.fidelity == fidelity
        lasted[fidelity] = found.rollout.times[-1] - opens[fidelity]
    assert lasted == {LOW: pytest.approx(SMALL.settle), HIGH: pytest.approx(SETTLE)}


def test_a_sum_over_vertices_is_multiplied_and_a_penalty_too(monkeypatch: pytest.MonkeyPatch) -> None:
    def blow_up(*_: Any) -> Any:
        raise SimulationError("blew up")

    monkeypatch.setattr("tatamu.evaluation.nominal.simulate", blow_up)
    task = towel()
    failed = CoarseFirst(Nominal(task), SMALL)(Proposal(PARAMETERS, LOW))
    assert failed.failed and failed.error == "blew up"
    assert failed.objective == pytest.approx(
        penalty(task.fold, task.manipulation(PARAMETERS).trajectory_length), rel=0.03
    )


@pytest.mark.parametrize("name", ["towel", "tshirt"])
def test_a_state_in_between_the_vertices_is_that_of_its_layer(name: str) -> None:
    fine = make_garment(name)
    coarse = make_garment(name, spacing=1.5 * fine.spacing)
    assert np.abs(interpolated(fine, fine.vertices, coarse) - coarse.vertices).max() < 1e-3
    turned = fine.vertices[:, [1, 0, 2]] + 0.1
    assert np.abs(interpolated(fine, turned, coarse) - coarse.vertices[:, [1, 0, 2]] - 0.1).max() < 1e-3


def test_a_later_step_is_searched_on_the_coarser_mesh_from_the_very_state_of_the_finer_one(tmp_path: Path) -> None:
    asked = towel("quarters", size=(0.26, 0.26))
    wanted = LearnOptions(trials=11, baselines=False, disturbances="none", sampler="random")
    learn(asked, wanted, out=tmp_path)
    plan = load(tmp_path)
    assert isinstance(plan, PlanResult)
    first, second = plan.steps
    assert second.record.coarse == first.record.coarse is not None
    task = asked.next(first.final)
    coarse = coarse_of(task)
    back = interpolated(coarse.garment, coarse.fold.start, task.garment)
    assert np.linalg.norm(back - first.final, axis=1).mean() < 0.1 * task.garment.spacing
    assert np.array_equal(coarse_of(second.task).fold.start, coarse.fold.start)


def test_fine_trials_follow_what_the_meshes_differ_by() -> None:
    """The coarse mesh knows little of x1; the fine one wants it large, which a few trials near the middle tell."""
    bounds = search_space(towel().fold).bounds
    rows = np.random.default_rng(0).random((40, 4))
    names = ("x1", "z1", "x2", "z2")

    def share(parameters: Any) -> float:
        return float(parameters["x1"] / bounds["x1"].high)

    def objective(parameters: Any, fine: bool) -> float:
        beside = abs(share(parameters) - 0.4)
        return float(1.0 + 0.1 * (1.0 + 0.05 * beside) * (np.exp(-4.0 * share(parameters)) if fine else 1.0))

    space = Space(bounds, known_part=lambda values: np.ones(np.shape(values["x1"])))
    search = TwoFidelitySearch(GPSearch, space)
    for row in rows:
        coarse = {**{n: float(v * bounds[n].high) for n, v in zip(names, row, strict=True)}, "g1": 0, "g2": 0}
        search.tell(Proposal(coarse, LOW), objective(coarse, False))
    fine = []
    for _ in range(8):
        proposed = search.ask(HIGH)
        search.tell(proposed, objective(proposed, True))
        fine.append(proposed)
    assert max(abs(share(each) - 0.4) for each in fine[:3]) < 0.2  # the best coarse ones
    assert max(share(each) for each in fine) > 0.9


@pytest.mark.parametrize(("value", "place"), [(3.0, 2), (0.5, 0)])
def test_a_given_curve_is_tried_once_on_the_fine_mesh(value: float, place: int) -> None:
    space = search_space(towel().fold)
    given, *others = (space.random(seed) for seed in range(3))
    search = TwoFidelitySearch(GPSearch, space, first=[given])
    for parameters, known in zip([given, *others], [value, 1.0, 2.0], strict=True):
        search.tell(Proposal(parameters, LOW), known)
    asked = []
    for _ in range(5):
        asked.append(search.ask(HIGH))
        search.tell(asked[-1], 1.0)
    assert [number for number, each in enumerate(asked) if each.parameters == given] == [place]


def proposal(fidelity: int, gain: float | None) -> Proposal:
    return Proposal({}, fidelity, gain)


def test_a_schedule_of_a_number_of_trials() -> None:
    def planned(trials: Any, fidelities: int, **share: Any) -> list[int]:
        before: list[Proposal] = []
        while (fidelity := Schedule(trials, fidelities, **share).next_fidelity(before)) is not None:
            before.append(proposal(fidelity, 1.0))
        return [each.fidelity for each in before]

    most, most_high = Schedule("auto").most, Schedule("auto").most_high
    assert planned(50, 2) == [LOW] * 44 + [HIGH] * 6
    assert planned(50, 2, high_share=ROBUST_SHARE) == [LOW] * 38 + [HIGH] * 12
    assert planned(10, 2) == [LOW] * 5 + [HIGH] * 5
    assert planned(9, 2) == [HIGH] * 9
    assert planned(50, 1) == [HIGH] * 50
    assert planned("auto", 1) == [HIGH] * most
    assert planned("auto", 2) == [LOW] * (most - most_high) + [HIGH] * most_high


def test_more_trials_run_on_the_own_mesh_where_a_coarser_one_is_less_sure() -> None:
    quarters = towel("quarters", size=(0.26, 0.26))
    tasks = {"one layer": towel(), "two layers": make_task("tshirt"), "later": quarters.next(quarters.fold.target)}

    def shares(disturbances: dict[str, Any] | None) -> dict[str, float]:
        record = cast(StudyRecord, SimpleNamespace(disturbances=disturbances))
        return {name: make_schedule(task, record, LearnOptions(), 2).high_share for name, task in tasks.items()}

    usual = Schedule(50).high_share
    assert usual == 0.12 and ROBUST_SHARE == 0.24 and LATER_SHARE == 0.3
    assert shares(None) == {"one layer": usual, "two layers": usual, "later": LATER_SHARE}
    assert shares({}) == {"one layer": ROBUST_SHARE, "two layers": ROBUST_SHARE, "later": LATER_SHARE}


def test_a_search_ends_when_little_is_expected_three_times_in_a_row() -> None:
    gain = Schedule("auto").least_gain
    assert gain == 0.001
    little, much = proposal(HIGH, 0.9 * gain), proposal(HIGH, 1.1 * gain)
    schedule = Schedule("auto", 1)
    assert schedule.next_fidelity([much, little, little, little]) is None
    assert schedule.next_fidelity([little, little, much, little, little]) == HIGH
    assert schedule.next_fidelity([proposal(HIGH, None), little, little]) == HIGH
    coarse = proposal(LOW, 0.9 * gain)
    assert Schedule("auto", 2).next_fidelity([coarse] * 3) == HIGH
    assert Schedule("auto", 2).next_fidelity([coarse, coarse, replace(coarse, gain=2.0 * gain)]) == LOW


def test_a_search_that_ends_by_itself_says_so_and_is_left_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tatamu.study.setup.Schedule", partial(Schedule, least_gain=0.05))
    result = learned(tmp_path, "auto", coarse=False)
    assert len(result.trials) < Schedule("auto").most
    assert result.record.until_gain == 0.05
    gains = [trial.expected_gain for trial in result.trials]
    assert all(gain is not None and gain < 0.05 for gain in gains[-3:])
    folder = ResultFolder(tmp_path)
    before = folder.report_file.read_bytes()
    learned(tmp_path, "auto")
    assert folder.report_file.read_bytes() == before


def test_only_a_sampler_that_says_what_it_expects_ends_by_itself() -> None:
    with pytest.raises(InputError, match="auto is for the sampler gp"):
        LearnOptions(trials="auto", sampler="random")


def test_a_garment_that_cannot_be_grasped_with_larger_cells_keeps_its_mesh() -> None:
    assert coarser_task(towel(), CoarseMesh(one_layer=8.0, fewest=20)) is None
    assert coarser_task(replace(towel(), garment=replace(towel().garment, source=None)), SMALL) is None
