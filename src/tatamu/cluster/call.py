"""Functions that run on workers and on the scheduler."""

from __future__ import annotations

import asyncio
import pickle
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any

from tatamu.base.errors import UnavailableError
from tatamu.cluster.versions import Versions, difference, processor, versions

RESTART_SECONDS = 20.0
"""Time limit for the restart of a worker by its nanny, Dask's process that supervises the worker [s]."""


def unpacked(content: bytes) -> Any:
    """Unpickle an argument that many calls share. The worker keeps the result."""
    return pickle.loads(content)


def checked_call(of_client: Versions, function: Callable[..., Any], *args: Any, **kwargs: Any) -> Any:
    """Call a function on a worker, if the worker has the same versions of all relevant packages as the client.

    Raises:
        UnavailableError: If a version differs. This happens if the worker joined after the check at the start.
    """
    if of_client != versions():
        differing = difference(of_client)
        raise UnavailableError(f"a worker has other versions than this client: {_turned(differing)}; make them equal")
    return function(*args, **kwargs)


def identify() -> tuple[Versions, str]:
    """Return the versions of packages on a worker, and the kind of its processor."""
    return dict(versions()), processor()


async def replace_workers(keys: Sequence[str], dask_scheduler: Any = None) -> None:
    """Restart or remove the workers on which calls take too long. Other workers then run the calls of these workers.

    This function runs on the scheduler.

    Args:
        keys: Keys of the calls that take too long.
        dask_scheduler: The scheduler. Dask passes this argument.
    """
    states = [dask_scheduler.tasks.get(key) for key in keys]
    workers = {state.processing_on for state in states if state is not None and state.processing_on is not None}
    await asyncio.gather(*(_replace(worker, dask_scheduler) for worker in workers))


async def _replace(worker: Any, scheduler: Any) -> None:
    from distributed.core import rpc

    if worker.nanny:
        with suppress(OSError, asyncio.TimeoutError):
            async with rpc(worker.nanny, connection_args=scheduler.connection_args) as nanny:
                restarted = nanny.restart(timeout=RESTART_SECONDS, reason="tatamu: overdue")
                await asyncio.wait_for(restarted, RESTART_SECONDS)
    if scheduler.workers.get(worker.address) is worker:
        await scheduler.remove_worker(worker.address, stimulus_id=f"tatamu-overdue-{worker.address}")


def _turned(differing: str | None) -> str:
    """Rewrite a worker's text from `difference` for the user, who is at the client.

    In the worker's text, "here" means the worker and "there" means the client. The result has the words "at the worker"
    and "at the client" instead.
    """
    return (differing or "").replace(" there", " at the client").replace(" here", " at the worker")
