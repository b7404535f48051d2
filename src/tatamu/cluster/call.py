"""The functions that run on workers and on the scheduler."""

from __future__ import annotations

import asyncio
import pickle
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any

from tatamu.cluster.versions import Versions, difference, processor, versions
from tatamu.errors import UnavailableError

RESTART_SECONDS = 20.0
"""Longest time in which a nanny must restart its worker [s]."""


def unpacked(content: bytes) -> Any:
    """Return an argument that many calls share, as the worker keeps it."""
    return pickle.loads(content)


def checked_call(of_client: Versions, function: Callable[..., Any], *args: Any, **kwargs: Any) -> Any:
    """Call a function if tatamu and the packages that compute have the client's versions.

    Raises:
        UnavailableError: If a version differs; the worker then joined after the check at the start.
    """
    if of_client != versions():
        differing = difference(of_client)
        raise UnavailableError(f"a worker has other versions than this client: {_turned(differing)}; make them equal")
    return function(*args, **kwargs)


def identify() -> tuple[Versions, str]:
    """Return the versions and the processor of a worker."""
    return dict(versions()), processor()


async def replace_workers(keys: Sequence[str], dask_scheduler: Any = None) -> None:
    """Restart the workers whose calls take too long, or drop them; their calls run elsewhere.

    This function runs on the scheduler.

    Args:
        keys: Keys of the calls.
        dask_scheduler: The scheduler.
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
    """Return `difference` as seen by the client."""
    return (differing or "").replace(" there", " at the client").replace(" here", " at the worker")
