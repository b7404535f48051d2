"""Calls that take too long, and how many threads there are: looked at every second in a thread of its own.

It decides where a call runs, never what it gives.
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
"""Seconds between two looks."""
NO_WORKERS = 10.0
"""Seconds without any worker after which it is said."""

logger = logging.getLogger("tatamu.cluster")


@dataclass
class Patience:
    """How long a call may take."""

    first: float = 1800.0
    """While none has ended: a first call compiles [s]."""
    least: float = 60.0
    """However quick the others were [s]."""
    factor: float = 10.0
    """Over the longest that any call took."""

    def limit(self, longest: float | None) -> float:
        """The longest that a call may take [s], where the longest so far took `longest`."""
        return self.first if longest is None else max(self.least, self.factor * longest)


@dataclass
class Watch:
    """The times of the calls that are away."""

    patience: Patience = field(default_factory=Patience)
    threads: int = 1
    _since: dict[str, float] = field(default_factory=dict)
    _longest: float | None = None
    _lock: Lock = field(default_factory=Lock)
    _stopped: Event = field(default_factory=Event)
    _thread: Thread | None = None
    _nobody: bool = False

    def start(self, client: distributed.Client, tell: Callable[[int], None]) -> None:
        """Begin to look; `tell` hears how many threads the workers have."""
        self._look(client, tell)
        self._thread = Thread(target=self._run, args=(client, tell), name="tatamu-watch", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Look no more."""
        self._stopped.set()
        if self._thread is not None:
            self._thread.join(timeout=2 * EVERY)

    def sent(self, key: str) -> None:
        """A call went away."""
        with self._lock:
            self._since[key] = monotonic()

    def ended(self, key: str) -> None:
        """A call came back."""
        with self._lock:
            taken = monotonic() - self._since.pop(key)
            self._longest = max(taken, self._longest or 0.0)

    def overdue(self) -> list[str]:
        """The calls that have been away for too long."""
        now = monotonic()
        with self._lock:
            limit = self.patience.limit(self._longest)
            return [key for key, since in self._since.items() if now - since > limit]

    def begin_again(self) -> None:
        """Count every call from now: a worker was replaced, and what it had runs on others."""
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
            except Exception as error:  # the scheduler is gone or busy: those who wait for results hear of it
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
