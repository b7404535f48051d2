"""Studies in a shared database: nothing lost, nothing twice, no password anywhere."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from threading import Thread

import pytest
from optuna.trial import create_trial

from tatamu import LearnOptions, learn
from tatamu.base.errors import InputError, UnavailableError
from tatamu.study.database import SharedDatabase, parse_storage, shared_database
from tests import postgres
from tests.small_studies import learn_plain, timeless, towel

ADDRESS = "postgresql://folder@db.example/studies"
SECRET = "geheim-und-lang"


@pytest.fixture(scope="module")
def server() -> Iterator[postgres.Server]:
    if postgres.installed() is None:
        pytest.skip("PostgreSQL is not installed")
    with postgres.running() as found:
        yield found


@pytest.fixture
def database(server: postgres.Server, monkeypatch: pytest.MonkeyPatch) -> Iterator[SharedDatabase]:
    monkeypatch.setenv("PGPASSWORD", postgres.PASSWORD)
    with shared_database(server.address) as found:
        assert found is not None
        yield found


@pytest.mark.parametrize(
    "given",
    [
        f"postgresql://folder:{SECRET}@host/studies",
        f"postgresql://folder@host/studies?password={SECRET}",
        f"postgresql://folder@host/studies?sslpassword={SECRET}",
        f"postgresql://folder:{SECRET}@host:port/studies",
        f"postgresql://folder:{SECRET}@/[",
        f"mysql://folder:{SECRET}@host/studies",
    ],
)
def test_a_password_in_the_address_is_refused_and_not_repeated(given: str) -> None:
    with pytest.raises(InputError, match="--storage") as refused:
        parse_storage(given)
    assert SECRET not in str(refused.value) and "geheim" not in repr(refused.getrepr())


@pytest.mark.parametrize(
    "given", ["studies", "sqlite:///studies.db", "postgresql://folder@host", "postgresql+psycopg2://a@h/d"]
)
def test_what_is_no_address_is_refused(given: str) -> None:
    with pytest.raises(InputError, match="postgresql://USER@HOST/DB"):
        parse_storage(given)


def test_an_address_is_read() -> None:
    assert parse_storage(ADDRESS) == ADDRESS
    assert parse_storage(ADDRESS + "?sslmode=require") == ADDRESS + "?sslmode=require"


def test_a_database_that_is_not_there_is_said_in_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tatamu.study.database.OPENING_SECONDS", 0.5)
    with pytest.raises(UnavailableError, match=r"127\.0\.0\.1:9/studies: has not answered for 0\.5 s"):
        with shared_database("postgresql://folder@127.0.0.1:9/studies"):
            pass


def test_a_database_that_refuses_is_said_at_once(server: postgres.Server, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PGPASSWORD", SECRET)
    with pytest.raises(InputError, match=r"refused .*password authentication failed") as refused:
        with shared_database(server.address):
            pass
    assert SECRET not in str(refused.value) and "\n" not in str(refused.value)


def test_a_study_in_the_database_is_that_of_a_file(database: SharedDatabase, tmp_path: Path) -> None:
    task = towel()
    learn_plain(task, tmp_path / "file", trials=4)
    learn_plain(task, tmp_path / "shared", trials=2, database=database)
    learn_plain(task, tmp_path / "shared", trials=4, database=database)
    assert timeless(tmp_path / "file") == timeless(tmp_path / "shared")
    assert not (tmp_path / "shared" / "study.db").exists()
    kept = json.loads((tmp_path / "shared" / "study.json").read_text())
    assert kept["storage"] == database.address


def test_names_are_apart_for_folders_and_tasks(database: SharedDatabase, tmp_path: Path) -> None:
    task = towel()
    names = set()
    for folder, seed in (("a", 0), ("b", 0), ("c", 1)):
        learn_plain(task, tmp_path / folder, trials=1, seed=seed, baselines=False, database=database)
        names.add(json.loads((tmp_path / folder / "study.json").read_text())["name"])
    assert len(names) == 3
    with pytest.raises(InputError, match="contains a study with other options"):
        learn_plain(task, tmp_path / "a", trials=1, seed=1, baselines=False, database=database)


def test_a_folder_has_its_study_in_one_place(database: SharedDatabase, tmp_path: Path) -> None:
    task = towel()
    learn_plain(task, tmp_path / "shared", trials=1, baselines=False, database=database)
    with pytest.raises(InputError, match="give --storage"):
        learn_plain(task, tmp_path / "shared", trials=1, baselines=False)
    learn_plain(task, tmp_path / "file", trials=1, baselines=False)
    with pytest.raises(InputError, match="leave --storage out"):
        learn_plain(task, tmp_path / "file", trials=1, baselines=False, database=database)


def test_a_study_is_held_by_one_client(
    database: SharedDatabase, server: postgres.Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tatamu.study.database.HOLD_SECONDS", 0.5)
    database.hold("one")
    with shared_database(server.address) as other:
        assert other is not None
        with pytest.raises(UnavailableError, match="another client is learning one"):
            other.hold("one")
        database.release("one")
        other.hold("one")


@pytest.mark.parametrize("mode", ["fast", "immediate"])
def test_a_database_that_restarts_loses_and_doubles_nothing(
    database: SharedDatabase, server: postgres.Server, mode: str
) -> None:
    import optuna

    study = optuna.create_study(storage=database.storage, study_name=f"restarted-{mode}")
    database.hold(study.study_name)
    restart = Thread(target=server.control, args=("restart", "-m", mode))
    for number in range(40):
        if number == 10:
            restart.start()

        def add(number: int = number) -> bool:
            study.add_trial(create_trial(value=float(number)))
            return True

        def is_added(number: int = number) -> bool:
            return len(study.get_trials(deepcopy=False)) > number

        database.run(add, is_added)
        time.sleep(0.03)
    restart.join()
    assert [trial.value for trial in study.get_trials()] == list(range(40))
    assert server.query("SELECT count(*) FROM pg_locks WHERE locktype = 'advisory'") == "1", "it is held again"


def test_a_trial_whose_answer_was_lost_is_not_added_again(
    database: SharedDatabase, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import optuna

    from tatamu.study.database import ConnectionLostError

    add = optuna.Study.add_trial
    lost = iter([True])

    def add_and_lose(self: optuna.Study, trial: optuna.trial.FrozenTrial) -> None:
        add(self, trial)
        if next(lost, False):
            raise ConnectionLostError("server closed the connection unexpectedly")

    monkeypatch.setattr(optuna.Study, "add_trial", add_and_lose)
    learn_plain(towel(), tmp_path, trials=2, baselines=False, database=database)
    monkeypatch.undo()
    name = json.loads((tmp_path / "study.json").read_text())["name"]
    assert len(optuna.load_study(study_name=name, storage=database.storage).trials) == 2


def test_a_database_that_stays_away_ends_the_run_and_keeps_what_was_finished(
    database: SharedDatabase, server: postgres.Server, tmp_path: Path
) -> None:
    task = towel()
    database.retry_seconds = 0.5
    server.control("stop", "-m", "fast")
    try:
        with pytest.raises(UnavailableError, match=r"has not answered for 0\.5 s .*finished trials are kept"):
            learn_plain(task, tmp_path, trials=2, baselines=False, database=database)
    finally:
        server.control("start")
    learn_plain(task, tmp_path, trials=2, baselines=False, database=database)


def test_the_password_is_in_no_output_file_or_argument(server: postgres.Server, tmp_path: Path) -> None:
    arguments = ["towel", "--size", "0.24x0.5", "--spacing", "0.04", "--trials", "2", "--storage", server.address]
    arguments += ["--disturbances", "none"]
    command = [
        sys.executable,
        "-c",
        "from tatamu.cli import main; main()",
        "learn",
        *arguments,
        "--out",
        str(tmp_path / "a"),
    ]
    environment = {**os.environ, "PGPASSWORD": postgres.PASSWORD}
    process = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    listed = Path(f"/proc/{process.pid}/cmdline")
    assert not listed.exists() or postgres.PASSWORD.encode() not in listed.read_bytes()
    output, _ = process.communicate()
    assert process.returncode == 0, output
    assert postgres.PASSWORD not in output
    for file in (tmp_path / "a").iterdir():
        assert postgres.PASSWORD.encode() not in file.read_bytes(), file.name


def test_a_shared_study_is_resumed_with_its_own_settings(database: SharedDatabase, tmp_path: Path) -> None:
    """Whether anything is disturbed is read from the database that holds it."""

    learn_plain(towel(), tmp_path, trials=1, baselines=False, database=database)
    learn(towel(), LearnOptions(trials=2, baselines=False), out=tmp_path, database=database)
    result = json.loads((tmp_path / "result.json").read_text())
    assert len(result["trials"]) == 2
    assert result.get("disturbances") is None
