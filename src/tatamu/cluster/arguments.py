"""Arguments of calls: large ones go to the scheduler once, and from worker to worker from there.

They are results of calls themselves, so that the scheduler makes them again where every worker that held one is dead.
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
"""Arguments of more bytes than this are shared: a task is, a manipulation goes along with its call."""
KEPT = 256_000_000
"""Bytes that are kept on the workers for calls to come; calls that are away keep theirs beside these."""
PLAIN = (str, bytes, int, float, bool, type(None))
"""Types whose size needs no pickling."""


class SharedArguments:
    """The large arguments that are on the workers, those used last at the end."""

    def __init__(self, client: distributed.Client, kept: int = KEPT) -> None:
        self._client = client
        self._kept = kept
        self._sizes: OrderedDict[str, int] = OrderedDict()
        self._futures: dict[str, distributed.Future] = {}

    def replaced(self, value: Any) -> Any:
        """A value, or what stands for it where it is large: the same for equal ones."""
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
        """Forget those that were not used for longest, where there are too many."""
        while sum(self._sizes.values()) > self._kept and next(iter(self._sizes)) != used:
            oldest, _ = self._sizes.popitem(last=False)
            del self._futures[oldest]


def unbound(function: Callable[..., Any]) -> tuple[Callable[..., Any], tuple[Any, ...]]:
    """A function and its first arguments, where these are bound to it."""
    if isinstance(function, partial) and not function.keywords:
        inner, first = unbound(function.func)
        return inner, (*first, *function.args)
    owner = getattr(function, "__self__", None)
    if owner is not None and hasattr(type(owner), getattr(function, "__name__", "")):
        return getattr(type(owner), function.__name__), (owner,)
    return function, ()
