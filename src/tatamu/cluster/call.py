"""The functions that run on workers and on the scheduler."""

from __future__ import annotations

import asyncio
import pickle
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from tatamu.cluster.versions import Versions, difference, processor, versions
from tatamu.errors import UnavailableError

RESTART_SECONDS = 20.0
"""How long a nanny may take to restart its worker."""


def unpacked(content: bytes) -> Any:
    """An argument that many calls share, as the worker keeps it."""
    return pickle.loads(content)


def checked_call(of_client: Versions, function: Callable[..., Any], *args: Any, **kwargs: Any) -> Any:
    """Call a function where tatamu and what it computes with are those of the client.

    Raises:
        UnavailableError: They are not: this worker came later than the check at the start.
    """
    if of_client != versions():
        differing = difference(of_client)
        raise UnavailableError(f"a worker has other versions than this client: {_turned(differing)}; make them equal")
    return function(*args, **kwargs)


def identify() -> tuple[Versions, str]:
    """The versions and the processor of a worker."""
    return dict(versions()), processor()


async def replace_worker(key: str, dask_scheduler: Any = None) -> str | None:
    """Restart the worker that has had a call for too long, or drop it; its calls run elsewhere.

    Runs on the scheduler.

    Args:
        key: Of the call.
        dask_scheduler: The scheduler.

    Returns:
        The worker's address; None: the call is on no worker.
    """
    from distributed.core import rpc

    state = dask_scheduler.tasks.get(key)
    worker = state.processing_on if state is not None else None
    if worker is None:
        return None
    address = str(worker.address)
    if worker.nanny:
        with suppress(OSError, asyncio.TimeoutError):
            async with rpc(worker.nanny, connection_args=dask_scheduler.connection_args) as nanny:
                await asyncio.wait_for(nanny.restart(timeout=RESTART_SECONDS, reason="tatamu: overdue"), RESTART_SECONDS)
    if dask_scheduler.workers.get(address) is worker:
        await dask_scheduler.remove_worker(address, stimulus_id=f"tatamu-overdue-{key}")
    return address


def _turned(differing: str | None) -> str:
    """`difference` as the client sees it."""
    return (differing or "").replace(" there", " at the client").replace(" here", " at the worker")
