"""The command line: one clear line and exit code 2 for what is wrong, nothing half-written."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from tatamu import Rollout
from tatamu.cli import main
from tests.commands import refused, tatamu
from tests.scenes import scene


def test_simulate_writes_a_rollout(tmp_path: Path) -> None:
    scene(duration=0.1).save(tmp_path / "scene.json")
    done = tatamu("simulate", str(tmp_path / "scene.json"), "--out", str(tmp_path / "out" / "r.npz"))
    assert done.returncode == 0, done.stderr
    rollout = Rollout.load(tmp_path / "out" / "r.npz")
    assert rollout.positions.shape[0] == len(rollout.times) == 7
    assert rollout.times[-1] == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["simulate", "none.json", "--out", "r.npz"], "none.json: cannot be read"),
        (["simulate", "none.json"], "out"),
        (["simulate", "SCENE", "--out", "r.npz", "--simulator", "magic"], "simulator: must be one of native"),
        (["simulate", "SCENE", "--out", "/proc/nowhere/r.npz"], "cannot be written"),
        (["simulate", "SCENE", "--out", "SCENE/r.npz"], "cannot be written"),
        (["simulate", "SCENE", "--out", "/"], "/: must be the name of a file"),
        (["simulate", "SCENE", "--out", f"{'x' * 300}.npz"], "cannot be written"),
        (["learn", "towel", "--out", "x" * 300], "cannot be written"),
        (["learn", "sock", "--out", "DIR"], "garment: must be one of towel"),
        (["learn", "towel"], "out"),
        (["learn", "towel", "--out", "DIR", "--size", "0x0.8"], "size: must have two sides longer than 0 m"),
        (["learn", "towel", "--out", "DIR", "--size", "big"], "size: must be WIDTHxLENGTH"),
        (["learn", "towel", "--out", "DIR", "--size", "nanx0.8"], "size: must have two sides longer than 0 m"),
        (["learn", "towel", "--out", "DIR", "--spacing", "-1"], "spacing"),
        (["learn", "towel", "--out", "DIR", "--spacing", "nan"], "spacing"),
        (["learn", "towel", "--out", "DIR", "--trials", "many"], "trials"),
        (["learn", "towel", "--out", "DIR", "--trials", "0"], "trials: must be from 1"),
        (["learn", "towel", "--out", "DIR", "--fold", "swan"], "fold: must be one of half"),
        (["learn", "towel", "--out", "DIR", "--fold", "none.toml"], "none.toml: cannot be read"),
        (["learn", "towel", "--out", "DIR", "--hands", "3"], "hands: must be 1 or 2"),
        (["learn", "towel", "--out", "DIR", "--grasps", "teeth"], "grasps: must be integer or continuous"),
        (["learn", "towel", "--out", "DIR", "--sampler", "x"], "sampler: must be one of"),
        (["learn", "towel", "--out", "DIR", "--simulator", "x"], "simulator: must be one of"),
        (["learn", "towel", "--out", "DIR", "--material", "none.toml"], "none.toml: cannot be read"),
        (["margins", "nowhere"], "nowhere"),
        (["margins", "DIR", "--iou", "2"], "--iou: must be from 0 to 1"),
        (["margins", "DIR", "--distance", "-1"], "--distance: must be above 0"),
        (["margins", "DIR", "--disturbances", "none"], "disturbances: must be default or a .toml file"),
        (["margins", "DIR", "--disturbances", "none.toml"], "none.toml: cannot be read"),
        (["fly"], "fly"),
    ],
)
def test_what_is_wrong_gets_one_line_and_code_2(tmp_path: Path, arguments: list[str], named: str) -> None:
    scene(duration=0.1).save(tmp_path / "scene.json")
    places = {"SCENE": str(tmp_path / "scene.json"), "DIR": str(tmp_path / "out")}
    given = (re.sub("SCENE|DIR", lambda found: places[found[0]], argument) for argument in arguments)
    assert named in refused(*given)
    assert {path.name for path in tmp_path.iterdir()} == {"scene.json"}


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("", "material: must be a table [material]"),
        ("[material]\nareal_density = -1\n", "areal_density"),
        ("[material\n", "not valid TOML"),
    ],
)
def test_a_wrong_material_file_is_named(tmp_path: Path, text: str, named: str) -> None:
    (tmp_path / "m.toml").write_text(text)
    said = refused("learn", "towel", "--out", str(tmp_path / "out"), "--material", str(tmp_path / "m.toml"))
    assert named in said and "m.toml" in said


def test_help_shows_examples() -> None:
    command = [sys.executable, "-m", "tatamu", "learn", "--help"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "tatamu learn towel --out runs/towel" in done.stdout


def test_importing_tatamu_is_quick_and_light() -> None:
    code = (
        "import sys, tatamu; heavy = {'numba', 'torch', 'optuna', 'scipy', 'plotly'} & set(sys.modules); print(heavy)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"


def test_an_interrupted_command_says_that_what_was_finished_is_kept(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("tatamu.simulation.material.load_material", interrupted)
    monkeypatch.setattr("sys.argv", ["tatamu", "show", "towel", "--material", "denim"])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 130
    assert "finished work is kept" in capsys.readouterr().err


@pytest.mark.parametrize("threads", ["0", "-1", "many", ""])
def test_a_wrong_number_of_threads_is_one_line(threads: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_NUM_THREADS", threads)
    done = tatamu("garments")
    assert (done.returncode, done.stderr) == (
        2,
        f"tatamu: NUMBA_NUM_THREADS: must be a whole number of 1 or more, given {threads!r}\n",
    )


@pytest.mark.parametrize("arguments", [("replay", "no-such-folder", "0"), ("learn", "towl", "--out", "x")])
def test_arguments_are_checked_before_anything_is_compiled(
    arguments: tuple[str, ...], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("tatamu.cli.progress.prepare", lambda *_: pytest.fail("the simulator was prepared"))
    refused(*arguments, cwd=tmp_path)
