"""Sends the arguments of calls to workers. A large argument is sent only once, and then passed from worker to worker.

The scheduler treats each large argument as the result of a separate call. If all workers that have the argument die,
the scheduler repeats this call.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from functools import partial
from hashlib import sha256
from typing import Any

import cloudpickle
import distributed

from tatamu.cluster.call import unpacked

LARGE = 65_536
"""Size above which an argument is sent only once and shared by calls [bytes].

The data of a folding task are larger than this size, so they are sent only once. A manipulation, the planned motion of
the hands, is smaller and is sent with each call.
"""
KEPT = 256_000_000
"""Largest total size of the shared arguments that are kept on the workers for later calls [bytes]. An argument that is
in use is always kept."""
PLAIN = (str, bytes, int, float, bool, type(None))
"""Types of arguments that are sent with each call, and are never shared by calls."""


class SharedArguments:
    """The large arguments that are stored on the workers.

    They are sorted by their last use, the least recently used first.
    """

    def __init__(self, client: distributed.Client, kept: int = KEPT) -> None:
        self._client = client
        self._kept = kept
        self._sizes: OrderedDict[str, int] = OrderedDict()
        self._futures: dict[str, distributed.Future] = {}

    def replaced(self, value: Any) -> Any:
        """Return a small value unchanged. For a large value, return a Dask future that stands for the stored value.

        Equal values get the same future.
        """
        if isinstance(value, PLAIN):
            return value
        content = cloudpickle.dumps(value)
        if len(content) < LARGE:
            return value
        key = f"tatamu-shared-{sha256(content).hexdigest()[:24]}"
        if key not in self._futures or self._futures[key].cancelled():
            self._futures[key] = self._client.submit(unpacked, content, key=key)
        self._sizes[key] = len(content)
        self._sizes.move_to_end(key)
        self._forget(key)
        return self._futures[key]

    def _forget(self, used: str) -> None:
        """Delete the least recently used arguments until the total size is small enough.

        The argument with the key `used` is kept.
        """
        while sum(self._sizes.values()) > self._kept and next(iter(self._sizes)) != used:
            oldest, _ = self._sizes.popitem(last=False)
            del self._futures[oldest]


def unbound(function: Callable[..., Any]) -> tuple[Callable[..., Any], tuple[Any, ...]]:
    """Split a `partial` or a bound method into a plain function and the arguments that are bound to it."""
    if isinstance(function, partial) and not function.keywords:
        inner, first = unbound(function.func)
        return inner, (*first, *function.args)
    owner = getattr(function, "__self__", None)
    if owner is not None and hasattr(type(owner), getattr(function, "__name__", "")):
        return getattr(type(owner), function.__name__), (owner,)
    return function, ()
