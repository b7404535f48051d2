"""Runs calls on the workers of a Dask scheduler, with the interface of `concurrent.futures.Executor`.

Dask's own executor sends the calls, and Dask's scheduler keeps them until a worker is free.
"""

from __future__ import annotations

import pickle
from collections import OrderedDict
from collections.abc import Callable
from concurrent.futures import Executor, Future
from hashlib import sha256
from threading import Lock
from typing import Any
from weakref import WeakSet, ref

import cloudpickle
import distributed

from tatamu.base.errors import UnavailableError, WorkerKilledError
from tatamu.cluster.versions import checked_call, versions
from tatamu.cluster.watch import Watch

LARGE = 65_536
"""Size above which an argument is shared [bytes]. A task is larger, a manipulation is smaller."""
KEPT = 256_000_000
"""Total size of the shared arguments that are kept for later calls [bytes]."""
PLAIN = (str, bytes, int, float, bool, type(None))
"""Types of arguments that are never shared."""


class SharedArguments:
    """Large arguments of calls, by their last use, which are sent to the workers only once.

    The scheduler takes each of them for the result of a call, which it repeats if all workers that have it die.
    """

    def __init__(self, client: distributed.Client, kept: int = KEPT) -> None:
        self._client = client
        self._kept = kept
        self._sizes: OrderedDict[str, int] = OrderedDict()
        self._futures: dict[str, distributed.Future] = {}

    def replaced(self, value: Any) -> Any:
        """Return a small value unchanged, and for a large one a Dask future, equal for equal values."""
        if isinstance(value, PLAIN):
            return value
        content = cloudpickle.dumps(value)
        if len(content) < LARGE:
            return value
        key = f"tatamu-shared-{sha256(content).hexdigest()[:24]}"
        if key not in self._futures or self._futures[key].cancelled():
            self._futures[key] = self._client.submit(pickle.loads, content, key=key)  # the worker keeps the result
        self._sizes[key] = len(content)
        self._sizes.move_to_end(key)
        while sum(self._sizes.values()) > self._kept and next(iter(self._sizes)) != key:  # the one in use stays
            oldest, _ = self._sizes.popitem(last=False)
            del self._futures[oldest]
        return self._futures[key]


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
        self._name = name
        self._shared = SharedArguments(client)
        self._calls = client.get_executor(pure=False)
        self._answers: WeakSet[Future[Any]] = WeakSet()
        self._lock = Lock()
        self._watch = watch or Watch()
        self._watch.start(client)

    def submit(self, function: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Run a call on a worker. Arguments and result must be picklable.

        Large arguments, and a method with the large object that it is bound to, are sent only once.
        """
        answer: Future[Any] = Future()
        with self._lock:
            positional = [self._shared.replaced(value) for value in (function, *args)]
            named = {name: self._shared.replaced(value) for name, value in kwargs.items()}
            sent = self._calls.submit(checked_call, dict(versions()), *positional, **named)
            self._answers.add(answer)
        still_sent = ref(sent)  # otherwise the caller's future would keep the result on the worker

        def cancel(ended: Future[Any]) -> None:
            if ended.cancelled() and (call := still_sent()) is not None:
                call.cancel()

        answer.add_done_callback(cancel)
        loop: Any = self._client.loop.asyncio_loop  # type: ignore[union-attr]
        # in a thread, because the caller's callbacks would keep Dask's event loop from its work
        sent.add_done_callback(lambda ended: loop.run_in_executor(None, self._answer, answer, ended))
        return answer

    @property
    def threads(self) -> int:
        """Number of threads that the workers had at the last update; at least 1."""
        return self._watch.threads

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Accept no more calls. If `cancel_futures` is true, end all calls with an error."""
        self._calls.shutdown(wait=wait and not cancel_futures)
        if cancel_futures:
            for answer in list(self._answers):
                self._end(answer, error=UnavailableError(f"{self._name}: the run was stopped"))
        self._watch.stop()

    def _answer(self, answer: Future[Any], ended: Future[tuple[float, Any]]) -> None:
        """Give the result or the error of a call to the caller."""
        if ended.cancelled():
            kept = "finished work is kept, so run the same command again"
            self._end(answer, error=UnavailableError(f"{self._name}: the connection was lost; {kept}"))
            return
        error = ended.exception()
        if isinstance(error, distributed.scheduler.KilledWorker):
            error = WorkerKilledError(
                f"the simulation killed {error.allowed_failures + 1} workers, which crashed or took too long"
            )
        if error is not None:
            if error.__traceback__ is not None:  # its first frame would keep the call at the scheduler
                error = error.with_traceback(error.__traceback__.tb_next)
            self._end(answer, error=error)
            return
        seconds, result = ended.result()
        self._watch.ended(seconds)
        self._end(answer, result=result)

    def _end(self, answer: Future[Any], result: Any = None, error: BaseException | None = None) -> None:
        with self._lock:
            if answer.done() or not answer.set_running_or_notify_cancel():
                return
        if error is not None:
            answer.set_exception(error)
        else:
            answer.set_result(result)
