"""Finds calls that take too long, and counts the threads of the workers, every few seconds.

A call that takes too long is moved to another worker, which never changes its result.
"""

from __future__ import annotations

import asyncio
import logging
from contextlib import suppress
from dataclasses import dataclass, field
from threading import Event, Thread
from time import time
from typing import Any

import distributed

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


async def replace_overdue(client: str, limit: float, dask_scheduler: Any = None) -> int:
    """Restart or remove the workers on which a client's calls take longer than `limit` [s], so that others run them.

    Dask passes the scheduler, on which this runs. The result is the number of the client's calls that have not ended.
    """
    calls = {
        call
        for call in dask_scheduler.clients[client].wants_what
        if call.state in ("processing", "queued", "no-worker")
    }
    workers = list(dask_scheduler.workers.values())
    late = [worker for worker in workers if _longest(worker, calls) > limit]
    await asyncio.gather(*(_replace(worker, dask_scheduler) for worker in late))
    return len(calls)


def _longest(worker: Any, calls: set[Any]) -> float:
    """Return the longest time for which a worker has run one of the calls [s], or has been silent since it got one."""
    silent = time() - worker.last_seen
    return max((worker.executing.get(call, 0.0) + silent for call in worker.processing if call in calls), default=0.0)


async def _replace(worker: Any, scheduler: Any) -> None:
    from distributed.core import rpc

    if worker.nanny:
        limit = 20.0  # [s]
        with suppress(OSError, asyncio.TimeoutError):
            async with rpc(worker.nanny, connection_args=scheduler.connection_args) as nanny:
                restarted = nanny.restart(timeout=limit, reason="tatamu: overdue")
                await asyncio.wait_for(restarted, limit)
    if scheduler.workers.get(worker.address) is worker:
        await scheduler.remove_worker(worker.address, stimulus_id=f"tatamu-overdue-{worker.address}")
