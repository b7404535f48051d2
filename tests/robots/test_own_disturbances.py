"""A robot's description may say how far off the robot's hands are; `tatamu learn --robot` takes that."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from tatamu.api import learn, task_of
from tatamu.base.errors import InputError
from tatamu.evaluation.disturbances import Disturbances, default_disturbances
from tatamu.robots import load
from tatamu.study.folder import ResultFolder
from tatamu.study.inputs import Sources, keep_inputs
from tatamu.study.options import FoldOptions, LearnOptions
from tatamu.study.record import StudyRecord
from tatamu.study.store import load_settings
from tests.commands import refused
from tests.refusals import refusal
from tests.robots.arms import pair

FILE = "[source]\nhands = 'measured'\n[hands]\nyaw = 0.02\n[fingers]\nthickness = 0.004\n"
TABLE = "[disturbances.hands]\nyaw = 0.02\n[disturbances.fingers]\nthickness = 0.004\n"
OWN = Disturbances.model_validate({"hands": {"yaw": 0.02}, "fingers": {"thickness": 0.004}})


def with_file(folder: Path, text: str = FILE) -> Path:
    """A pair whose disturbances are in a file in a folder beside the description."""
    path = pair(folder)
    path.write_text('disturbances = "known/hands.toml"\n' + path.read_text())
    (folder / "known").mkdir()
    (folder / "known" / "hands.toml").write_text(text)
    return path


def with_table(folder: Path, text: str = TABLE) -> Path:
    path = pair(folder)
    path.write_text(path.read_text() + text)
    return path


def settings(tmp_path: Path, robot: str, disturbances: str | None = None) -> StudyRecord:
    """The settings of a study of a towel for a robot, as it starts."""
    options = LearnOptions(trials=1, disturbances=disturbances)
    task = task_of(FoldOptions(garment="towel", size="0.24x0.50", spacing=0.04, robot=robot))
    folder = ResultFolder(tmp_path / f"learned-{disturbances}")

    def stop(now: object) -> None:
        raise KeyError

    with pytest.raises(KeyError):
        learn(task, options, out=folder.path, progress=stop)
    record = load_settings(folder, None)
    assert record is not None
    return record


@pytest.mark.parametrize("make", [with_file, with_table])
def test_learning_for_a_robot_takes_its_disturbances(tmp_path: Path, make: Callable[..., Path]) -> None:
    robot = str(make(tmp_path))
    load(robot)
    own, given, none = (settings(tmp_path, robot, name) for name in (None, "default", "none"))
    assert own.disturbances == OWN.describe() and own.task.fingers == OWN.fingers
    assert given.disturbances == default_disturbances().describe()
    assert none.disturbances is None


def test_the_task_has_the_file(tmp_path: Path) -> None:
    task = task_of(FoldOptions(garment="towel", size="0.24x0.50", spacing=0.04, robot=str(with_file(tmp_path))))
    assert task.reach is not None and tmp_path / "known" / "hands.toml" in task.reach.files


def test_a_robot_without_its_own_takes_the_default_ones(tmp_path: Path) -> None:
    assert settings(tmp_path, str(pair(tmp_path))).disturbances == default_disturbances().describe()


def test_the_file_goes_with_the_fold(tmp_path: Path) -> None:
    (tmp_path / "own").mkdir()
    keep_inputs(tmp_path, {"robot": Sources(load(str(with_file(tmp_path / "own"))).files)})
    shutil.rmtree(tmp_path / "own")
    kept = tmp_path / "inputs" / "robot" / "pair.toml"
    assert load(str(kept)).disturbances == OWN
    load(str(kept))


WRONG = [
    (with_table, "[disturbances.hands]\nyaw = -0.1\n", "pair.toml: disturbances: hands.yaw"),
    (with_table, "[disturbances]\nhand = 1\n", "pair.toml: disturbances: hand"),
    (with_file, "[hands]\nyaw = -0.1\n", "hands.toml: hands.yaw"),
]


@pytest.mark.parametrize(("make", "text", "named"), WRONG)
def test_a_wrong_field_is_one_line_and_nothing_is_written(
    make: Callable[..., Path],
    text: str,
    named: str,
    tmp_path: Path,
) -> None:
    robot = str(make(tmp_path, text))
    assert named in refused("learn", "towel", "--robot", robot, "--out", str(tmp_path / "out"))
    assert not (tmp_path / "out").exists()
    with pytest.raises(InputError, match="hand"):
        load(robot)  # other commands refuse it too


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ('disturbances = "gone.toml"', "gone.toml: cannot be read"),
        ("disturbances = 3", "disturbances: must be a table or the name of a .toml file"),
        ('disturbances = "default"', "disturbances: must be a table or the name of a .toml file"),
    ],
)
def test_what_is_no_file_and_no_table_is_refused(tmp_path: Path, line: str, said: str) -> None:
    path = pair(tmp_path)
    path.write_text(f"{line}\n" + path.read_text())
    assert re.search(said, refusal(load, str(path)))
