"""A result folder holds all that it was made from: it can be moved, and so can the user's files."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tatamu.api import learn
from tatamu.base.errors import InputError
from tatamu.folding.task import make_task
from tatamu.simulation.material import load_material
from tatamu.study.inputs import Sources, keep_inputs, kept_input
from tatamu.study.options import LearnOptions
from tatamu.study.result import Result
from tests.foreign import svg

LOOP = '<path id="o" d="M50 20 L250 20 L290 380 L10 380 Z"/>'
GARMENT = '[garment]\noutline = "../patterns/bag.svg"\n'
PLAN = """[plan]
name = "mine"
[[step]]
line = [[0.0, -0.5], [0.0, 0.5]]
moves = "+x"
[[step]]
line = [[-0.15, -0.5], [-0.15, 0.5]]
moves = "-x"
"""
SEARCH = LearnOptions(trials=1, sampler="random", disturbances="none", baselines=False)


@pytest.fixture
def desk(tmp_path: Path) -> Path:
    """A user's files: a garment that names its outline in another folder, a plan, a material."""
    desk = tmp_path / "desk"
    for name in ("garments", "patterns"):
        (desk / name).mkdir(parents=True)
    (desk / "garments" / "bag.toml").write_text(GARMENT)
    (desk / "patterns" / "bag.svg").write_text(svg(LOOP))
    (desk / "plan.toml").write_text(PLAN)
    shutil.copy(
        Path(__file__).parent.parent / "src" / "tatamu" / "simulation" / "presets" / "cotton.toml", desk / "mine.toml"
    )
    return desk


def learned(desk: Path, folder: Path, **changes: Any) -> Path:
    options = {"fold": str(desk / "plan.toml"), "material": desk / "mine.toml", "spacing": 0.04, **changes}
    learn(make_task(str(desk / "garments" / "bag.toml"), **options), SEARCH, out=folder)
    return folder


def check_copies(desk: Path, inputs: Path) -> None:
    """The copies are the files to the byte, and keep their places."""
    named = json.loads((inputs / "files.json").read_text())
    assert named == {"garment": "garment/garments/bag.toml", "fold": "fold/plan.toml", "material": "material/mine.toml"}
    assert (inputs / "garment" / "patterns" / "bag.svg").read_bytes() == (desk / "patterns" / "bag.svg").read_bytes()
    assert (inputs / "fold" / "plan.toml").read_text() == PLAN
    assert load_material(inputs / "material" / "mine.toml") == load_material(desk / "mine.toml")


def test_inputs_are_copied_and_a_folder_and_the_users_files_can_be_moved(
    desk: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = learned(desk, tmp_path / "out")
    check_copies(desk, folder / "inputs")
    before = [Result.load(folder / f"step-{number}").task for number in (1, 2)]
    shutil.rmtree(desk)
    shutil.move(folder, tmp_path / "elsewhere" / "moved")
    monkeypatch.chdir(tmp_path / "elsewhere" / "moved" / "step-1")
    again = [Result.load(Path(place)).task for place in (".", "../step-2")]
    for one, other in zip(before, again, strict=True):
        assert (one.fold.target == other.fold.target).all()
        assert one.fold.garment.material == other.fold.garment.material


def test_the_plan_that_was_found_for_a_garment_is_kept(
    desk: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Another version may propose another plan."""
    folder = learned(desk, tmp_path / "out", fold="auto", material=None)
    target = Result.load(folder).task.fold.target

    def proposes_nothing(*_: object) -> None:
        raise AssertionError("the plan was looked for again")

    monkeypatch.setattr("tatamu.folding.plans.propose", proposes_nothing)
    assert (Result.load(folder).task.fold.target == target).all()


def test_a_garment_by_name_needs_no_copies(tmp_path: Path) -> None:
    learn(make_task("towel", size=(0.24, 0.5), spacing=0.04, material=Path("denim")), SEARCH, out=tmp_path)
    assert not (tmp_path / "inputs").exists()


def test_a_folder_of_another_study_keeps_its_own_files(desk: Path, tmp_path: Path) -> None:
    folder = learned(desk, tmp_path / "out", fold="half")
    before = (folder / "inputs" / "garment" / "patterns" / "bag.svg").read_bytes()
    (desk / "patterns" / "bag.svg").write_text(svg(LOOP.replace("380", "360")))
    with pytest.raises(InputError, match="contains a study with other options"):
        learned(desk, folder, fold="half")
    assert (folder / "inputs" / "garment" / "patterns" / "bag.svg").read_bytes() == before


def test_sources_that_cannot_be_read_are_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.toml: cannot be read"):
        keep_inputs(tmp_path, {"fold": Sources([tmp_path / "none.toml"])})


@pytest.mark.parametrize("text", ["[]", '{"fold": 3}'])
def test_a_wrong_index_is_named(tmp_path: Path, text: str) -> None:
    (tmp_path / "inputs").mkdir()
    (tmp_path / "inputs" / "files.json").write_text(text)
    with pytest.raises(InputError, match=r"files\.json: must contain a file name for each kind"):
        kept_input(tmp_path, "fold")


@pytest.mark.parametrize("path", ["/etc/passwd", "../../secret.toml", "fold/../../secret.toml"])
def test_an_index_names_no_file_outside_the_folder(tmp_path: Path, path: str) -> None:
    (tmp_path / "inputs").mkdir()
    (tmp_path / "inputs" / "files.json").write_text(json.dumps({"fold": path}))
    with pytest.raises(InputError, match=r"files\.json: fold: must be a path inside inputs"):
        kept_input(tmp_path, "fold")


def test_the_task_is_rebuilt_as_it_was(desk: Path, tmp_path: Path) -> None:
    folder = learned(desk, tmp_path / "out", fold="half")
    fold = Result.load(folder)
    assert np.array_equal(fold.task.fold.start, fold.start)
