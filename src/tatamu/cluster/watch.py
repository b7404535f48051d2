"""Finds calls that take too long, and counts the threads of the workers. A separate thread does this every second.

A call that takes too long is moved to another worker. This never changes the result of the call.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass, field
from threading import Event, Lock, Thread
from time import monotonic

import distributed

from tatamu.cluster.call import replace_workers

EVERY = 1.0
"""Time between two checks for calls that take too long [s]."""
NO_WORKERS = 10.0
"""Longest time without any worker [s]. After this time, a warning is logged."""

logger = logging.getLogger("tatamu.cluster")


@dataclass
class Patience:
    """The rule for the time limit of a call. A call that exceeds this limit is moved to another worker."""

    first: float = 1800.0
    """Time limit of the first calls, until one call has ended [s].

    This limit is long because the first call includes a compilation.
    """
    least: float = 60.0
    """Smallest time limit of a call [s]. It applies even if all finished calls were short."""
    factor: float = 10.0
    """Ratio of a call's time limit to the longest time of a finished call."""

    def limit(self, longest: float | None) -> float:
        """Return the time limit of a call [s]. `longest` is the longest time of a finished call [s]."""
        return self.first if longest is None else max(self.least, self.factor * longest)


@dataclass
class Watch:
    """The times for which the sent calls have run, and a thread that finds the calls that take too long."""

    patience: Patience = field(default_factory=Patience)
    threads: int = 1
    _since: dict[str, float] = field(default_factory=dict)
    _longest: float | None = None
    _lock: Lock = field(default_factory=Lock)
    _stopped: Event = field(default_factory=Event)
    _thread: Thread | None = None
    _nobody: bool = False

    def start(self, client: distributed.Client, tell: Callable[[int], None]) -> None:
        """Start the thread. At each check, it calls the function `tell` with the number of the workers' threads."""
        self._look(client, tell)
        self._thread = Thread(target=self._run, args=(client, tell), name="tatamu-watch", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Stop the thread."""
        self._stopped.set()
        if self._thread is not None:
            self._thread.join(timeout=2 * EVERY)

    def sent(self, key: str) -> None:
        """Record that the call with this key was sent."""
        with self._lock:
            self._since[key] = monotonic()

    def ended(self, key: str) -> None:
        """Record that the call with this key has ended."""
        with self._lock:
            taken = monotonic() - self._since.pop(key)
            self._longest = max(taken, self._longest or 0.0)

    def overdue(self) -> list[str]:
        """Return the keys of the calls that have exceeded their time limit."""
        now = monotonic()
        with self._lock:
            limit = self.patience.limit(self._longest)
            return [key for key, since in self._since.items() if now - since > limit]

    def begin_again(self) -> None:
        """Start to measure the time of every call from 0 again.

        This is done after a worker was replaced, because its calls start again.
        """
        with self._lock:
            self._since = dict.fromkeys(self._since, monotonic())

    def _run(self, client: distributed.Client, tell: Callable[[int], None]) -> None:
        empty = 0.0
        while not self._stopped.wait(EVERY):
            try:
                self._look(client, tell)
                late = self.overdue()
                if late:
                    client.run_on_scheduler(replace_workers, late)
                    self.begin_again()
            except Exception as error:  # the scheduler is gone or busy; callers get the error elsewhere
                logger.debug("the scheduler did not answer: %s", error)
                continue
            empty = empty + EVERY if self._nobody and self._since else 0.0
            if NO_WORKERS <= empty < NO_WORKERS + EVERY:
                logger.warning("tatamu: the scheduler has no workers; waiting for some")

    def _look(self, client: distributed.Client, tell: Callable[[int], None]) -> None:
        threads = sum(client.nthreads().values())
        self._nobody = threads == 0
        self.threads = max(1, threads)
        tell(self.threads)
