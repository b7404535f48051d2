"""Calls that take too long, and the number of threads, checked every second in a separate thread.

The watch determines where a call runs, never its result.
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
"""Seconds between two checks."""
NO_WORKERS = 10.0
"""Seconds without any worker after which a warning is logged."""

logger = logging.getLogger("tatamu.cluster")


@dataclass
class Patience:
    """Longest time that a call may take."""

    first: float = 1800.0
    """Limit until the first call has ended [s]; the first call includes the compilation."""
    least: float = 60.0
    """Lowest limit, however quick other calls were [s]."""
    factor: float = 10.0
    """Ratio of the limit to the longest time of any call."""

    def limit(self, longest: float | None) -> float:
        """Return the limit of a call's time [s], given the longest time so far [s]."""
        return self.first if longest is None else max(self.least, self.factor * longest)


@dataclass
class Watch:
    """The times of the calls under way."""

    patience: Patience = field(default_factory=Patience)
    threads: int = 1
    _since: dict[str, float] = field(default_factory=dict)
    _longest: float | None = None
    _lock: Lock = field(default_factory=Lock)
    _stopped: Event = field(default_factory=Event)
    _thread: Thread | None = None
    _nobody: bool = False

    def start(self, client: distributed.Client, tell: Callable[[int], None]) -> None:
        """Start the checks; `tell` is called with the number of the workers' threads."""
        self._look(client, tell)
        self._thread = Thread(target=self._run, args=(client, tell), name="tatamu-watch", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Stop the checks."""
        self._stopped.set()
        if self._thread is not None:
            self._thread.join(timeout=2 * EVERY)

    def sent(self, key: str) -> None:
        """Record that a call was sent."""
        with self._lock:
            self._since[key] = monotonic()

    def ended(self, key: str) -> None:
        """Record that a call has ended."""
        with self._lock:
            taken = monotonic() - self._since.pop(key)
            self._longest = max(taken, self._longest or 0.0)

    def overdue(self) -> list[str]:
        """Return the calls that have taken too long."""
        now = monotonic()
        with self._lock:
            limit = self.patience.limit(self._longest)
            return [key for key, since in self._since.items() if now - since > limit]

    def begin_again(self) -> None:
        """Restart the time of every call, because a worker was replaced and its calls run on other workers."""
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
            except Exception as error:  # the scheduler is gone or busy; callers that wait for results get the error
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
