"""Runs calls on the workers of a Dask scheduler, with the interface of `concurrent.futures.Executor`.

Calls wait in this process until workers are free. Each thread of a worker gets only two calls: the first call runs, and
the second call waits at the worker. This has three advantages. The thread does not wait for a message between two
calls. If a worker dies, only few calls are lost. The time since a call was sent is approximately the time for which the
call has run.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable
from concurrent.futures import Executor, Future
from itertools import count
from threading import RLock
from typing import Any
from uuid import uuid4

import distributed

from tatamu.base.errors import UnavailableError, WorkerKilledError
from tatamu.cluster.arguments import SharedArguments, unbound
from tatamu.cluster.call import checked_call
from tatamu.cluster.versions import versions
from tatamu.cluster.watch import Watch

CALLS_PER_THREAD = 2
"""Number of calls that are sent to each thread of the workers: one call runs, and one waits."""


class Call:
    """A call that was submitted to the executor."""

    def __init__(self, function: Callable[..., Any], args: tuple[Any, ...], kwargs: dict[str, Any]) -> None:
        self.function = function
        self.args = args
        self.kwargs = kwargs
        self.future: Future[Any] = Future()


class DaskExecutor(Executor):
    """Runs calls on the workers of a scheduler. If a worker dies, hangs or is slow, its calls run on other workers."""

    def __init__(self, client: distributed.Client, name: str, watch: Watch | None = None) -> None:
        """Make an executor.

        Args:
            client: Client of the scheduler.
            name: Name of the scheduler, for messages.
            watch: Object that finds calls that take too long; None for the default limits.
        """
        self._client = client
        self._loop: asyncio.AbstractEventLoop = client.loop.asyncio_loop  # type: ignore[union-attr]
        self._name = name
        self._shared = SharedArguments(client)
        self._waiting: deque[Call] = deque()
        self._away: dict[str, Call] = {}
        self._lock = RLock()
        self._closed = False
        self._numbers = count()
        self._prefix = f"tatamu-{uuid4().hex[:8]}"
        self._watch = watch or Watch()
        self._room = 1
        self._watch.start(client, self._set_threads)

    def submit(self, function: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Run a call on a worker. Arguments and result must be picklable. Large arguments are sent only once."""
        with self._lock:
            if self._closed:
                raise RuntimeError("the executor was shut down")
            plain, bound = unbound(function)
            call = Call(plain, (*bound, *args), kwargs)
            self._waiting.append(call)
        self._send()
        return call.future

    @property
    def threads(self) -> int:
        """Number of threads that the workers had at the last update; at least 1."""
        return self._watch.threads

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Accept no more calls. If `cancel_futures` is true, cancel all calls that have not ended."""
        with self._lock:
            self._closed = True
            calls = [*self._waiting, *self._away.values()]
            if cancel_futures:
                self._waiting.clear()
        if cancel_futures:
            for call in calls:
                call.future.cancel()
                _end(call.future, error=UnavailableError(f"{self._name}: the run was stopped"))
        elif wait:
            for call in calls:
                if not call.future.cancelled():
                    call.future.exception()
        self._watch.stop()

    def _set_threads(self, threads: int) -> None:
        self._room = CALLS_PER_THREAD * threads
        self._send()

    def _send(self) -> None:
        """Send waiting calls until each thread of the workers has CALLS_PER_THREAD calls, or no call waits."""
        with self._lock:
            while self._waiting and len(self._away) < self._room:
                call = self._waiting.popleft()
                if call.future.set_running_or_notify_cancel():
                    self._send_one(call)

    def _send_one(self, call: Call) -> None:
        key = f"{self._prefix}-{next(self._numbers)}"
        try:
            args = [self._shared.replaced(value) for value in call.args]
            kwargs = {name: self._shared.replaced(value) for name, value in call.kwargs.items()}
            sent = self._client.submit(
                checked_call, dict(versions()), call.function, *args, **kwargs, key=key, pure=False
            )
        except Exception as error:  # an argument cannot be pickled, or the client is closed
            _end(call.future, error=error)
            return
        self._away[key] = call
        self._watch.sent(key)
        asyncio.run_coroutine_threadsafe(self._receive(key, sent), self._loop)

    async def _receive(self, key: str, sent: distributed.Future) -> None:
        """Wait for the result of a call, and give it to the caller. This runs in the event loop of the client."""
        try:
            result = await sent
        except distributed.scheduler.KilledWorker as error:
            count = error.allowed_failures + 1
            outcome: dict[str, Any] = {"error": WorkerKilledError(f"killed {count} workers, or kept them too long")}
        except (asyncio.CancelledError, distributed.client.FutureCancelledError):
            lost = UnavailableError(
                f"{self._name}: the connection was lost; what was finished is kept, run the same command again"
            )
            outcome = {"error": lost}
        except Exception as error:
            outcome = {"error": error}
        else:
            outcome = {"result": result}
        sent.release()
        with self._lock:
            call = self._away.pop(key)
            call.args = ()  # allows large arguments to be freed
        self._watch.ended(key)
        self._loop.run_in_executor(None, self._hand_over, call, outcome)

    def _hand_over(self, call: Call, outcome: dict[str, Any]) -> None:
        """Send the next waiting call, and then give the result of `call` to its caller."""
        self._send()
        _end(call.future, **outcome)


def _end(future: Future[Any], result: Any = None, error: BaseException | None = None) -> None:
    """Set the result or the error of a future. Do nothing if the future has ended already."""
    if future.done():
        return
    if error is not None:
        future.set_exception(error)
    else:
        future.set_result(result)
