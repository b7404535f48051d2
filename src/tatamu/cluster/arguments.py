"""Sends large arguments of calls to the workers only once.

The scheduler takes each of them for the result of a call, which it repeats if all workers that have it die.
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
"""Size above which an argument is shared [bytes]. A task is larger, a manipulation is smaller."""
KEPT = 256_000_000
"""Total size of the shared arguments that are kept for later calls [bytes]."""
PLAIN = (str, bytes, int, float, bool, type(None))
"""Types of arguments that are never shared."""


class SharedArguments:
    """The shared arguments, by their last use."""

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
            self._futures[key] = self._client.submit(unpacked, content, key=key)
        self._sizes[key] = len(content)
        self._sizes.move_to_end(key)
        self._forget(key)
        return self._futures[key]

    def _forget(self, used: str) -> None:
        """Forget arguments until the rest is small enough, but not the one in use."""
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
