"""Where a study is kept: in the file `study.db` of its folder, or in a shared database that `study.json` names."""

from __future__ import annotations

import json
import os
import re
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from typing import Any, Protocol, TypeVar

import optuna
from optuna.storages import RDBStorage
from sqlalchemy.exc import SQLAlchemyError

from tatamu.errors import InputError, UnavailableError
from tatamu.learning.database import SharedDatabase
from tatamu.results import ResultFolder, SharedStudyRecord

Value = TypeVar("Value")

NAME = "tatamu"
"""Of the only study in a file."""
PASSING = {
    "is full": "the disk is full",
    "is locked": "another program holds it",
    "already exists": "another program is making it at this moment",
    "readonly": "cannot be written",
    "disk I/O error": "cannot be read or written now",
}
"""Messages of a database that is not damaged, and their meaning."""


def _nothing() -> None:
    return None


class StudyPlace(Protocol):
    """A database and the name of a study in it."""

    name: str
    label: str
    """For messages."""

    @property
    def storage(self) -> RDBStorage:
        """For Optuna, connected when first asked for."""
        ...

    def run(self, operation: Callable[[], Value], done: Callable[[], Value | None] = _nothing) -> Value:
        """Do an operation that reads, or that writes in one transaction.

        Args:
            operation: It.
            done: Its result, if a try whose answer was lost did it; else None.

        Raises:
            InputError: The database cannot be used.
        """
        ...

    def expect_writes(self) -> None:
        """Get ready for trials to be written; the same again does nothing."""
        ...

    def close(self) -> None:
        """Let go of what only this place uses."""
        ...


class FilePlace:
    """The study of a folder, in a file of SQLite.

    While it is written, finished transactions lie in a write-ahead log beside the file (`study.db-wal`), so that a
    trial costs no wait for the disk and outlives a killed process; `close` makes one file of both. Where there is
    no such log, the file is written as ever.
    """

    name = NAME

    def __init__(self, path: Path) -> None:
        self.label = str(path)
        self._path = path
        self._logging = False

    @cached_property
    def storage(self) -> RDBStorage:
        """For Optuna, connected when first asked for."""
        return RDBStorage(f"sqlite:///{self._path}", engine_kwargs={"creator": self._connected})

    def expect_writes(self) -> None:
        """Open the log, once."""
        if not self._logging:
            self._logging = True
            self._disconnect(self.storage)

    def close(self) -> None:
        """Close the file, if it is open."""
        storage = self.__dict__.pop("storage", None)
        if storage is not None:
            self._disconnect(storage)
        if self._logging:
            self._logging = False
            with suppress(sqlite3.Error), closing(sqlite3.connect(self._path, timeout=0.0)) as alone:
                alone.execute("PRAGMA journal_mode = DELETE")  # not possible, nor needed, while another program reads

    @staticmethod
    def _disconnect(storage: RDBStorage) -> None:
        storage.remove_session()
        storage.engine.dispose()

    def _connected(self) -> sqlite3.Connection:
        connection = sqlite3.connect(self._path, check_same_thread=False)
        if self._logging:
            connection.execute("PRAGMA journal_mode = WAL")
            connection.execute("PRAGMA synchronous = NORMAL")
        return connection

    def run(self, operation: Callable[[], Value], done: Callable[[], Value | None] = _nothing) -> Value:
        """Do an operation, once."""
        try:
            return operation()
        except (SQLAlchemyError, optuna.exceptions.OptunaError, KeyError, AssertionError) as error:
            cause: BaseException = error
            while cause.__cause__ is not None:  # Optuna's own words do not say that a disk is full
                cause = cause.__cause__
            reason = " ".join(str(cause).split("[SQL")[0].split())[:120]
            passing = [text for word, text in PASSING.items() if word in reason]
            if passing:
                text = f"{self.label}: {passing[0]}; what was finished is kept, try again then"
                raise UnavailableError(text) from None
            raise InputError(
                f"{self.label}: is not a readable Optuna study ({reason}); remove it or give another folder"
            ) from None


class SharedPlace:
    """A study in a shared database."""

    def __init__(self, database: SharedDatabase, name: str) -> None:
        self.name = name
        self.label = f"{database.address}: {name}"
        self._database = database

    @property
    def storage(self) -> RDBStorage:
        """For Optuna."""
        return self._database.storage

    def run(self, operation: Callable[[], Value], done: Callable[[], Value | None] = _nothing) -> Value:
        """Do an operation, again where the connection was lost."""
        try:
            return self._database.run(operation, done)
        except (optuna.exceptions.OptunaError, KeyError, AssertionError) as error:
            raise InputError(f"{self.label}: is not a readable Optuna study ({' '.join(str(error).split())})") from None

    def expect_writes(self) -> None:
        """Nothing: the server is always ready."""

    def close(self) -> None:
        """Nothing: connections are the database's."""


@contextmanager
def held_place(folder: ResultFolder, database: SharedDatabase | None, identity: dict[str, Any]) -> Iterator[StudyPlace]:
    """The place of a study, which nobody else may use while the block runs.

    Args:
        folder: Of the study.
        database: A shared one, or None: the folder's own file.
        identity: Of the study, from which its name in a shared database is made.

    Raises:
        InputError: The study of this folder is elsewhere.
        UnavailableError: The database does not answer, or another client holds the study.
    """
    kept = shared_study(folder, database)
    if database is None:
        place = FilePlace(folder.study_file)
        try:
            yield place
        finally:
            place.close()
        return
    name = kept or _name(folder, identity)
    database.hold(name)
    try:
        if kept is None:
            folder.write_shared_study(SharedStudyRecord(version=1, storage=database.address, name=name))
        yield SharedPlace(database, name)
    finally:
        database.release(name)


def existing_place(folder: ResultFolder, database: SharedDatabase | None) -> StudyPlace | None:
    """The place of the study that a folder has, to be read; None if it has none.

    Raises:
        InputError: The study of this folder is elsewhere.
    """
    kept = shared_study(folder, database)
    if database is not None:
        return SharedPlace(database, kept) if kept else None
    return FilePlace(folder.study_file) if os.path.exists(folder.study_file) else None


def shared_study(folder: ResultFolder, database: SharedDatabase | None) -> str | None:
    """The name of a folder's study in the shared database; None if it has none there.

    Raises:
        InputError: The folder has a study elsewhere.
    """
    kept = folder.shared_study
    if database is None:
        if kept is not None:
            raise InputError(f"{folder.path}: its study is in {kept.storage}; give --storage, or another folder")
        return None
    if kept is None and folder.study_file.exists():
        raise InputError(f"{folder.path}: its study is in study.db; leave --storage out, or give another folder")
    if kept is not None and kept.storage != database.address:
        raise InputError(f"{folder.path}: its study is in {kept.storage}, given {database.address}")
    return kept.name if kept else None


def _name(folder: ResultFolder, identity: dict[str, Any]) -> str:
    """A name that this folder and this task have alone, on every machine that has the folder under this path."""
    task = identity["task"]
    apart = {name: value for name, value in identity.items() if name != "parallel"}
    whole = json.dumps([str(folder.path.absolute()), apart], sort_keys=True)
    words = re.sub(r"[^\w.]+", "-", f"{task['garment']}-{task['fold']}")
    return f"{words}-seed-{identity['seed']}-{sha256(whole.encode()).hexdigest()[:12]}"
