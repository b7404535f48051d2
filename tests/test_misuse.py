"""What a user may do by mistake: nothing is lost, and one line says what was wrong."""

from __future__ import annotations

import shutil
import sqlite3
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tatamu.api import learn
from tatamu.base.errors import InputError, TatamuError
from tatamu.base.files import check_targets, read_toml
from tatamu.calibration import load_measurements
from tatamu.folding.plan import load_plan
from tatamu.folding.task import make_task
from tatamu.garments import load_garment, make_garment
from tatamu.garments.meshfile import read_mesh
from tatamu.simulation.material import Material
from tatamu.study.options import LearnOptions
from tatamu.study.result import Result
from tests.foreign import svg
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
    with pytest.raises(InputError, match=r"must not contain report\.html without a study"):
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
    with pytest.raises(InputError, match="another program is using the file") as caught:
        learn(make_task("towel", spacing=0.04), LearnOptions(trials=1), out=tmp_path)
    assert "remove it" not in str(caught.value) and "CREATE" not in str(caught.value)


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


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ("[loop]\nheight = 2.5", "that the height is in metres"),
        ("[sag]\nedge = 'bottom'\nfree_length = 34\nsag = 0.02", "write 0.034; in centimetres, 0.34"),
        ("[friction]\nL_t = 0.6\nH_s = 100000000000000000000", "at most 10"),
        ("[loop]\nheight = 0.03\n[errors]\nlength = 1e-300", "greater than or equal to 0.000001"),
    ],
)
def test_readings_that_cannot_be(tmp_path: Path, table: str, said: str) -> None:
    (tmp_path / "m.toml").write_text(f"[garment]\nname = 'towel'\nmass = 0.1\n{table}\n")
    with pytest.raises(InputError, match=said):
        load_measurements(tmp_path / "m.toml")


def test_a_mark_in_front_of_a_file_is_no_matter(tmp_path: Path) -> None:
    (tmp_path / "m.toml").write_bytes(b"\xef\xbb\xbf" + EXAMPLE.read_bytes())
    assert read_toml(tmp_path / "m.toml") == read_toml(EXAMPLE)


def test_one_mistake_is_counted_once(tmp_path: Path) -> None:
    (tmp_path / "p.toml").write_text('[[step]]\nline = [[0.0, -0.5], [0.0, 0.5]]\nmoves = "-x"\nfoo = 1\n')
    with pytest.raises(InputError, match="foo") as caught:
        load_plan(tmp_path / "p.toml")
    assert "more)" not in str(caught.value)


def test_grips_that_hold_the_same_cloth_are_refused() -> None:
    from tatamu.calibration.elongation import Elongation, Grasp

    grasps = [Grasp(edge="bottom"), Grasp(edge="bottom", at=0.2, width=0.05)]
    with pytest.raises(InputError, match="hold different parts"):
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
