"""What a user may do by mistake: nothing is lost, and one line says what was wrong."""

from __future__ import annotations

import shutil
import sqlite3
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import Field

from tatamu.api import learn
from tatamu.base.errors import InputError, TatamuError
from tatamu.base.files import check_targets, read_toml, validated
from tatamu.base.records import Record
from tatamu.folding.plan import load_plan
from tatamu.folding.task import make_task
from tatamu.garments import load_garment, make_garment
from tatamu.garments.meshfile import read_mesh
from tatamu.simulation.material import Material
from tatamu.study.options import LearnOptions
from tatamu.study.result import Result
from tests.foreign import svg
from tests.refusals import refusal
from tests.scenes import scene

EXAMPLE = Path(__file__).parent.parent / "examples" / "measurements-towel.toml"
LOOP = '<path id="o" d="M50 20 L250 20 L290 380 L10 380 Z"/>'


def test_what_is_read_is_not_written_over(tmp_path: Path) -> None:
    source = tmp_path / "a.toml"
    shutil.copy(EXAMPLE, source)
    (tmp_path / "b.toml").symlink_to(source)
    (tmp_path / "folder.html").mkdir()
    for target in (source, tmp_path / "b.toml"):
        with pytest.raises(InputError, match="must differ from the input files"):
            check_targets([target], [source])
    with pytest.raises(InputError, match="given a folder"):
        check_targets([tmp_path / "folder.html"], [source])
    check_targets([tmp_path / "new.toml"], [source])


def test_files_of_somebody_else_are_kept(tmp_path: Path) -> None:
    (tmp_path / "report.html").write_text("precious")
    with pytest.raises(InputError, match=r"contains report\.html but no study, so learning would overwrite this file"):
        learn(make_task("towel", spacing=0.04), LearnOptions(trials=1), out=tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["report.html"]
    assert (tmp_path / "report.html").read_text() == "precious"


def test_nobody_is_told_to_remove_a_study_that_another_program_holds(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def held(*_: object, **__: object) -> None:
        from sqlalchemy.exc import OperationalError

        raise OperationalError("CREATE TABLE studies", None, sqlite3.OperationalError("database is locked"))

    monkeypatch.setattr("optuna.create_study", held)
    said = refusal(learn, make_task("towel", spacing=0.04), LearnOptions(trials=1), out=tmp_path)
    assert "another program is using the file" in said and "remove it" not in said and "CREATE" not in said


def test_an_outline_that_stands_twice_is_refused(tmp_path: Path) -> None:
    (tmp_path / "two.svg").write_text(svg(LOOP + LOOP))
    with pytest.raises(InputError, match="must occur once"):
        load_garment(tmp_path / "two.svg")


def test_openings_of_one_name_are_all_open(tmp_path: Path) -> None:
    ends = '<path id="open" d="M50 20 L250 20"/><path id="open" d="M290 380 L10 380"/>'
    (tmp_path / "tube.svg").write_text(svg(LOOP + ends))
    assert sorted(load_garment(tmp_path / "tube.svg").openings) == ["open", "open 2"]


def test_cloth_that_does_not_bend_is_no_garment() -> None:
    limp = Material(areal_density=0.2, stretch_stiffness=100.0, bending_rigidity=0.0)
    with pytest.raises(InputError, match="bending_rigidity: must be above 0"):
        make_garment("towel", material=limp)


def test_a_mark_in_front_of_a_file_is_no_matter(tmp_path: Path) -> None:
    (tmp_path / "m.toml").write_bytes(b"\xef\xbb\xbf" + EXAMPLE.read_bytes())
    assert read_toml(tmp_path / "m.toml") == read_toml(EXAMPLE)


def test_one_mistake_is_counted_once(tmp_path: Path) -> None:
    (tmp_path / "p.toml").write_text('[[step]]\nline = [[0.0, -0.5], [0.0, 0.5]]\nmoves = "-x"\nfoo = 1\n')
    said = refusal(load_plan, tmp_path / "p.toml")
    assert "foo" in said and "more)" not in said


def test_grips_that_hold_the_same_cloth_are_refused() -> None:
    from tatamu.calibration.elongation import Elongation, Grasp

    grasps = [Grasp(edge="bottom"), Grasp(edge="bottom", at=0.2, width=0.05)]
    with pytest.raises(InputError, match=r"elongation\.grasps: must not overlap"):
        _ = Elongation(make_garment("towel"), grasps).held
    apart = [Grasp(edge="bottom", at=0.1, width=0.05), Grasp(edge="bottom", at=0.9, width=0.05)]
    assert len(np.concatenate(Elongation(make_garment("towel"), apart).held)) > 2


@pytest.mark.parametrize("encoding", ["ascii", "binary"])
def test_a_mesh_file_that_ends_early_is_no_smaller_mesh(tmp_path: Path, encoding: str) -> None:
    trimesh = pytest.importorskip("trimesh")
    whole = trimesh.creation.box().export(file_type="ply", encoding=encoding)
    (tmp_path / "whole.ply").write_bytes(whole)
    assert len(read_mesh(tmp_path / "whole.ply").faces) == 12
    remarked = whole.replace(b"element vertex", b"comment every element vertex counts\nelement vertex", 1)
    (tmp_path / "remarked.ply").write_bytes(remarked)
    assert len(read_mesh(tmp_path / "remarked.ply").faces) == 12
    (tmp_path / "cut.ply").write_bytes(whole[:-60])
    with pytest.raises(InputError, match=r"ends too early|is not a mesh file"):
        read_mesh(tmp_path / "cut.ply")


def test_a_study_of_failures_only_holds_no_fold(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tatamu.evaluation.nominal._left_table", lambda *given: True)
    task = make_task("towel", spacing=0.04, size=(0.24, 0.5))
    with pytest.raises(TatamuError, match="all 1 trials failed"):
        learn(task, LearnOptions(trials=1, sampler="random", disturbances="none", baselines=False), out=tmp_path)
    with pytest.raises(InputError, match="but all trials failed"):
        Result.load(tmp_path)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_an_output_that_is_full_is_one_line() -> None:
    command = [sys.executable, "-c", "from tatamu.cli import main; main()", "garments"]
    with open("/dev/full", "w") as full:
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 1
    assert done.stderr == "tatamu: the output cannot be written (No space left on device)\n"


@pytest.mark.skipif(sys.platform == "win32", reason="a shell closes the streams")
@pytest.mark.parametrize("closed", [">&-", "2>&-", "<&-", "<&- >&- 2>&-"])
@pytest.mark.parametrize("command", ["garments", "board --out b.pdf", "simulate s.json --out r.npz"])
def test_a_program_without_standard_streams_works(command: str, closed: str, tmp_path: Path) -> None:
    """Services and `pythonw` start programs without them."""
    scene(duration=1 / 60).save(tmp_path / "s.json")
    line = f'"{sys.executable}" -m tatamu {command} {closed}'
    done = subprocess.run(["sh", "-c", line], capture_output=True, text=True, check=False, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert {path.suffix for path in tmp_path.iterdir()} <= {".json", ".pdf", ".toml", ".npz"}


@pytest.mark.parametrize(("given", "meant"), [({"trial": 3}, "trials"), ({"disturbance": "none"}, "disturbances")])
def test_an_option_with_a_typing_error_gets_the_name_that_is_meant(given: dict[str, Any], meant: str) -> None:
    for make in (LearnOptions, LearnOptions(trials=2).replace):
        with pytest.raises(InputError, match=f"; did you mean {meant}\\?$"):
            make(**given)


def test_the_name_that_is_meant_is_said_of_files_and_inner_tables_too() -> None:
    for given, meant in (
        ({"groun": 1}, "ground"),
        ({"inner": {"trail": 1}}, "trial"),
        ({"many": [{"trail": 1}]}, "trial"),
    ):
        with pytest.raises(InputError, match=f"did you mean {meant}"):
            validated(_Outer, given, "a.toml")


class _Inner(Record):
    trial: int = 0


class _Outer(Record):
    ground: int = 0
    inner: _Inner | None = None
    many: list[_Inner] = Field(default_factory=list)


def test_options_are_replaced_by_name_and_checked() -> None:
    options = LearnOptions(trials=3, disturbances="none")
    assert options.replace(trials=4) == LearnOptions(trials=4, disturbances="none")
    with pytest.raises(InputError, match="trials: must be from 1"):
        options.replace(trials=0)
