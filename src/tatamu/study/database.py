"""Studies in a shared PostgreSQL database, which several clients may use at a time through Optuna's `RDBStorage`.

Passwords come from PGPASSWORD or ~/.pgpass, which libpq reads. No address, message or file of tatamu contains a
password. A lost connection is opened again for a limited time. Only one client uses a study at a time: it has an
advisory lock, which the server releases however the client ends.
"""

from __future__ import annotations

import os
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
from sqlalchemy.engine import URL, ExceptionContext, make_url
from sqlalchemy.exc import ArgumentError, SQLAlchemyError

from tatamu.errors import InputError, UnavailableError

Value = TypeVar("Value")

OPENING_SECONDS = 10.0
"""Time for which the first connection is tried [s]."""
RETRY_SECONDS = 120.0
"""Time for which a lost connection is tried again [s]."""
HOLD_SECONDS = 15.0
"""Time that another client with a lock on the study has to end [s]."""
PAUSE = 0.25
"""Seconds between two tries."""
CONNECTIONS = 4
"""Largest number of connections of one client, in addition to the one that locks its studies."""
SERVER_OPTIONS = "-c tcp_keepalives_idle=60 -c tcp_keepalives_interval=10 -c tcp_keepalives_count=3"
"""Options with which the server releases the locks of a machine that disappeared."""
LOST_STATES = ("08", "57P", "53300")
"""SQLSTATEs, or their beginnings, of a connection that is not available now: lost, shutdown, too many clients."""
PASSING_STATES = (*LOST_STATES, "40001", "40P01", "42P07", "42710", "23505")
"""SQLSTATEs of temporary errors, which include conflicts and another client that creates the tables."""
PASSING_WORDS = (
    "refused",
    "starting up",
    "shutting down",
    "recovery mode",
    "not yet accepting connections",
    "too many clients",
    "closed the connection",
    "connection is closed",
    "terminating connection",
    "timeout expired",
    "reset by peer",
    "no such file or directory",
)
"""Texts of such errors, if the driver gives no state."""


class ConnectionLostError(Exception):
    """The connection to the database was lost.

    This is no error of SQLAlchemy, so that Optuna does not repeat the operation without a check whether it was done.
    """


def parse_storage(given: str) -> str:
    """Read the address of a database: `postgresql://USER@HOST/DB`.

    Raises:
        InputError: If it is no such address, or contains a password; the message never repeats the password.
    """
    wanted = "must be postgresql://USER@HOST/DB"
    try:
        url = make_url(given)
    except (ArgumentError, ValueError):
        raise InputError(f"--storage: {wanted}") from None
    if url.password is not None or any("password" in name.lower() for name in url.query):
        raise InputError("--storage: holds a password; leave it out and set PGPASSWORD, or write it into ~/.pgpass")
    if url.drivername not in ("postgresql", "postgres"):
        raise InputError(f"--storage: {wanted}, given {url.drivername}://..")
    if not url.database:
        raise InputError(f"--storage: {wanted}, given no database")
    return url.set(drivername="postgresql").render_as_string()


@dataclass
class SharedDatabase:
    """One database, with the connections of this process."""

    address: str
    """`postgresql://USER@HOST/DB`, without a password."""
    retry_seconds: float = RETRY_SECONDS
    _storage: RDBStorage | None = None
    _holding: Connection | None = None
    _held: set[str] = field(default_factory=set)
    _lock: RLock = field(default_factory=RLock)

    @property
    def storage(self) -> RDBStorage:
        """The storage for Optuna, connected at the first use.

        Raises:
            InputError: If the database refuses.
            UnavailableError: If it does not answer.
        """
        with self._lock:
            if self._storage is None:
                self._storage = self._persist(self._open, OPENING_SECONDS)
            return self._storage

    def run(self, operation: Callable[[], Value], done: Callable[[], bool] | None = None) -> Value | None:
        """Do an operation, and repeat it if the connection was lost.

        Args:
            operation: Reads, or writes in one transaction.
            done: Returns whether an earlier try, whose answer was lost, did the operation; called before each new try.

        Returns:
            The result of the operation; None if its answer was lost.
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
        """Lock a study until `release` or the end of this process.

        Raises:
            UnavailableError: If another client uses the study.
        """
        deadline = monotonic() + HOLD_SECONDS
        while not self.run(lambda: self._try_hold(name)):
            if monotonic() > deadline:
                raise UnavailableError(f"{self.address}: another client is learning {name} at this moment")
            sleep(PAUSE)
        with self._lock:
            self._held.add(name)

    def release(self, name: str) -> None:
        """Let go of a study."""
        with self._lock:
            self._held.discard(name)
            if self._holding is not None:
                try:
                    self._holding.execute(sql("SELECT pg_advisory_unlock(hashtextextended(:name, 0))"), {"name": name})
                except (SQLAlchemyError, ConnectionLostError):
                    self._drop_holding()  # it ended with its connection

    def close(self) -> None:
        """Close all connections and release all locks."""
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
        """Lock the studies again that were locked before the connection was lost."""
        with self._lock:
            try:
                if self._holding is not None:
                    self._holding.execute(sql("SELECT 1"))
                    return
            except (SQLAlchemyError, ConnectionLostError):
                self._drop_holding()
            for name in self._held:
                if not self._try_hold(name):
                    raise UnavailableError(f"{self.address}: another client took over {name} while it was away")

    def _drop_holding(self) -> None:
        if self._holding is not None:
            self._holding.invalidate()
            self._holding.close()
        self._holding = None

    def _persist(self, operation: Callable[[], Value], seconds: float) -> Value:
        """Do an operation until it works or time is up.

        Raises:
            InputError: If the database refuses.
            UnavailableError: If the database did not answer within the time, or its disk is full.
        """
        deadline = monotonic() + seconds
        while True:
            try:
                return operation()
            except (SQLAlchemyError, optuna.exceptions.StorageInternalError, ConnectionLostError) as error:
                state, reason = _reason(error)
                if state.startswith("53100"):
                    text = f"{self.address}: the disk of the database is full; what was finished is kept"
                    raise UnavailableError(text) from None
                if not _passes(state, reason):
                    raise InputError(f"{self.address}: the database refuses ({reason})") from None
                if monotonic() > deadline:
                    raise UnavailableError(
                        f"{self.address}: no answer for {seconds:g} s ({reason}); what was finished is kept"
                    ) from None
                sleep(PAUSE)

    def _open(self) -> RDBStorage:
        url = make_url(self.address).set(drivername="postgresql+psycopg")
        storage = RDBStorage(
            _rendered(url),
            engine_kwargs={
                "pool_size": CONNECTIONS + 1,
                "max_overflow": 0,
                "pool_timeout": 600,
                "connect_args": {"connect_timeout": 5, "application_name": "tatamu", "options": SERVER_OPTIONS},
            },
        )
        event.listen(storage.engine, "handle_error", _say_that_it_was_lost)
        return storage


@contextmanager
def shared_database(address: str | None) -> Iterator[SharedDatabase | None]:
    """Yield the database of an address while the block runs, with few connections; None for None.

    Args:
        address: `postgresql://USER@HOST/DB`.

    Raises:
        InputError: If the address is invalid, its driver is not installed, or the database refuses.
        UnavailableError: If it does not answer.
    """
    if address is None:
        yield None
        return
    parsed = parse_storage(address)
    try:
        import psycopg  # noqa: F401
    except ImportError:
        raise InputError("--storage: needs psycopg; python -m pip install 'tatamu[cluster]'") from None
    database = SharedDatabase(parsed)
    try:
        _ = database.storage
        yield database
    finally:
        database.close()


def _rendered(url: URL) -> str:
    return url.render_as_string(hide_password=False)


def _say_that_it_was_lost(context: ExceptionContext) -> None:
    """Turn the loss of a connection into an error after which Optuna does not retry."""
    state, reason = _reason(context.original_exception)
    if context.is_disconnect or _passes(state, reason, LOST_STATES):
        raise ConnectionLostError(reason)


def _passes(state: str, reason: str, states: tuple[str, ...] = PASSING_STATES) -> bool:
    return state.startswith(states) if state else any(words in reason.lower() for words in PASSING_WORDS)


def _reason(error: BaseException) -> tuple[str, str]:
    """Return the SQLSTATE of an error, if it has one, and the driver's message in one line."""
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
