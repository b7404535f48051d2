"""Searches that begin on a coarser mesh, and those that end by themselves."""

from __future__ import annotations

import json
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tatamu.folding.coarser import SOON, as_on_finer_mesh, on_coarser_mesh, with_coarser
from tatamu.learning import Expectation, learn_job
from tatamu.learning.evaluation import submitted
from tatamu.learning.learn import fine_share
from tatamu.learning.refining import Known, refining_proposal
from tatamu.learning.schedule import FINE_SHARE, FINE_SHARE_UNSURE, GAIN, MOST, MOST_FINE, Schedule, ScheduledTrial
from tatamu.learning.space import search_space
from tatamu.results import ResultFolder, rebuild

from tatamu import InputError
from tatamu.disturbances import Disturbances
from tatamu.folding import coarser as coarser_meshes
from tatamu.folding.fold import ideal_folds
from tatamu.folding.interpolation import interpolated
from tatamu.folding.manipulation import SETTLE
from tatamu.folding.task import Job, Outcome, make_job
from tatamu.garments import make_garment
from tatamu.material import Material

SIZE = (0.16, 0.40)
PARAMETERS = {"x1": 0.1, "z1": 0.15, "x2": 0.3, "z2": 0.1, "g1": 1, "g2": 0}


@pytest.fixture(autouse=True)
def _small_is_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(coarser_meshes, "FEWEST", 20)


def job(fold: str = "half", **changes: Any) -> Job:
    return make_job("towel", **{"fold": fold, "size": SIZE, **changes})


def learned(folder: Path, trials: Any = 12, asked: Job | None = None, **options: Any) -> ResultFolder:
    learn_job(asked or job(), folder, trials=trials, baselines=False, **options)
    return ResultFolder(folder)


@pytest.fixture(scope="module")
def two_meshes(tmp_path_factory: pytest.TempPathFactory) -> ResultFolder:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(coarser_meshes, "FEWEST", 20)
        return learned(tmp_path_factory.mktemp("two"))


def test_the_last_trials_run_on_the_default_mesh_and_one_of_them_is_the_best(two_meshes: ResultFolder) -> None:
    result = two_meshes.result
    spacings = [trial.spacing for trial in result.trials]
    assert spacings == [result.coarse] * 7 + [result.task.spacing] * 5
    assert result.best is not None and result.best >= 7
    fine = [trial.objective for trial in result.trials[7:] if trial.objective is not None]
    assert result.best_trial.objective == min(fine)
    assert len(two_meshes.rollout.extra["error_first"]) == len(two_meshes.scene.cloth.vertices)


def test_objectives_of_both_meshes_are_made_alike(two_meshes: ResultFolder) -> None:
    for trial in two_meshes.result.trials:
        assert trial.trajectory_length is not None
        assert trial.objective == pytest.approx(trial.trajectory_length + 0.01 * (trial.shape_distance or 0.0))


def test_the_first_fine_trials_are_the_last_curve_and_the_best_coarse_one(two_meshes: ResultFolder) -> None:
    trials = two_meshes.result.trials
    first = two_meshes.result.first
    assert [trial.parameters for trial in trials[:4]] == first[:4]
    assert trials[7].parameters == first[4]
    known = trials[: 8 - 3]  # the last three were running when it was proposed
    assert trials[8].parameters == min(known, key=lambda trial: trial.objective or np.inf).parameters


def test_a_search_on_two_meshes_goes_on_as_it_would_have(two_meshes: ResultFolder, tmp_path: Path) -> None:
    class Killed(Exception):
        pass

    for done in (4, 9):
        with pytest.raises(Killed):
            learned(tmp_path, reporting=_raising_after(done, Killed))
    again = learned(tmp_path)
    assert _timeless(again) == _timeless(two_meshes)
    before = again.result_file.read_bytes()
    learned(tmp_path)
    assert again.result_file.read_bytes() == before


def _raising_after(done: int, error: type[Exception]) -> Any:
    from collections.abc import Iterator
    from contextlib import contextmanager

    @contextmanager
    def reporting(task: Any, trials: int) -> Iterator[Any]:
        def raise_then(progress: Any) -> None:
            if progress.done == done:
                raise error

        yield raise_then

    return reporting


def _timeless(folder: ResultFolder) -> str:
    plain = json.loads(folder.result_file.read_text())
    del plain["wall_seconds"]
    for trial in plain["trials"]:
        del trial["seconds"]
    return json.dumps(plain)


def test_a_study_of_one_mesh_goes_on_on_it(tmp_path: Path) -> None:
    first = learned(tmp_path, trials=2, coarse=False)
    assert first.result.coarse is None and first.result.trials[0].spacing is None
    assert learned(tmp_path, trials=11).result.coarse is None
    with pytest.raises(InputError, match="coarse is null there"):
        learned(tmp_path, trials=12, coarse=True)


@pytest.mark.parametrize("changes", [{"spacing": 0.02}, {"simulator": "mujoco"}, {"size": (0.12, 0.28)}])
def test_not_every_job_has_a_coarser_mesh(changes: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    assert with_coarser(job()).coarser is not None
    monkeypatch.setattr(coarser_meshes, "FEWEST", 250)
    assert with_coarser(job(**changes)).coarser is None


@pytest.mark.parametrize("garment", ["towel", "tshirt"])
def test_a_plan_of_several_steps_has_cells_of_three_quarters_of_a_bending_length(garment: str) -> None:
    fold = {"towel": "quarters", "tshirt": "shop"}[garment]
    coarse = with_coarser(make_job(garment, fold=fold)).coarser
    once = with_coarser(make_job(garment)).coarser
    assert coarse is not None and once is not None
    bending_length = coarse.garment.material.bending_length
    assert coarse.garment.spacing == pytest.approx(0.75 * bending_length, rel=0.01)
    assert coarse.garment.spacing < once.garment.spacing


def test_from_the_third_step_on_a_search_stays_on_the_own_mesh() -> None:
    shop = with_coarser(make_job("tshirt", fold="shop"))
    ideals = [fold.target for fold in ideal_folds(shop.garment, shop.plan, shop.hands)]
    states = [None, *ideals[:2]]
    assert [shop.task(number, state).coarser is not None for number, state in enumerate(states)] == [True, True, False]


def test_the_same_parameters_are_the_same_motion_on_both_meshes() -> None:
    task = with_coarser(job()).task(0)
    assert task.coarser is not None
    fine = task.manipulation(PARAMETERS)
    coarse = on_coarser_mesh(task, fine, PARAMETERS)
    apart = [np.linalg.norm(a - b) for a, b in zip(fine.positions, coarse.positions, strict=True)]
    assert max(apart) < 0.7 * task.coarser.fold.garment.spacing
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
    fine = with_coarser(make_job(name, material=woven))
    assert fine.coarser is not None
    coarse = fine.coarser.garment
    for field in ("stretch_stiffness", "stretch_stiffness_weft", "shear_stiffness"):
        times_area = getattr(coarse.material, field) * coarse.spacing**2
        assert times_area == pytest.approx(getattr(woven, field) * fine.garment.spacing**2)
    plain = coarse.material.model_copy(update={"stretch_stiffness": 1000.0, "stretch_stiffness_weft": 600.0})
    assert plain.model_copy(update={"shear_stiffness": 20.0}) == woven


def test_a_coarse_trial_ends_soon_after_the_hands_have_opened_and_others_later() -> None:
    task = with_coarser(job()).task(0)
    manipulation = task.manipulation(PARAMETERS)
    lasted = {}
    for coarse in (True, False):
        with ThreadPoolExecutor(1) as pool:
            begun = submitted(pool, task, manipulation, parameters=PARAMETERS, coarse=coarse)
            rollout = begun.ended("a trial").outcome.rollout
        assert rollout is not None
        lasted[coarse] = rollout.times[-1] - (begun.coarse or manipulation).timing.opens
    assert lasted == {True: pytest.approx(SOON), False: pytest.approx(SETTLE)}


def test_a_sum_over_vertices_is_multiplied_and_a_penalty_too() -> None:
    task = with_coarser(job()).task(0)
    assert task.coarser is not None
    fine = task.manipulation(PARAMETERS)
    coarse = on_coarser_mesh(task, fine, PARAMETERS)
    failed = Outcome(None, task.coarser.penalty(coarse.trajectory_length), "blew up", None)
    assert as_on_finer_mesh(task, fine, coarse, failed).objective == pytest.approx(
        task.penalty(fine.trajectory_length), rel=0.03
    )


@pytest.mark.parametrize("name", ["towel", "tshirt"])
def test_a_state_in_between_the_vertices_is_that_of_its_layer(name: str) -> None:
    fine = make_garment(name)
    coarse = make_garment(name, spacing=1.5 * fine.spacing)
    assert np.abs(interpolated(fine, fine.vertices, coarse) - coarse.vertices).max() < 1e-3
    turned = fine.vertices[:, [1, 0, 2]] + 0.1
    assert np.abs(interpolated(fine, turned, coarse) - coarse.vertices[:, [1, 0, 2]] - 0.1).max() < 1e-3


def test_a_later_step_is_searched_on_the_coarser_mesh_from_the_very_state_of_the_finer_one(tmp_path: Path) -> None:
    asked = job("quarters", size=(0.26, 0.26))
    folder = learned(tmp_path, 11, asked, sampler="random")
    first, second = folder.step(0), folder.step(1)
    assert second.result.coarse == first.result.coarse is not None
    left = first.rollout.positions[-1]
    task = with_coarser(asked).task(1, left)
    assert task.coarser is not None
    fine, coarse = task.fold, task.coarser.fold
    back = interpolated(coarse.garment, coarse.start, fine.garment)
    assert np.linalg.norm(back - left, axis=1).mean() < 0.1 * fine.garment.spacing
    again = rebuild(second.path).with_coarser_mesh()
    assert again.coarser is not None and np.array_equal(again.coarser.fold.start, coarse.start)


def test_fine_trials_follow_what_the_meshes_differ_by() -> None:
    """The coarse mesh knows little of x1; the fine one wants it large, which a few trials near the middle tell."""
    space = search_space(job().task(0).fold, "integer")
    rows = np.random.default_rng(0).random((40, 4))
    names = ("x1", "z1", "x2", "z2")
    coarse = [
        {**{n: float(v * space[n].high) for n, v in zip(names, row, strict=True)}, "g1": 0, "g2": 0} for row in rows
    ]

    def share(parameters: dict[str, Any]) -> float:
        return float(parameters["x1"] / space["x1"].high)

    def objective(parameters: dict[str, Any], fine: bool) -> float:
        beside = abs(share(parameters) - 0.4)
        return 1.0 + 0.1 * (1.0 + 0.05 * beside) * (np.exp(-4.0 * share(parameters)) if fine else 1.0)

    def known_part(values: Any) -> np.ndarray:
        return np.ones(np.shape(values["x1"]))

    finished = Known(coarse, np.array([objective(each, False) for each in coarse]))
    fine: list[dict[str, Any]] = []
    for number in range(8):
        values = Known(fine, np.array([objective(each, True) for each in fine]))
        proposed, _ = refining_proposal(space, known_part, finished, values, [], np.random.default_rng(number))
        fine.append(proposed)
    assert max(abs(share(each) - 0.4) for each in fine[:3]) < 0.2  # the best coarse ones
    assert max(share(each) for each in fine) > 0.9


def test_a_schedule_of_a_number_of_trials() -> None:
    def planned(trials: Any, meshes: int, fine_share: float = FINE_SHARE) -> list[bool]:
        before: list[ScheduledTrial] = []
        while (coarse := Schedule(trials, meshes, fine_share).coarse_next(before)) is not None:
            before.append(ScheduledTrial(coarse, 1.0))
        return [each.coarse for each in before]

    assert planned(50, 2) == [True] * 44 + [False] * 6
    assert planned(50, 2, 0.3) == [True] * 35 + [False] * 15
    assert planned(10, 2) == [True] * 5 + [False] * 5
    assert planned(9, 2) == [False] * 9
    assert planned(50, 1) == [False] * 50
    assert planned("auto", 1) == [False] * MOST
    assert planned("auto", 2) == [True] * (MOST - MOST_FINE) + [False] * MOST_FINE


def test_more_trials_run_on_the_own_mesh_where_a_coarser_one_is_less_sure() -> None:
    tasks = {"one layer": job().task(0), "two layers": make_job("tshirt").task(0)}
    tasks["later"] = replace(tasks["one layer"], step=(2, 2))
    calm = {name: fine_share(task, None) for name, task in tasks.items()}
    assert calm == {"one layer": FINE_SHARE, "two layers": FINE_SHARE, "later": FINE_SHARE_UNSURE}
    disturbed = {name: fine_share(task, Expectation(Disturbances())) for name, task in tasks.items()}
    assert disturbed == {"one layer": FINE_SHARE, "two layers": FINE_SHARE_UNSURE, "later": FINE_SHARE_UNSURE}


def test_a_search_ends_when_little_is_expected_three_times_in_a_row() -> None:
    little = ScheduledTrial(False, 0.9 * GAIN)
    much = ScheduledTrial(False, 1.1 * GAIN)
    schedule = Schedule("auto", 1)
    assert schedule.coarse_next([much, little, little, little]) is None
    assert schedule.coarse_next([little, little, much, little, little]) is False
    assert schedule.coarse_next([ScheduledTrial(False, None), little, little]) is False
    coarse = ScheduledTrial(True, 0.9 * GAIN)
    assert Schedule("auto", 2).coarse_next([coarse] * 3) is False
    assert Schedule("auto", 2).coarse_next([coarse, coarse, replace_gain(coarse)]) is True


def replace_gain(planned: ScheduledTrial) -> ScheduledTrial:
    return planned._replace(gain=2.0 * GAIN)


def test_a_search_that_ends_by_itself_says_so_and_is_left_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tatamu.learning.schedule.GAIN", 0.05)
    folder = learned(tmp_path, "auto", coarse=False)
    assert len(folder.result.trials) < MOST
    gains = [trial.expected_gain for trial in folder.result.trials]
    assert all(gain is not None and gain < 0.05 for gain in gains[-3:])
    before = folder.report_file.read_bytes()
    learned(tmp_path, "auto")
    assert folder.report_file.read_bytes() == before


def test_only_a_sampler_that_says_what_it_expects_ends_by_itself(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="auto is for the sampler gp"):
        learned(tmp_path / "new", "auto", sampler="random")
    assert not (tmp_path / "new").exists()


def test_a_garment_that_cannot_be_grasped_with_larger_cells_keeps_its_mesh(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(coarser_meshes, "COARSER", {1: 8.0})
    assert with_coarser(job()).coarser is None
    assert replace(job(), asked=None).coarser is None
