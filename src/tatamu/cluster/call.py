"""Functions that run on workers and on the scheduler."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import suppress
from time import perf_counter, time
from typing import Any

from tatamu.base.errors import UnavailableError
from tatamu.cluster.versions import Versions, difference, processor, versions


def checked_call(of_client: Versions, function: Callable[..., Any], *args: Any, **kwargs: Any) -> tuple[float, Any]:
    """Call a function on a worker with the versions of the client, and return its wall time [s] and its result.

    Raises:
        UnavailableError: If a version differs. This happens if the worker joined after the check at the start.
    """
    if of_client != versions():
        differing = (difference(of_client) or "").replace(" there", " at the client").replace(" here", " at the worker")
        raise UnavailableError(
            f"a worker must have the versions of this client, given {differing}; install the same versions"
        )
    begun = perf_counter()
    result = function(*args, **kwargs)
    return perf_counter() - begun, result


def identify() -> tuple[Versions, str]:
    """Return the versions of packages on a worker, and the kind of its processor."""
    return dict(versions()), processor()


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
