"""Studies: found again after any interruption, refused when they are another's."""

from __future__ import annotations

import json
import multiprocessing
import pickle
import shutil
import signal
import sqlite3
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import optuna
import pytest

from tatamu import InputError, Nominal, Rollout, Scene, SimulationError, Task, TatamuError, simulate
from tatamu.evaluation.nominal import failed
from tatamu.folding.manipulation import Manipulation, trajectory_lengths
from tatamu.folding.parameters import search_space
from tatamu.folding.task import Reach, make_task
from tatamu.study.folder import ResultFolder
from tatamu.study.record import describe_task
from tests.small_studies import X, bytes_in, learn_plain, timeless
from tests.small_studies import towel as task


@pytest.fixture
def simulated(monkeypatch: pytest.MonkeyPatch) -> list[Scene]:
    """The scenes that trials simulate, as they come."""
    scenes: list[Scene] = []

    def counted(scene: Scene, name: str) -> Rollout:
        scenes.append(scene)
        return simulate(scene, name)

    monkeypatch.setattr("tatamu.evaluation.nominal.simulate", counted)
    return scenes


@pytest.fixture(scope="module")
def learned(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("learned")
    learn_plain(task(), folder, trials=6)
    return folder


def test_the_folder_holds_what_the_contract_says(learned: Path) -> None:
    names = {path.name for path in learned.iterdir()} - {".lock"}
    assert names == {"result.json", "manipulation.json", "scene.json", "rollout.npz", "study.db", "report.html"}
    data = json.loads((learned / "result.json").read_text())
    assert [t["number"] for t in data["trials"]] == list(range(6))
    best = data["trials"][data["best"]]
    assert best["objective"] == min(t["objective"] for t in data["trials"])
    assert set(best["parameters"]) == {"x1", "z1", "x2", "z2", "g1", "g2"}
    assert best["objective"] == pytest.approx(best["trajectory_length"] + 0.01 * best["shape_distance"])
    assert {b["name"] for b in data["baselines"]} == {"li-2015", "triangle", "circle"}


def test_the_saved_scene_gives_the_saved_rollout(learned: Path) -> None:
    rollout = Rollout.load(learned / "rollout.npz")
    again = simulate(Scene.load(learned / "scene.json"))
    assert again.positions.tobytes() == rollout.positions.tobytes()
    assert rollout.extra["target"].shape == rollout.positions.shape[1:]


def test_the_models_read_and_write_the_same_bytes(learned: Path) -> None:
    folder = ResultFolder(learned)
    for file, model in (
        (folder.result_file, folder.record),
        (folder.manipulation_file, folder.manipulation.describe()),
    ):
        assert json.dumps(model.model_dump(), indent=1) + "\n" == file.read_text()


def test_optuna_opens_the_study(learned: Path) -> None:
    study = optuna.load_study(study_name=None, storage=f"sqlite:///{learned / 'study.db'}")
    assert len(study.trials) == 6
    assert all(t.state == optuna.trial.TrialState.COMPLETE for t in study.trials)


def test_a_finished_study_is_left_alone(learned: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = bytes_in(learned)
    monkeypatch.setattr("tatamu.evaluation.nominal.simulate", None)
    learn_plain(task(), learned, trials=6)
    assert bytes_in(learned) == before


def test_more_trials_go_on_where_the_study_stopped(learned: Path, tmp_path: Path) -> None:
    learn_plain(task(), tmp_path, trials=2)
    learn_plain(task(), tmp_path, trials=6)
    assert timeless(tmp_path) == timeless(learned)


WHOLE = "from tatamu.cli import main; main()"
KILLED = f"""
import os, signal, optuna

def told(study, trial, add=optuna.Study.add_trial):
    add(study, trial)
    if len(study.trials) == 3:
        os.kill(os.getpid(), signal.SIGKILL)

optuna.Study.add_trial = told
{WHOLE}
"""
"""A program that is killed as soon as its third trial is kept."""


def test_a_run_that_is_killed_goes_on_to_the_same_result(tmp_path: Path) -> None:
    learn_plain(task(), tmp_path / "once", trials=6)
    folder = tmp_path / "twice"
    arguments = ["towel", "--size", "0.24x0.5", "--spacing", "0.04", "--trials", "6", "--out", str(folder)]
    arguments += ["--disturbances", "none"]
    killed, whole = ([sys.executable, "-c", code, "learn", *arguments] for code in (KILLED, WHOLE))
    assert subprocess.run(killed, stdout=subprocess.DEVNULL).returncode == -signal.SIGKILL
    assert _told(folder) == 3
    subprocess.run(whole, check=True, stdout=subprocess.DEVNULL)
    assert timeless(folder) == timeless(tmp_path / "once")


def _told(folder: Path) -> int:
    """Finished trials, read without Optuna, which would make the tables that the run is about to make."""
    if not (folder / "study.db").exists():
        return 0
    try:
        with closing(sqlite3.connect(f"file:{folder / 'study.db'}?mode=ro", uri=True)) as database:
            return int(database.execute("select count(*) from trials").fetchone()[0])
    except sqlite3.OperationalError:  # the database is being made at this moment
        return 0


def test_continuous_grasps_are_floored(tmp_path: Path) -> None:
    learn_plain(task(), tmp_path, trials=2, grasps="continuous", sampler="random", baselines=False)
    data = json.loads((tmp_path / "result.json").read_text())
    parameters = data["trials"][0]["parameters"]
    assert parameters["g1"] != int(parameters["g1"])
    fold = task().fold
    floored = {**parameters, "g1": int(parameters["g1"]), "g2": int(parameters["g2"])}
    assert task().manipulation(parameters).grasps == task().manipulation(floored).grasps
    assert task().manipulation(parameters).grasps[0] == fold.left[int(parameters["g1"])]


def test_a_failed_trial_is_a_finite_penalty_that_the_search_keeps(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls = iter(range(100))

    def sometimes(scene: Scene, name: str) -> Rollout:
        if next(calls) == 1:
            raise SimulationError("blew up")
        return simulate(scene, name)

    monkeypatch.setattr("tatamu.evaluation.nominal.simulate", sometimes)
    learn_plain(task(), tmp_path, trials=3, baselines=False, parallel=1)
    trials = json.loads((tmp_path / "result.json").read_text())["trials"]
    assert [t["state"] for t in trials] == ["complete", "failed", "complete"]
    assert trials[1]["error"] == "blew up"
    assert trials[1]["mean_vertex_distance"] is None
    assert trials[0]["objective"] < trials[1]["objective"] < 1e3


def test_a_study_that_is_killed_while_it_writes_is_written_the_next_time(
    learned: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "study"
    shutil.copytree(learned, folder)
    with monkeypatch.context() as killed, pytest.raises(KeyboardInterrupt):
        killed.setattr("tatamu.study.folder.ResultFolder.write_record", interrupt)
        learn_plain(task(), folder, trials=7)
    learn_plain(task(), folder, trials=7)
    assert len(json.loads((folder / "result.json").read_text())["trials"]) == 7


def interrupt(*_: Any) -> None:
    raise KeyboardInterrupt


@pytest.mark.parametrize("made", [{}, {"hands": 1}, {"garment": "tshirt", "spacing": 0.03}])
def test_the_path_length_that_the_search_knows_is_that_of_the_manipulation(made: dict[str, Any]) -> None:
    asked = make_task(**{"garment": "towel", "spacing": 0.04, **made})
    random = np.random.default_rng(0)
    space = search_space(asked.fold).bounds
    values = {name: each.low + (each.high - each.low) * random.random(20) for name, each in space.items()}
    values |= {name: np.round(values[name]) for name in ("g1", "g2")}
    exact = [
        asked.manipulation({name: float(value[number]) for name, value in values.items()}).trajectory_length
        for number in range(20)
    ]
    assert trajectory_lengths(asked.fold, values) == pytest.approx(exact, rel=2e-4)


def with_fold(one: Task, **changes: Any) -> Task:
    """The task with another fold than it would make."""
    other = replace(one)
    other.__dict__["fold"] = replace(one.fold, **changes)
    return other


def test_tasks_that_differ_in_the_mesh_or_the_robot_are_told_apart() -> None:
    one = task()
    moved = one.fold.start + np.array([0.0, 1e-4, 0.0])
    others = [
        with_fold(one, start=moved),
        with_fold(one, right=one.fold.right[:-1]),
        with_fold(one, area_ratio=0.4),
        replace(one, reach=Reach("mine", lambda _: 1.0, description=b"a")),
        replace(one, reach=Reach("mine", lambda _: 1.0, description=b"b")),
    ]
    assert len({describe_task(each).model_dump_json() for each in (one, *others)}) == 6
    assert describe_task(one) == describe_task(task())


def blow_up(*_: Any) -> Any:
    raise SimulationError("blew up")


@pytest.mark.parametrize("kept", [True, False])
def test_a_study_in_which_all_fails_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kept: bool) -> None:
    monkeypatch.setattr("tatamu.evaluation.nominal.simulate", blow_up)
    with pytest.raises(TatamuError, match="all 2 trials failed; last error: blew up"):
        learn_plain(task(), tmp_path if kept else None, trials=2, baselines=False)


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"seed": 1}, "seed was 0, is now 1"),
        ({"sampler": "random"}, 'sampler was "gp", is now'),
        ({"trials": 3}, "trials: must be at least 6, given 3; .* already has 6 trials"),
    ],
)
def test_another_study_is_not_touched(learned: Path, changes: dict[str, Any], named: str) -> None:
    with pytest.raises(InputError, match=named):
        learn_plain(task(), learned, **{"trials": 6, **changes})


def test_another_towel_is_not_touched(learned: Path) -> None:
    with pytest.raises(InputError, match=r"task\.size was \[0\.24, 0\.5\], is now \[0\.24, 0\.6\]"):
        learn_plain(task(size=(0.24, 0.6)), learned, trials=6)


@pytest.mark.parametrize("content", [b"not a database at all", b"SQLite format 3\x00" + b"\xff" * 4000])
def test_a_corrupted_study_is_refused_and_kept(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "study.db").write_bytes(content)
    with pytest.raises(InputError, match=r"study\.db: must be a readable Optuna study"):
        learn_plain(task(), tmp_path, trials=2)
    assert (tmp_path / "study.db").read_bytes() == content


def test_a_study_of_somebody_elses_is_refused(tmp_path: Path) -> None:
    study = optuna.create_study(storage=f"sqlite:///{tmp_path / 'study.db'}", study_name="tatamu")
    study.add_trial(optuna.trial.create_trial(value=1.0))
    with pytest.raises(InputError, match="contains a study that tatamu did not make; give another folder"):
        learn_plain(task(), tmp_path, trials=2)


@pytest.mark.parametrize(
    ("changes", "named"), [({"trials": 0}, "trials"), ({"seed": -1}, "seed"), ({"sampler": "magic"}, "one of gp")]
)
def test_arguments_out_of_range_are_refused_before_anything_is_made(
    tmp_path: Path, changes: dict[str, Any], named: str
) -> None:
    with pytest.raises(InputError, match=named):
        learn_plain(task(), tmp_path / "new", **changes)
    assert not (tmp_path / "new").exists()


def test_a_folder_that_is_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine")
    with pytest.raises(InputError, match="cannot be written"):
        learn_plain(task(), tmp_path / "file", trials=1)
    assert (tmp_path / "file").read_text() == "mine"


def processes() -> Executor:
    return ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn"))


class Low:
    """A robot that reaches no higher than P1 at 8 cm."""

    def __init__(self) -> None:
        self.asked: list[float] = []

    def __call__(self, manipulation: Manipulation) -> float:
        height = float(manipulation.curves[0].control[1, 2])
        self.asked.append(height)
        return 0.08 - height


def test_what_a_robot_cannot_reach_is_not_simulated_and_fails(tmp_path: Path, simulated: list[Scene]) -> None:
    low = Low()
    reached = task(reach=Reach("low", low))
    learn_plain(reached, tmp_path, trials=6, baselines=False)
    result = json.loads((tmp_path / "result.json").read_text())
    beyond = [trial for trial in result["trials"] if trial["state"] == "failed"]
    assert result["task"]["robot"] == "low"
    assert beyond and len(simulated) == 6 - len(beyond)
    assert len(beyond) == sum(height > 0.08 for height in low.asked)
    for trial in beyond:
        assert trial["error"] == "out of reach of low"
        assert trial["objective"] > failed(reached.fold, trial["trajectory_length"], "").objective
    low.asked.clear()
    learn_plain(reached, tmp_path, trials=7, baselines=False)
    assert len(low.asked) == 1, "what is stored is not asked again"


def test_a_study_for_a_robot_is_not_one_for_any(learned: Path) -> None:
    with pytest.raises(InputError, match="robot"):
        learn_plain(task(reach=Reach("low", Low())), learned, trials=6)


@pytest.mark.parametrize("reach", [None, "low"])
@pytest.mark.parametrize("elsewhere", [lambda: ThreadPoolExecutor(1), lambda: ThreadPoolExecutor(7), processes])
def test_a_study_is_the_same_wherever_its_trials_run(
    tmp_path: Path, elsewhere: Callable[[], Executor], reach: str | None
) -> None:
    def asked() -> Task:
        return task(reach=Reach(reach, Low()) if reach else None)

    learn_plain(asked(), tmp_path / "here", trials=7)
    with elsewhere() as executor:
        learn_plain(asked(), tmp_path / "there", trials=7, executor=executor)
    assert timeless(tmp_path / "here") == timeless(tmp_path / "there")


def test_a_study_that_stops_and_goes_on_proposes_what_it_would_have(tmp_path: Path) -> None:
    learn_plain(task(), tmp_path / "once", trials=6, parallel=2, baselines=False)
    for trials in (3, 6):
        learn_plain(task(), tmp_path / "twice", trials=trials, baselines=False, parallel=2)
    assert timeless(tmp_path / "once") == timeless(tmp_path / "twice")


def test_a_study_that_was_started_one_by_one_goes_on_so(tmp_path: Path) -> None:
    learn_plain(task(), tmp_path / "once", trials=6, parallel=1, baselines=False)
    learn_plain(task(), tmp_path / "twice", trials=3, parallel=1, baselines=False)
    learn_plain(task(), tmp_path / "twice", trials=6, baselines=False)
    assert timeless(tmp_path / "once") == timeless(tmp_path / "twice")


def test_what_an_executor_is_given_can_be_pickled() -> None:
    asked = Nominal(task(reach=Reach("low", Low())))
    travelled = pickle.loads(pickle.dumps(asked))
    assert travelled.task.reach is None, "the robot stays with the process that proposes"
    here = pickle.loads(pickle.dumps(travelled(X)))
    again = asked(X)
    assert here.objective == again.objective
    assert here.rollout and again.rollout
    assert here.rollout.positions.tobytes() == again.rollout.positions.tobytes()


def test_a_study_simulates_each_trial_once(tmp_path: Path, simulated: list[Scene]) -> None:
    """The first trial and the best of ten, which the report shows, are kept until it is written."""
    learn_plain(task(), tmp_path, trials=12, sampler="random", baselines=False)
    objectives = [trial["objective"] for trial in json.loads((tmp_path / "result.json").read_text())["trials"]]
    assert min(objectives) < objectives[0]  # or there would be nothing to keep but the best
    assert len(simulated) == 12


@pytest.mark.parametrize(("parallel", "simulator"), [(0, "native"), (17, "mujoco")])
def test_wrong_parallel_is_refused(tmp_path: Path, parallel: int, simulator: str) -> None:
    with pytest.raises(InputError, match="parallel"):
        learn_plain(task(simulator=simulator), tmp_path / "study", trials=2, parallel=parallel)
    assert not (tmp_path / "study").exists()
