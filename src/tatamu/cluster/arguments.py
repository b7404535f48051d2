"""Arguments of calls: large ones go to the scheduler once, and then from worker to worker.

Each large argument is the result of a separate call, so the scheduler can make it again if all workers that have it are
dead.
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
"""Size above which arguments are shared [bytes]. A task is larger and is shared; a manipulation is sent with its
call."""
KEPT = 256_000_000
"""Bytes of arguments kept on the workers for later calls, in addition to those of running calls."""
PLAIN = (str, bytes, int, float, bool, type(None))
"""Types whose size needs no pickling."""


class SharedArguments:
    """The large arguments that are on the workers, the most recently used at the end."""

    def __init__(self, client: distributed.Client, kept: int = KEPT) -> None:
        self._client = client
        self._kept = kept
        self._sizes: OrderedDict[str, int] = OrderedDict()
        self._futures: dict[str, distributed.Future] = {}

    def replaced(self, value: Any) -> Any:
        """Return the value, or the future that replaces it if it is large; equal values get the same future."""
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
        """Delete the least recently used arguments if they are too large in all."""
        while sum(self._sizes.values()) > self._kept and next(iter(self._sizes)) != used:
            oldest, _ = self._sizes.popitem(last=False)
            del self._futures[oldest]


def unbound(function: Callable[..., Any]) -> tuple[Callable[..., Any], tuple[Any, ...]]:
    """Return a function and the first arguments that are bound to it, if any."""
    if isinstance(function, partial) and not function.keywords:
        inner, first = unbound(function.func)
        return inner, (*first, *function.args)
    owner = getattr(function, "__self__", None)
    if owner is not None and hasattr(type(owner), getattr(function, "__name__", "")):
        return getattr(type(owner), function.__name__), (owner,)
    return function, ()
