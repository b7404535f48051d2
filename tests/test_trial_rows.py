"""Trials are written as Optuna would write them, and outlive whoever writes them."""

from __future__ import annotations

import os
import signal
import sqlite3
import subprocess
import sys
from contextlib import closing
from datetime import datetime
from pathlib import Path

import optuna
import pytest
from optuna.distributions import FloatDistribution, IntDistribution
from optuna.storages import RDBStorage
from optuna.trial import FrozenTrial, TrialState, create_trial
from tatamu.learning.place import FilePlace
from tatamu.learning.trial_rows import write_trial

KILLED = """
import os, signal, sys
from pathlib import Path
import optuna
from tatamu.learning.place import FilePlace
from tatamu.learning.trial_rows import write_trial
place = FilePlace(Path(sys.argv[1]))
study = optuna.create_study(storage=place.storage, study_name=place.name)
place.expect_writes()
for number in range(5):
    trial = optuna.trial.create_trial(value=float(number), user_attrs={"state": "complete"})
    trial.number = number
    write_trial(place.storage, place.storage.get_study_id_from_name(place.name), trial)
os.kill(os.getpid(), signal.SIGKILL)
"""


def finished(number: int, value: float) -> FrozenTrial:
    """A trial with something in each table."""
    trial = create_trial(
        state=TrialState.COMPLETE,
        value=value,
        params={"x": 0.25 + 0.1 * number, "g": number},
        distributions={"x": FloatDistribution(0.0, 1.0), "g": IntDistribution(0, 4)},
        user_attrs={"state": "complete", "error": None, "seconds": 0.1},
        system_attrs={"packed": "abc"},
    )
    trial.number = number
    trial.datetime_start = trial.datetime_complete = datetime(2026, 1, 2, 3, 4, 5)
    return trial


def storage_at(path: Path) -> RDBStorage:
    storage = RDBStorage(f"sqlite:///{path}")
    optuna.create_study(storage=storage, study_name="tatamu")
    return storage


def rows(path: Path) -> dict[str, list[tuple[object, ...]]]:
    """All that a database holds, by table."""
    with closing(sqlite3.connect(path)) as database:
        names = [name for (name,) in database.execute("select name from sqlite_master where type = 'table'")]
        return {name: sorted(database.execute(f"select * from {name}").fetchall(), key=str) for name in names}


@pytest.mark.parametrize("value", [0.5, float("inf")])
def test_the_rows_are_those_that_optuna_writes(tmp_path: Path, value: float) -> None:
    ours = storage_at(tmp_path / "ours.db")
    theirs = storage_at(tmp_path / "theirs.db")
    study = optuna.load_study(study_name="tatamu", storage=theirs)
    for number in range(2):
        write_trial(ours, ours.get_study_id_from_name("tatamu"), finished(number, value))
        study.add_trial(finished(number, value))
    assert rows(tmp_path / "ours.db") == rows(tmp_path / "theirs.db")
    assert len(rows(tmp_path / "ours.db")["trial_user_attributes"]) == 6


def test_what_a_killed_process_wrote_is_there(tmp_path: Path) -> None:
    file = tmp_path / "study.db"
    ended = subprocess.run([sys.executable, "-c", KILLED, str(file)], env=dict(os.environ))
    assert ended.returncode == -signal.SIGKILL
    assert (tmp_path / "study.db-wal").exists(), "it was killed before the log was put into the file"
    assert len(optuna.load_study(study_name="tatamu", storage=f"sqlite:///{file}").trials) == 5


def test_a_place_that_is_closed_leaves_one_file_without_a_log(tmp_path: Path) -> None:
    place = FilePlace(tmp_path / "study.db")
    optuna.create_study(storage=place.storage, study_name=place.name)
    place.expect_writes()
    write_trial(place.storage, place.storage.get_study_id_from_name(place.name), finished(0, 0.5))
    assert (tmp_path / "study.db-wal").exists()
    place.close()
    assert [path.name for path in tmp_path.iterdir()] == ["study.db"]
    with closing(sqlite3.connect(f"file:{tmp_path / 'study.db'}?mode=ro&immutable=1", uri=True)) as database:
        assert database.execute("pragma journal_mode").fetchone() == ("delete",)
        assert database.execute("select count(*) from trials").fetchone() == (1,)


def test_a_file_that_is_only_read_stays_as_it_is(tmp_path: Path) -> None:
    storage_at(tmp_path / "study.db").engine.dispose()
    before = (tmp_path / "study.db").read_bytes()
    place = FilePlace(tmp_path / "study.db")
    assert optuna.load_study(study_name=place.name, storage=place.storage).trials == []
    place.close()
    assert (tmp_path / "study.db").read_bytes() == before
