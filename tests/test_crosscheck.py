"""A second opinion: the same hands in another simulator."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from benchmarks import crosscheck

from tatamu.after.second_opinion import check
from tatamu.after.second_opinion.check import modify_scene
from tatamu.api import learn
from tatamu.base.errors import InputError
from tatamu.folding.task import make_task
from tatamu.report import command
from tatamu.simulation.material import Material
from tatamu.simulation.mesh.meshing import subdivided
from tatamu.simulation.mesh.topology import Topology, areas
from tatamu.simulation.scene import Gripper, Scene
from tatamu.simulation.simulators import SIMULATORS, simulate
from tatamu.study.options import LearnOptions
from tatamu.study.record import describe_task
from tatamu.study.result import Result
from tests import shifted
from tests.browser import Phone
from tests.commands import refused, tatamu
from tests.foreign import GOOD
from tests.scenes import CLOTH, scene, seamed


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small towel that was folded three times; some trial of three is never good."""
    where = tmp_path_factory.mktemp("learned") / "towel"
    options = LearnOptions(trials=3, seed=1, disturbances="none", baselines=False)
    learn(make_task("towel", size=(0.2, 0.3), spacing=0.02), options, out=where)
    return where


@pytest.fixture(scope="module")
def learned(folder: Path) -> Result:
    return Result.load(folder)


@pytest.fixture(autouse=True)
def other(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The simulator `shifted`, which shifts by nothing unless told."""
    monkeypatch.setitem(SIMULATORS, "shifted", "tests.shifted")
    monkeypatch.setattr(shifted, "SHIFT", np.zeros(3))
    shifted.CALLS.clear()
    shifted.FAILS_AT.clear()
    yield


def test_the_same_simulator_says_the_same(learned: Result) -> None:
    opinion = check(learned, "native")
    assert opinion.apart.max() == 0.0
    assert opinion.score == learned.score
    best = learned.best
    assert best.score == learned.score


def test_another_opinion_is_measured_and_judged(learned: Result, monkeypatch: pytest.MonkeyPatch) -> None:
    wrong = learned.target - learned.final
    monkeypatch.setattr(shifted, "SHIFT", wrong)  # every vertex on its target
    perfect = check(learned, "shifted")
    assert perfect.holds and perfect.score is not None
    assert perfect.score.mean_vertex_distance < 1e-9
    assert perfect.apart == pytest.approx(np.linalg.norm(wrong, axis=1))
    monkeypatch.setattr(shifted, "SHIFT", wrong + np.array([0.03, 0.0, 0.0]))
    off = check(learned, "shifted")
    assert off.score is not None and off.score.mean_vertex_distance == pytest.approx(0.03)
    assert not off.holds


def test_a_simulation_that_fails_is_an_opinion(learned: Result) -> None:
    shifted.FAILS_AT[:] = [0]
    opinion = check(learned, "shifted")
    assert not opinion.holds and opinion.score is None
    assert opinion.to_json()["error"] == "shifted: the cloth was stretched"


def test_cloth_of_another_thickness_lies_on_the_table(learned: Result) -> None:
    thick = learned.scene.material.model_copy(update={"thickness": 0.004})
    assert modify_scene(learned.scene, thick, False).cloth.vertices[:, 2] == pytest.approx(0.002)
    assert check(learned, "shifted", thick).scene.material == thick


@pytest.fixture
def hinged() -> Scene:
    return scene(cloth=seamed(), grippers=[Gripper(vertices=[0, 1, 2], times=[0.0], displacements=[[0, 0, 0]])])


def test_a_finer_mesh_is_the_same_cloth(hinged: Scene) -> None:
    fine = subdivided(hinged)
    cloth, before = fine.cloth, hinged.cloth
    count = len(before.vertices)
    assert np.array_equal(cloth.vertices[:count], before.vertices)
    assert len(cloth.faces) == 4 * len(before.faces)
    assert areas(cloth.vertices, cloth.faces) == pytest.approx(np.tile(areas(before.vertices, before.faces) / 4, 4))
    assert len(Topology(cloth.faces).border) == 2 * len(Topology(before.faces).border)
    normals = np.cross(*(cloth.vertices[cloth.faces[:, k]] - cloth.vertices[cloth.faces[:, 0]] for k in (1, 2)))
    assert (normals[:, 2] > 0).all()
    middle = cloth.vertices[cloth.seams.ravel()]
    assert len(cloth.seams) == 2 * len(before.seams) and np.abs(middle[:, 0]).max() < 1e-6
    held = set(fine.grippers[0].vertices)
    assert {0, 1, 2} < held and max(np.abs(cloth.vertices[list(held), 0] + 0.12)) < 0.03


def test_a_fold_on_a_finer_mesh_is_compared_on_the_coarse_one(learned: Result) -> None:
    opinion = check(learned, "shifted", halved=True)
    assert len(shifted.CALLS[0].cloth.vertices) > 3 * len(learned.start)
    assert opinion.rollout is not None
    assert opinion.rollout.positions.shape[1] == len(learned.start)
    assert 0.0 < opinion.apart.mean() < 0.05


def test_simulators_are_compared_and_every_simulation_is_kept(
    learned: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shifted.FAILS_AT[:] = [1]
    for _ in range(2):
        columns = crosscheck.compare(learned, ["native", "shifted"], tmp_path, count=2)
        assert len(shifted.CALLS) == 6, "nothing is simulated twice"
    row = crosscheck.pair(columns, "native", "shifted")
    assert row["rank of mean distance"] == "1.00" and row["mean [mm]"] == row["learned [mm]"] == "0.0"
    failed = columns["shifted"]["li-2015"]
    assert failed.final is None and failed.objective > columns["native"]["li-2015"].objective
    assert crosscheck.distances(columns)[1]["shifted"] == "failed"


def test_the_exit_code_is_the_verdict(
    learned: Result,
    folder: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    phone: Phone,
) -> None:
    monkeypatch.setattr(shifted, "SHIFT", learned.target - learned.final)
    words = ("check", str(folder), "--simulator", "shifted", "--out")
    assert tatamu(*words, str(tmp_path / "a")).returncode == 0
    told = json.loads((tmp_path / "a/check.json").read_text())
    assert told["holds"] and told["distance_between_final_shapes"]["mean"] > 0
    page = (tmp_path / "a/check.html").read_text()
    before = page.split("plotly.js")[0].replace("http-equiv", "").replace("http://www.w3.org/2000/svg", "")
    assert "succeeds in shifted" in page and "http" not in before
    assert (tmp_path / "a/check.png").read_bytes().startswith(b"\x89PNG")
    monkeypatch.setattr(shifted, "SHIFT", np.array([0.2, 0.0, 0.0]))
    done = tatamu(*words, str(tmp_path / "b"))
    assert done.returncode == 1 and "fails in shifted" in done.stdout
    phone(tmp_path / "a/check.html")


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ((), "--simulator: must be"),
        (("--simulator", "unreal"), "simulator: must be one of"),
        (("--all", "--random", "5"), "--all: no longer exists; run `python -m benchmarks.crosscheck`"),
        (("--simulator", "native", "--material", "none.toml"), "none.toml"),
    ],
)
def test_wrong_input_is_one_line(folder: Path, words: tuple[str, ...], says: str) -> None:
    assert says in refused("check", str(folder), *words)


def test_a_folder_that_cannot_be_made_again_is_refused(folder: Path, tmp_path: Path) -> None:
    for name in ("manipulation.json", "scene.json", "rollout.npz"):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    told = json.loads((folder / "result.json").read_text())
    told["task"]["material"] = Material(**{**CLOTH.model_dump(), "thickness": 0.004}).model_dump()
    (tmp_path / "result.json").write_text(json.dumps(told))
    with pytest.raises(
        InputError, match="the target of the task has changed since the fold was learned; learn the fold again"
    ):
        _ = Result.load(tmp_path).task
    (tmp_path / "step-1").mkdir()
    with pytest.raises(InputError, match="several steps"):
        Result.load(tmp_path)


def test_a_rollout_of_the_finer_mesh_has_the_coarse_one_in_it(learned: Result) -> None:
    rollout = simulate(subdivided(learned.scene).model_copy(update={"duration": 0.05}))
    assert np.array_equal(rollout.positions[0, : len(learned.start)], learned.start)


def test_a_fold_of_a_garment_and_plan_of_ones_own_is_checked_too(tmp_path: Path) -> None:
    garment = GOOD["cloth_obj"](tmp_path)
    plan = tmp_path / "mine.toml"
    plan.write_text('[[step]]\nline = [[0.0, -0.5], [0.0, 0.5]]\nmoves = "-x"\nhands = 1\n')
    task = make_task(str(garment), fold=str(plan))
    learn(task, LearnOptions(trials=1, disturbances="none", baselines=False), out=tmp_path / "learned")
    again = Result.load(tmp_path / "learned")
    assert describe_task(again.task) == describe_task(task)
    assert "--hands" not in command.learn(again)
    told = command.learn(again)
    assert str(garment) in told and str(plan) in told
