"""The store of a study: nothing half done after a kill, one line about whatever is not a study of tatamu."""

from __future__ import annotations

import os
import re
import shutil
import signal
import sqlite3
import subprocess
import sys
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import optuna
import pytest

from tatamu import Result
from tatamu.study.folder import ResultFolder
from tatamu.study.record import StudyRecord, describe_task
from tatamu.study.store import file_store, load_settings
from tatamu.study.trial import Trial
from tests.refusals import refusal
from tests.small_studies import X, learn_plain, timeless, towel

RECORD = StudyRecord(task=describe_task(towel()), sampler="random", seed=0)

KILLED = """
import os, signal, sys
from pathlib import Path
from tatamu.study.folder import ResultFolder
from tatamu.study.store import file_store
from tests.small_studies import towel
from tests.test_study_store import RECORD, finished
with file_store(ResultFolder(Path(sys.argv[1]))) as store:
    store.open(RECORD)
    for number in range(5):
        store.add(finished(number), towel().space)
    os.kill(os.getpid(), signal.SIGKILL)
"""


def finished(number: int) -> Trial:
    """A failed trial, with something in each table."""
    return Trial(
        number=number,
        state="failed",
        error="blew up",
        parameters={**X, "g1": number % 2},
        objective=1.0 + number,
        trajectory_length=0.5,
        seconds=0.1,
    )


def test_what_a_killed_process_wrote_is_there(tmp_path: Path) -> None:
    root = Path(__file__).parent.parent
    ended = subprocess.run([sys.executable, "-c", KILLED, str(tmp_path)], env=dict(os.environ), cwd=root)
    assert ended.returncode == -signal.SIGKILL
    with file_store(ResultFolder(tmp_path)) as store:
        assert store.open(RECORD) == [finished(number) for number in range(5)]


def test_a_store_that_is_closed_leaves_one_file_without_a_log(tmp_path: Path) -> None:
    with file_store(ResultFolder(tmp_path)) as store:
        assert store.open(RECORD) == []
        store.add(finished(0), towel().space)
    assert [path.name for path in tmp_path.iterdir()] == ["study.db"]
    with closing(sqlite3.connect(f"file:{tmp_path / 'study.db'}?mode=ro&immutable=1", uri=True)) as database:
        assert database.execute("pragma journal_mode").fetchone() == ("delete",)
        assert database.execute("select count(*) from trials").fetchone() == (1,)


def test_a_file_that_is_only_read_stays_as_it_is(tmp_path: Path) -> None:
    folder = ResultFolder(tmp_path)
    with file_store(folder) as store:
        store.open(RECORD)
    before = (tmp_path / "study.db").read_bytes()
    assert load_settings(folder, None) == RECORD
    assert (tmp_path / "study.db").read_bytes() == before


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a study of two trials."""
    folder = tmp_path_factory.mktemp("study")
    learn(folder, 2)
    return folder


def learn(folder: Path, trials: int) -> Result:
    return learn_plain(towel(), folder, trials=trials, sampler="random", baselines=False)


def opened(folder: Path) -> optuna.Study:
    return optuna.load_study(study_name=None, storage=f"sqlite:///{folder / 'study.db'}")


def enqueue(folder: Path) -> None:
    opened(folder).enqueue_trial(X)


def ask(folder: Path) -> None:
    opened(folder).ask()


@pytest.mark.parametrize(("leave", "state"), [(enqueue, "WAITING"), (ask, "RUNNING")])
def test_a_trial_that_optuna_left_is_said_in_one_line(
    study: Path, tmp_path: Path, leave: Callable[[Path], None], state: str
) -> None:
    folder = tmp_path / "study"
    shutil.copytree(study, folder)
    leave(folder)
    before = (folder / "study.db").read_bytes()
    for trials in (3, 5):
        assert re.search(
            rf"study\.db: trial 2: .*{state}.*delete this trial with Optuna", refusal(learn, folder, trials)
        )
    assert (folder / "study.db").read_bytes() == before


CHANGES = {
    "another schema": "update alembic_version set version_num = 'v2.6.0.a'",
    "no study": "delete from studies",
    "settings that are no JSON": "update study_user_attributes set value_json = '{' where key = 'tatamu'",
    "settings without a task": "update study_user_attributes set value_json = '{\"seed\": 0}' where key = 'tatamu'",
    "settings of another seed": "update study_user_attributes set value_json = "
    "replace(value_json, '\"seed\": 0', '\"seed\": \"x\"') where key = 'tatamu'",
    "no settings": "delete from study_user_attributes",
    "a state that is none": "update trials set state = 'DONE' where number = 1",
    "a number twice": "update trials set number = 0",
    "a lost trial": "delete from trials where number = 0",
    "a value that is no number": "update trial_values set value = 'low' where trial_id = 2",
    "no value": "delete from trial_values where trial_id = 2",
    "a parameter far out": "update trial_params set param_value = 7.5 where param_name = 'z1' and trial_id = 2",
    "a missing parameter": "delete from trial_params where param_name = 'z1' and trial_id = 2",
    "a distribution of another kind": "update trial_params set distribution_json = "
    "replace(distribution_json, 'FloatDistribution', 'Normal')",
    "a state of another kind": "update trial_user_attributes set value_json = '7' where key = 'state'",
    "a measure that is missing": "delete from trial_user_attributes where key = 'mask_iou' and trial_id = 2",
    "no attributes": "delete from trial_user_attributes where trial_id = 2",
    "no table of trials": "drop table trials",
}


HARMLESS = {
    "nothing": "update trials set number = number",
    "a schema that is not said": "delete from alembic_version",
    "another library": "update version_info set library_version = '3.0.0'",
    "a study of another name, beside which a new one starts": "update studies set study_name = 'mine'",
}


def changed(study: Path, folder: Path, statement: str) -> Path:
    """A copy of a study in which a statement of SQL has changed something."""
    shutil.copy(study / "study.db", folder)
    with closing(sqlite3.connect(folder / "study.db")) as database:
        database.execute(statement)
        database.commit()
    return folder


@pytest.mark.parametrize("change", CHANGES)
def test_a_changed_study_is_said_in_one_line(study: Path, tmp_path: Path, change: str) -> None:
    folder = changed(study, tmp_path, CHANGES[change])
    said = refusal(learn, folder, 2)
    assert "study.db: " in said and len(said) < 500


@pytest.mark.parametrize("change", HARMLESS)
def test_a_change_that_takes_nothing_away_leads_to_the_same_study(study: Path, tmp_path: Path, change: str) -> None:
    folder = changed(study, tmp_path, HARMLESS[change])
    learn(folder, 2)
    assert timeless(folder) == timeless(study)
