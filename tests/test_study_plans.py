"""Plans of several steps: each learned in turn from where the one before it ended, found again after interruptions."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tatamu import (
    Disturbances,
    InputError,
    LearnOptions,
    PlanResult,
    Rollout,
    Scene,
    Task,
    learn,
    load,
    simulate,
)
from tatamu.folding.fold import ideal_folds
from tatamu.folding.parameters import ARCHED, HIGH, search_space, transfer
from tatamu.report.page import hands
from tatamu.report.plan import joined_path
from tatamu.search import Space
from tatamu.study.folder import ResultFolder
from tests.small_studies import bytes_in, plain, timeless, towel


def task(**changes: Any) -> Task:
    return towel(**{"fold": "quarters", **changes})


def learn_plan(out: Path | None, trials: int, asked: Task | None = None) -> PlanResult:
    result = learn(asked or task(), plain(trials=trials, sampler="random", baselines=False), out=out)
    assert isinstance(result, PlanResult)
    return result


@pytest.fixture(scope="module")
def learned(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("plan")
    learn_plan(folder, 2)
    return folder


def test_a_plan_has_a_folder_per_step_and_files_for_the_whole(learned: Path) -> None:
    assert {p.name for p in learned.iterdir()} - {".lock"} == {
        "step-1", "step-2", "result.json", "rollout.npz", "report.html",
    }  # fmt: skip
    for step in ("step-1", "step-2"):
        names = {p.name for p in (learned / step).iterdir()} - {".lock"}
        assert names == {"result.json", "manipulation.json", "scene.json", "rollout.npz", "study.db", "report.html"}
    result = json.loads((learned / "result.json").read_text())
    assert [step["title"] for step in result["steps"]] == ["in half across the length", "in half along the length"]
    assert result["final"] == result["steps"][-1]["whole"]


def test_a_step_begins_where_the_one_before_it_ended(learned: Path) -> None:
    first, second = (Rollout.load(learned / step / "rollout.npz") for step in ("step-1", "step-2"))
    assert (first.positions[-1] == second.positions[0]).all()
    scene = Scene.load(learned / "step-2" / "scene.json")
    assert (scene.cloth.rest == task().garment.vertices).all()
    assert simulate(scene).positions.tobytes() == second.positions.tobytes()


def test_the_joined_rollout_is_all_steps(learned: Path) -> None:
    parts = [Rollout.load(learned / step / "rollout.npz") for step in ("step-1", "step-2")]
    whole = Rollout.load(learned / "rollout.npz")
    assert len(whole.times) == sum(len(part.times) for part in parts) - 1
    assert np.diff(whole.times) == pytest.approx(1 / 60)
    assert (whole.positions[-1] == parts[-1].positions[-1]).all()
    assert whole.extra["step_starts"] == pytest.approx([0.0, parts[0].times[-1]])


def test_errors_are_told_against_the_step_and_against_the_flat_garment(learned: Path) -> None:
    result = json.loads((learned / "result.json").read_text())
    ideals = [fold.target for fold in ideal_folds(task().garment, task().plan)]
    for step, ideal in zip(result["steps"], ideals, strict=True):
        rollout = Rollout.load(learned / step["folder"] / "rollout.npz")
        own = np.linalg.norm(rollout.positions[-1] - rollout.extra["target"], axis=1).mean()
        whole = np.linalg.norm(rollout.positions[-1] - ideal, axis=1).mean()
        assert step["mean_vertex_distance"] == pytest.approx(own)
        assert step["whole"]["mean_vertex_distance"] == pytest.approx(whole)
    assert result["steps"][0]["whole"]["mean_vertex_distance"] == result["steps"][0]["mean_vertex_distance"]
    assert result["steps"][1]["whole"]["mean_vertex_distance"] != result["steps"][1]["mean_vertex_distance"]


def test_a_later_step_begins_from_above_and_with_what_the_one_before_it_found(learned: Path) -> None:
    results = [json.loads((learned / step / "result.json").read_text()) for step in ("step-1", "step-2")]
    best = results[0]["trials"][results[0]["best"]]["parameters"]
    first, second = (each.fold for each in (task(), task().next(_end(learned / "step-1"))))
    assert "first" not in results[0]
    *curves, begun = results[1]["first"]
    assert [trial["parameters"] for trial in results[1]["trials"]] == [*curves, begun][: len(results[1]["trials"])]
    for curve in curves:
        assert (curve["x1"], curve["x2"], curve["z1"]) == (0.0, second.span, curve["z2"])
        assert curve["g1"] == curve["g2"]
    heights = [curve["z1"] / second.span for curve in curves]
    assert heights[0] == pytest.approx(ARCHED) and heights[1:] == pytest.approx([HIGH] * (len(curves) - 1))
    assert {curve["g1"] for curve in curves[1:]} >= {0, second.candidates - 1}
    for name in ("x1", "z1", "x2", "z2"):
        assert begun[name] / second.span == pytest.approx(best[name] / first.span)
    for name in ("g1", "g2"):
        part = best[name] / (first.candidates - 1)
        assert begun[name] == pytest.approx(part * (second.candidates - 1), abs=0.5)


def test_all_steps_have_the_same_scenarios(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tatamu.study.loop.SUCCESS_SIMULATIONS", 2)
    off = Disturbances.model_validate({"hands": {"offset": [0.001, 0.0, 0.0]}})
    options = LearnOptions(trials=1, sampler="random", baselines=False, disturbances=off, level=0.5)
    learn(task(), options, out=tmp_path)
    steps = [ResultFolder(tmp_path / name).record for name in ("step-1", "step-2")]
    assert [(step.disturbances, step.level) for step in steps] == [(off.describe(), 0.5)] * 2
    learn(task(), LearnOptions(trials=1, sampler="random", baselines=False, level=0.5), out=tmp_path)
    again = [ResultFolder(tmp_path / name).record for name in ("step-1", "step-2")]
    assert again == steps, "without options the plan goes on with what it started with"


@pytest.mark.parametrize("grasps", ["integer", "continuous"])
def test_what_is_transferred_can_be_searched(grasps: Any) -> None:
    first, second = task().fold, task(fold="half", size=(0.3, 0.9)).fold
    assert second.candidates > first.candidates

    def ends(space: Space, bound: str) -> dict[str, Any]:
        return {name: getattr(part, bound) for name, part in space.bounds.items()}

    for bound in ("low", "high"):
        extreme, wanted = (ends(search_space(fold, grasps), bound) for fold in (first, second))
        assert transfer(extreme, first, second, grasps) == pytest.approx(wanted)


def _end(folder: Path) -> np.ndarray:
    return Rollout.load(folder / "rollout.npz").positions[-1]


def test_a_finished_plan_is_left_alone(learned: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = bytes_in(learned)
    monkeypatch.setattr("tatamu.evaluation.nominal.simulate", None)
    learn_plan(learned, 2)
    assert bytes_in(learned) == before


def test_a_plan_stopped_anywhere_ends_the_same(learned: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    calls = iter(range(100))

    def killed(scene: Scene, name: str) -> Rollout:
        if next(calls) == 3:
            raise SystemExit
        return simulate(scene, name)

    monkeypatch.setattr("tatamu.evaluation.nominal.simulate", killed)
    with pytest.raises(SystemExit):
        learn_plan(tmp_path, 2)
    assert (tmp_path / "step-2" / "study.db").exists()
    assert not (tmp_path / "result.json").exists()
    monkeypatch.undo()
    learn_plan(tmp_path, 2)
    assert timeless(tmp_path) == timeless(learned)


@pytest.mark.slow
def test_more_trials_begin_later_steps_anew_when_the_first_ends_better(learned: Path, tmp_path: Path) -> None:
    shutil.copytree(learned, tmp_path / "plan")
    learn_plan(tmp_path / "plan", 4)
    result = json.loads((tmp_path / "plan" / "result.json").read_text())
    assert [step["trials"] for step in result["steps"]] == [4, 4]
    learn_plan(tmp_path / "fresh", 4)
    assert timeless(tmp_path / "fresh") == timeless(tmp_path / "plan")


def test_a_plan_in_memory_is_the_one_in_its_folder(learned: Path, tmp_path: Path) -> None:
    plan = learn_plan(None, 2)
    assert plan.folder is None and len(plan.steps) == 2
    plan.save(tmp_path)
    assert timeless(tmp_path) == timeless(learned)
    whole, kept = plan.rollout, Rollout.load(learned / "rollout.npz")
    assert whole.positions.tobytes() == kept.positions.tobytes()
    again = load(tmp_path)
    assert isinstance(again, PlanResult) and again.record == plan.record


def test_plans_and_single_folds_do_not_share_a_folder(learned: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="plan of several steps"):
        learn_plan(learned, 2, task(fold="half"))
    (tmp_path / "study.db").touch()
    with pytest.raises(InputError, match="but contains a single fold; give another folder"):
        learn_plan(tmp_path, 2)


def test_the_model_of_a_plan_reads_and_writes_the_same_bytes(learned: Path) -> None:
    folder = ResultFolder(learned)
    assert json.dumps(folder.plan_record.model_dump(), indent=1) + "\n" == folder.result_file.read_text()
    assert [step.path.name for step in folder.learned_steps()] == ["step-1", "step-2"]


@pytest.mark.parametrize("name", ["javascript:alert(1)//", "../..", "/etc", "step-1/.."])
def test_a_foreign_plan_names_no_folder_outside(learned: Path, tmp_path: Path, name: str) -> None:
    foreign = json.loads((learned / "result.json").read_text())
    foreign["steps"][0]["folder"] = name
    (tmp_path / "result.json").write_text(json.dumps(foreign))
    with pytest.raises(InputError, match=r"result\.json: steps\.0\.folder: must match \^step-"):
        _ = ResultFolder(tmp_path).plan_record


def test_one_hand_learns_a_fold(tmp_path: Path) -> None:
    learn(task(fold="half", hands=1), plain(trials=1, sampler="random", baselines=False), out=tmp_path)
    arms = json.loads((tmp_path / "manipulation.json").read_text())["arms"]
    assert [arm["name"] for arm in arms] == ["left"]
    result = json.loads((tmp_path / "result.json").read_text())
    assert result["task"]["hands"] == 1
    assert set(result["trials"][0]["parameters"]) == {"x1", "z1", "x2", "z2", "g1", "g2"}
    assert set(result["crossings"]) == {"final", "most"}


def test_the_report_replays_all_steps_in_one_timeline(learned: Path) -> None:
    page = (learned / "report.html").read_text()
    data = json.loads(re.findall(r'id="replay-data">(.*?)</script>', page)[0])
    whole = Rollout.load(learned / "rollout.npz")
    assert data["times"][-1] == pytest.approx(whole.times[-1], abs=1e-4)
    start = whole.extra["step_starts"][1]
    for hand in data["hands"]:
        assert [closes for closes, _ in hand["holds"]] == pytest.approx([0.0, start])
        assert len(hand["path"]) == len(data["times"])
        assert np.linalg.norm(np.diff(hand["path"], axis=0), axis=1).max() < 0.1, "hands go to their next grasp"
    assert "step-1/report.html" in page and "2. in half along the length" in page
    assert "step 2 of 2" in (learned / "step-2" / "report.html").read_text()
    assert "{{" not in page.split("<script")[0]


def test_a_hand_that_has_nothing_to_do_waits(learned: Path) -> None:
    plan = load(learned)
    assert isinstance(plan, PlanResult)
    folds = plan.steps
    first = hands(folds[0])[1].path
    path = joined_path([first, None], folds)
    assert len(path) == sum(len(fold.rollout.times) for fold in folds) - 1
    assert (path[len(first) :] == first[-1]).all()
