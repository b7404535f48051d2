"""Studies in a shared PostgreSQL database, which several clients may use at a time through Optuna's `RDBStorage`.

Passwords come from PGPASSWORD or ~/.pgpass, which libpq reads; addresses, messages and files of tatamu contain none. A
lost connection is opened again for a limited time. A client holds the advisory lock of its study, which the server
releases when the client ends, even by a crash.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from threading import RLock
from time import monotonic, sleep
from typing import Any, TypeVar

import optuna
from optuna.storages import RDBStorage
from sqlalchemy import Connection, event
from sqlalchemy import text as sql
from sqlalchemy.engine import ExceptionContext, make_url
from sqlalchemy.exc import ArgumentError, SQLAlchemyError

from tatamu.base.errors import InputError, UnavailableError
from tatamu.base.extras import lacking

Value = TypeVar("Value")

OPENING_SECONDS = 10.0
"""Maximum time for opening the first connection [s]."""
HOLD_SECONDS = 15.0
"""Maximum time for which a client waits for a study that another client has locked [s]."""
PAUSE = 0.25
"""Pause between two attempts to use the database, or to lock a study [s]."""
LOST_STATES = ("08", "57P", "53300")
"""Beginnings of SQLSTATE codes: the connection was lost, the server shuts down or has too many clients."""
PASSING_STATES = (*LOST_STATES, "40001", "40P01", "42P07", "42710", "23505")
"""SQLSTATE codes after which an operation is repeated: also conflicts, and tables that another client creates at this
time."""
PASSING_WORDS = re.compile(
    "refused|starting up|shutting down|recovery mode|not yet accepting connections|too many clients|"
    "closed the connection|connection is closed|terminating connection|timeout expired|reset by peer|"
    "no such file or directory"
)
"""Parts of messages after which an operation is repeated, if the driver gives no SQLSTATE code."""


class ConnectionLostError(Exception):
    """The connection was lost.

    It is no SQLAlchemy error, because Optuna would repeat the operation after one. Tatamu first checks whether it was
    done.
    """


def parse_storage(given: str) -> str:
    """Return a database's address as `postgresql://USER@HOST/DB`. Errors never repeat a password, which is refused."""
    wanted = "must be postgresql://USER@HOST/DB"
    try:
        url = make_url(given)
    except (ArgumentError, ValueError):
        raise InputError(f"--storage: {wanted}") from None
    if url.password is not None or any("password" in name.lower() for name in url.query):
        raise InputError("--storage: must not contain a password; set PGPASSWORD or use ~/.pgpass instead")
    if url.drivername not in ("postgresql", "postgres"):
        raise InputError(f"--storage: {wanted}, given {url.drivername}://..")
    if not url.database:
        raise InputError(f"--storage: {wanted}, given no database")
    return url.set(drivername="postgresql").render_as_string()


@dataclass
class SharedDatabase:
    """A database that several machines use, with this process's connections to it."""

    address: str
    retry_seconds: float = 120.0
    """Maximum time for opening a lost connection again [s]."""
    _storage: RDBStorage | None = None
    _holding: Connection | None = None
    _held: set[str] = field(default_factory=set)
    _lock: RLock = field(default_factory=RLock)

    @property
    def storage(self) -> RDBStorage:
        """Optuna's storage in the database, connected at the first use."""
        with self._lock:
            if self._storage is None:
                self._storage = self._persist(self._open, OPENING_SECONDS)
            return self._storage

    def run(self, operation: Callable[[], Value], done: Callable[[], bool] | None = None) -> Value | None:
        """Run an operation that reads, or that writes in one transaction, and repeat it if the connection was lost.

        `done` is called before each new attempt. It returns whether an earlier one was completed and only the answer
        was lost; then the result is None.
        """
        first = True

        def attempt() -> Value | None:
            nonlocal first
            if not first:
                self._hold_again()
                if done is not None and done():
                    return None
            first = False
            return operation()

        return self._persist(attempt, self.retry_seconds)

    def hold(self, name: str) -> None:
        """Lock a study against other clients until `release` is called or this process ends.

        Raises:
            UnavailableError: If another client uses the study.
        """
        deadline = monotonic() + HOLD_SECONDS
        while not self.run(lambda: self._try_hold(name)):
            if monotonic() > deadline:
                raise UnavailableError(
                    f"{self.address}: another client is learning {name} now; wait until that client has finished"
                )
            sleep(PAUSE)
        with self._lock:
            self._held.add(name)

    def release(self, name: str) -> None:
        with self._lock:
            self._held.discard(name)
            if self._holding is not None:
                try:
                    self._holding.execute(sql("SELECT pg_advisory_unlock(hashtextextended(:name, 0))"), {"name": name})
                except (SQLAlchemyError, ConnectionLostError):
                    self._drop_holding()  # the lock ended with its connection

    def close(self) -> None:
        with self._lock:
            self._drop_holding()
            if self._storage is not None:
                self._storage.engine.dispose()
            self._storage = None

    def _try_hold(self, name: str) -> bool:
        with self._lock:
            if self._holding is None:
                self._holding = self.storage.engine.connect().execution_options(isolation_level="AUTOCOMMIT")
            asked = sql("SELECT pg_try_advisory_lock(hashtextextended(:name, 0))")
            try:
                return bool(self._holding.execute(asked, {"name": name}).scalar())
            except (SQLAlchemyError, ConnectionLostError):
                self._drop_holding()
                raise

    def _hold_again(self) -> None:
        """Lock all studies again that this process had locked, after a lost connection."""
        with self._lock:
            try:
                if self._holding is not None:
                    self._holding.execute(sql("SELECT 1"))
                    return
            except (SQLAlchemyError, ConnectionLostError):
                self._drop_holding()
            for name in self._held:
                if not self._try_hold(name):
                    raise UnavailableError(
                        f"{self.address}: another client took over {name} while this client was disconnected; "
                        "finished trials are kept"
                    )

    def _drop_holding(self) -> None:
        if self._holding is not None:
            self._holding.invalidate()
            self._holding.close()
        self._holding = None

    def _persist(self, operation: Callable[[], Value], seconds: float) -> Value:
        """Repeat an operation until it succeeds, for at most `seconds` [s].

        Raises:
            InputError: If the database refuses the operation.
            UnavailableError: If the database did not answer within the time, or its disk is full.
        """
        deadline = monotonic() + seconds
        while True:
            try:
                return operation()
            except (SQLAlchemyError, optuna.exceptions.StorageInternalError, ConnectionLostError) as error:
                state, reason = _reason(error)
                if state.startswith("53100"):
                    text = f"{self.address}: the disk of the database is full; finished work is kept"
                    raise UnavailableError(text) from None
                if not _passes(state, reason):
                    raise InputError(
                        f"{self.address}: the database refused the request ({reason}); check --storage and your "
                        "permissions in the database"
                    ) from None
                if monotonic() > deadline:
                    raise UnavailableError(
                        f"{self.address}: has not answered for {seconds:g} s ({reason}); finished trials are kept, so "
                        "run the same command again later"
                    ) from None
                sleep(PAUSE)

    def _open(self) -> RDBStorage:
        url = make_url(self.address).set(drivername="postgresql+psycopg")
        # with these, the server notices that a client's machine has disappeared, and releases its locks
        alive = "-c tcp_keepalives_idle=60 -c tcp_keepalives_interval=10 -c tcp_keepalives_count=3"
        storage = RDBStorage(
            url.render_as_string(hide_password=False),
            engine_kwargs={
                "pool_size": 5,  # one connection locks the studies of this client
                "max_overflow": 0,
                "pool_timeout": 600,
                "connect_args": {"connect_timeout": 5, "application_name": "tatamu", "options": alive},
            },
        )
        event.listen(storage.engine, "handle_error", _say_that_it_was_lost)
        return storage


@contextmanager
def shared_database(address: str | None) -> Iterator[SharedDatabase | None]:
    """Yield the shared database at an address, and close it when the `with` block ends; None without an address.

    Raises:
        InputError: If the address is invalid, its driver is not installed, or the database refuses the connection.
        UnavailableError: If the database does not answer.
    """
    if address is None:
        yield None
        return
    parsed = parse_storage(address)
    try:
        import psycopg  # noqa: F401
    except ImportError:
        raise lacking("psycopg", "cluster", "--storage") from None
    database = SharedDatabase(parsed)
    try:
        _ = database.storage
        yield database
    finally:
        database.close()


def _say_that_it_was_lost(context: ExceptionContext) -> None:
    """Raise a `ConnectionLostError` for an SQLAlchemy error that means this."""
    state, reason = _reason(context.original_exception)
    if context.is_disconnect or _passes(state, reason, LOST_STATES):
        raise ConnectionLostError(reason)


def _passes(state: str, reason: str, states: tuple[str, ...] = PASSING_STATES) -> bool:
    return state.startswith(states) if state else bool(PASSING_WORDS.search(reason.lower()))


def _reason(error: BaseException) -> tuple[str, str]:
    """Return the SQLSTATE code of an error, or "", and the driver's message in one line."""
    cause: Any = error
    while getattr(cause, "orig", None) or cause.__cause__:
        cause = getattr(cause, "orig", None) or cause.__cause__
    state = getattr(cause, "sqlstate", None) or ("08" if isinstance(error, ConnectionLostError) else "")
    words = str(cause).split("[SQL")[0].split("Is the server running")[0]
    words = words.split("Multiple connection attempts failed")[0]
    password = os.environ.get("PGPASSWORD")
    if password:
        words = words.replace(password, "***")
    return state, " ".join(words.split())[:200]
