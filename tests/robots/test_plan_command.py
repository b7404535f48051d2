"""`tatamu plan`: which robot it takes, and what it proposes where no placement is found."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest

from tatamu.robots import load
from tatamu.robots.catalog import described
from tatamu.robots.plan import NoPlacement
from tatamu.study.inputs import Sources, keep_inputs
from tests.commands import tatamu
from tests.fabricated import changed, write_fold
from tests.robots.arms import pair


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of the robots that were planned for; no placement is ever found."""
    names: list[str] = []

    def refused(folder: Path, robot: Any, *_: object) -> None:
        names.append(robot.name)
        raise NoPlacement(f"{folder}: no placement")

    monkeypatch.setattr("tatamu.robots.plan_fold", refused)
    return names


def said(*arguments: str) -> str:
    done = tatamu("plan", *arguments)
    assert done.returncode == 2
    return done.stderr


def test_where_there_is_no_placement_learning_within_reach_is_proposed(
    folder: Path, tmp_path: Path, asked: list[str]
) -> None:
    where = [str(folder), "--out", str(tmp_path / "plan")]
    remedy = "`tatamu learn .. --robot {}` tries only folds that this robot can reach"
    assert remedy.format("hironx") in said(*where)
    assert remedy.format("nextage") in said(*where, "--robot", "nextage")
    changed(folder / "result.json", lambda value: value["task"].update(robot="nextage"))
    assert "tatamu learn" not in said(*where)  # it was done already
    assert asked == ["hironx", "nextage", "nextage"]


def test_a_robot_of_ones_own_goes_with_the_fold(tmp_path: Path, asked: list[str]) -> None:
    (tmp_path / "own").mkdir()
    description = pair(tmp_path / "own")
    files = load(str(description)).files
    assert {file.name for file in files} == {"pair.toml", "arm.urdf", "arm.xml"}
    folder = write_fold(tmp_path / "towel", spacing=0.08, frames=24)
    changed(folder / "result.json", lambda value: value["task"].update(robot="pair"))
    keep_inputs(folder, {"robot": Sources(files)})
    shutil.rmtree(tmp_path / "own")
    assert described(folder / "inputs" / "robot" / "pair.toml").name == "pair"
    said(str(folder), "--out", str(tmp_path / "plan"))
    assert asked == ["pair"]


def test_several_robots_say_who_can(folder: Path, tmp_path: Path, asked: list[str]) -> None:
    (tmp_path / "a, b").mkdir()
    own = pair(tmp_path / "a, b")
    error = said(str(folder), "--out", str(tmp_path / "plans"), "--robot", "hironx, openarm,hironx")
    assert asked == ["hironx", "openarm"] and "no placement" in error
    said(str(folder), "--out", str(tmp_path / "plans"), "--robot", str(own))
    assert asked[2:] == ["pair"], "a comma in the name of a file is no list"
    assert "--lerobot: must be given with a single robot" in said(
        str(folder), "--out", "p", "--robot", "hironx,openarm", "--lerobot", str(tmp_path / "d")
    )
    assert not (tmp_path / "plans").exists()
