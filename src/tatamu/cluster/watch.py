"""Finds calls that take too long, and counts the threads of the workers, every few seconds.

A call that takes too long is moved to another worker, which never changes its result.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass, field
from threading import Event, Thread

import distributed

from tatamu.cluster.call import replace_overdue

EVERY = 5.0
"""Time between two checks [s]."""

logger = logging.getLogger("tatamu.cluster")


@dataclass
class Patience:
    """How long a call may take."""

    first: float = 1800.0
    """Time limit of the first calls, which include a compilation [s]."""
    minimum: float = 60.0
    """Smallest time limit of later calls [s]."""
    factor: float = 10.0
    """Their time limit, in times of the longest finished call."""

    def limit(self, longest: float | None) -> float:
        """Return the time limit of a call [s]. `longest` is the longest time of a finished call [s]."""
        return self.first if longest is None else max(self.minimum, self.factor * longest)


@dataclass
class Watch:
    """A thread that has the calls that take too long moved to other workers, and counts the workers' threads."""

    patience: Patience = field(default_factory=Patience)
    threads: int = 1
    _longest: float | None = None
    _stopped: Event = field(default_factory=Event)
    _thread: Thread | None = None

    def start(self, client: distributed.Client) -> None:
        """Start the thread."""
        self._count(client)
        self._thread = Thread(target=self._run, args=(client,), name="tatamu-watch", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Stop the thread."""
        self._stopped.set()
        if self._thread is not None:
            self._thread.join(timeout=2 * EVERY)

    def ended(self, seconds: float) -> None:
        """Record the time that a finished call took [s]."""
        self._longest = max(seconds, self._longest or 0.0)

    def _run(self, client: distributed.Client) -> None:
        idle = 0
        while not self._stopped.wait(EVERY):
            try:
                threads = self._count(client)
                limit = self.patience.limit(self._longest)
                calls = client.run_on_scheduler(replace_overdue, client.id, limit) if client.futures else 0
            except Exception as error:  # the scheduler is gone or busy; callers get the error elsewhere
                logger.debug("the scheduler did not answer: %s", error)
                continue
            idle = idle + 1 if calls and not threads else 0
            if idle == 2:
                logger.warning("tatamu: waiting for workers, because the scheduler has none")

    def _count(self, client: distributed.Client) -> int:
        threads = sum(client.nthreads().values())
        self.threads = max(1, threads)
        return threads
