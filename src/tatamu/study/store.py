"""Stores the trials of a study in a file, in a shared database, or in memory, with Optuna.

Only finished trials are written, each in one transaction, so that a run that is killed leaves none half-written. Only
Optuna's public interface is used, and `optuna-dashboard` can open the file and the database.
"""

from __future__ import annotations

import json
import os
import re
import sqlite3
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, closing, contextmanager
from functools import cached_property, partial
from hashlib import sha256
from typing import Any

import optuna
from optuna.storages import BaseStorage, InMemoryStorage, RDBStorage
from optuna.trial import TrialState, create_trial
from pydantic import ValidationError

from tatamu.base.errors import InputError, UnavailableError, describe
from tatamu.base.files import write_json
from tatamu.search import Space
from tatamu.search.optuna_search import distributions
from tatamu.study.database import SharedDatabase
from tatamu.study.folder import ResultFolder
from tatamu.study.record import StudyRecord
from tatamu.study.trial import Baseline, Trial

KEY = "tatamu"
"""Attribute of the Optuna study that has the `StudyRecord`, and name of the only study in a file."""
BASELINES_KEY = "baselines"


class StudyStore:
    """Storage of the trials of one study, in memory."""

    label = "study"
    """Name in messages."""
    name = KEY
    """Name of the study in the storage."""
    _study: optuna.Study

    @cached_property
    def storage(self) -> BaseStorage:
        """Optuna's storage, which is opened at its first use."""
        return InMemoryStorage()

    def run(self, operation: Callable[[], Any], done: Callable[[], bool] | None = None) -> Any:
        """Run an operation on the storage, and convert its errors to those of tatamu.

        `done` returns whether an operation that writes was completed, although its answer was lost.
        """
        return operation()

    def load(self) -> StudyRecord | None:
        """Return the settings of the study; None if the storage contains no study of tatamu."""
        held = self.run(self._held)
        try:
            return None if held is None else StudyRecord.model_validate(held)
        except ValidationError as error:
            raise InputError(f"{self.label}: {describe(error, StudyRecord)}; give another folder") from None

    def _held(self) -> Any:
        if self.name not in optuna.get_all_study_names(self.storage):
            return None
        return optuna.load_study(study_name=self.name, storage=self.storage).user_attrs.get(KEY)

    def open(self, record: StudyRecord) -> list[Trial]:
        """Open the study, or start it, and return its trials.

        Raises:
            InputError: If the storage is no readable study, or one with other settings.
        """
        wanted = json.loads(record.model_dump_json())
        held, trials = self.run(self._open)
        if held is None and trials:
            raise InputError(f"{self.label}: contains a study that tatamu did not make; give another folder")
        if held is None:
            self.run(lambda: self._study.set_user_attr(KEY, wanted))
        elif held != wanted:
            difference = _difference(held, wanted)
            raise InputError(
                f"{self.label}: contains a study with other options ({difference}); give the same options, or another "
                "folder"
            )
        return [self._read(number, trial) for number, trial in enumerate(trials)]

    def _open(self) -> tuple[Any, list[optuna.trial.FrozenTrial]]:
        """Return the settings and the trials of the study, which is made if it is not there."""
        self._study = optuna.create_study(
            storage=self.storage, study_name=self.name, direction="minimize", load_if_exists=True
        )
        return self._study.user_attrs.get(KEY), self._study.get_trials(deepcopy=False)

    def _read(self, number: int, trial: optuna.trial.FrozenTrial) -> Trial:
        """Return a finished trial that tatamu wrote."""
        if trial.state != TrialState.COMPLETE or trial.number != number:
            raise InputError(
                f"{self.label}: trial {trial.number}: must be a finished trial, given state {trial.state.name}; delete "
                "this trial with Optuna, or give another folder"
            )
        known = {"number": number, "parameters": trial.params, "objective": trial.value, **trial.user_attrs}
        try:
            read = Trial.model_validate(known)
        except ValidationError as error:
            raise InputError(f"{self.label}: trial {number}: {describe(error, Trial)}; give another folder") from None
        if read.number != number:
            raise InputError(
                f"{self.label}: trials: must be numbered 0, 1, 2, .., given {read.number} instead of {number}; "
                "give another folder"
            )
        return read

    def add(self, trial: Trial, space: Space) -> None:
        """Add a finished trial in one transaction."""
        frozen = create_trial(
            state=TrialState.COMPLETE,
            value=trial.minimised,
            params=trial.parameters,
            distributions=distributions(space),
            user_attrs=trial.attributes(),
        )
        stored = partial(self._study.get_trials, deepcopy=False)
        self.run(lambda: self._study.add_trial(frozen), lambda: len(stored()) > trial.number)

    @property
    def baselines(self) -> list[Baseline] | None:
        """The fixed trajectories; None if they were not scored yet."""
        held = self.run(lambda: self._study.user_attrs.get(BASELINES_KEY))
        try:
            return None if held is None else [Baseline.model_validate(baseline) for baseline in held]
        except (ValidationError, TypeError):
            raise InputError(f"{self.label}: {BASELINES_KEY}: cannot be read; give another folder") from None

    @baselines.setter
    def baselines(self, value: Sequence[Baseline]) -> None:
        plain = [baseline.model_dump() for baseline in value]
        self.run(lambda: self._study.set_user_attr(BASELINES_KEY, plain))


class FileStore(StudyStore):
    """Storage in the file `study.db` of a folder."""

    def __init__(self, folder: ResultFolder) -> None:
        self._file = folder.study_file
        self.label = str(self._file)

    @cached_property
    def storage(self) -> RDBStorage:
        # a path may have characters that mean something in a URL, such as ? and %41
        connect = partial(sqlite3.connect, self._file, check_same_thread=False)
        return RDBStorage("sqlite:///study.db", engine_kwargs={"creator": connect})

    def run(self, operation: Callable[[], Any], done: Callable[[], bool] | None = None) -> Any:
        try:
            return operation()
        except (InputError, UnavailableError):
            raise
        except Exception as error:  # damaged files and other versions of Optuna can cause any error
            raise _file_error(self.label, error) from None

    def close(self) -> None:
        if "storage" in vars(self):
            self.storage.remove_session()
            self.storage.engine.dispose()


class SharedStore(StudyStore):
    """Storage in a shared database."""

    def __init__(self, database: SharedDatabase, name: str) -> None:
        self._database = database
        self.name = name
        self.label = f"{database.address}: {name}"

    @property
    def storage(self) -> RDBStorage:
        return self._database.storage

    def run(self, operation: Callable[[], Any], done: Callable[[], bool] | None = None) -> Any:
        try:
            return self._database.run(operation, done)
        except (optuna.exceptions.OptunaError, KeyError, AssertionError) as error:
            reason = " ".join(str(error).split())
            raise InputError(f"{self.label}: must be a readable Optuna study ({reason}); give another folder") from None


def file_store(folder: ResultFolder) -> AbstractContextManager[FileStore]:
    """Return the storage in the file `study.db` of a folder, which a `with` block closes."""
    return closing(FileStore(folder))


def _file_error(label: str, error: BaseException) -> Exception:
    """Return the error of tatamu for one of Optuna or SQLite, with the text of its original cause."""
    cause = error
    while cause.__cause__ is not None:
        cause = cause.__cause__
    reason = " ".join(str(cause).split("[SQL")[0].split())[:120] or type(cause).__name__
    temporary = {  # parts of SQLite's messages about errors that do not damage the file, and their meanings
        "is full": "the disk is full",
        "is locked": "another program is using the file",
        "already exists": "another program is creating the file",
        "readonly": "cannot be written",
        "disk I/O error": "cannot be read or written now",
    }
    for word, meaning in temporary.items():
        if word in reason:
            return UnavailableError(
                f"{label}: {meaning}; finished trials are kept, so run the same command again later"
            )
    return InputError(f"{label}: must be a readable Optuna study ({reason}); remove the file, or give another folder")


@contextmanager
def held_store(
    folder: ResultFolder | None, database: SharedDatabase | None, record: StudyRecord
) -> Iterator[StudyStore]:
    """Yield the storage of a study: in memory, in the folder, or in a database, which locks it for the `with` block.

    Raises:
        InputError: If the study of this folder is stored in another place.
        UnavailableError: If the database does not answer, or another client has locked the study.
    """
    if folder is None:
        yield StudyStore()
        return
    kept = _shared_name(folder, database)
    if database is None:
        with file_store(folder) as store:
            yield store
        return
    name = kept or _make_name(folder, record.model_dump())
    database.hold(name)
    try:
        if kept is None:
            write_json(folder.shared_study_file, {"version": 1, "storage": database.address, "name": name})
        yield SharedStore(database, name)
    finally:
        database.release(name)


def load_settings(folder: ResultFolder | None, database: SharedDatabase | None) -> StudyRecord | None:
    """Return the settings of the study of a folder; None if the folder has no study.

    Raises:
        InputError: If the study of this folder is stored in another place, or cannot be read.
    """
    if folder is None:
        return None
    kept = _shared_name(folder, database)
    if database is not None and kept is not None:
        return SharedStore(database, kept).load()
    if database is None and os.path.exists(folder.study_file):  # a name may be too long for the disk
        with file_store(folder) as store:
            return store.load()
    return None


def _shared_name(folder: ResultFolder, database: SharedDatabase | None) -> str | None:
    """Return the name of a folder's study in the shared database; None if the database does not contain the study."""
    kept = folder.shared_study
    if database is None:
        if kept is not None:
            raise InputError(f"{folder.path}: the study is kept in {kept.storage}; give --storage, or another folder")
        return None
    if kept is None and folder.study_file.exists():
        raise InputError(f"{folder.path}: the study is kept in study.db; leave --storage out, or give another folder")
    if kept is not None and kept.storage != database.address:
        raise InputError(
            f"{folder.path}: the study is kept in {kept.storage}, but --storage is {database.address}; correct "
            "--storage, or give another folder"
        )
    return kept.name if kept else None


def _make_name(folder: ResultFolder, record: Mapping[str, Any]) -> str:
    """Return the name of a folder's study in a shared database, equal on all machines that have this path."""
    task = record["task"]
    fixed = {name: value for name, value in record.items() if name != "parallel"}
    whole = json.dumps([str(folder.path.absolute()), fixed], sort_keys=True)
    words = re.sub(r"[^\w.]+", "-", f"{task['garment']}-{task['fold']}")
    return f"{words}-seed-{record['seed']}-{sha256(whole.encode()).hexdigest()[:12]}"


def _difference(held: Any, wanted: Any, where: str = "") -> str:
    """Describe the first difference between two structures of plain data."""
    if isinstance(held, dict) and isinstance(wanted, dict):
        for key in [*held, *(k for k in wanted if k not in held)]:
            if held.get(key) != wanted.get(key):
                return _difference(held.get(key), wanted.get(key), f"{where}.{key}" if where else key)
    return f"{where} was {json.dumps(held)}, is now {json.dumps(wanted)}"
