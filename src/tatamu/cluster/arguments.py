"""Arguments of calls: large ones go to the scheduler once, and from worker to worker from there.

They are results of calls themselves, so that the scheduler makes them again where every worker that held one is dead.
"""

from __future__ import annotations

import weakref
from collections.abc import Callable
from functools import partial
from hashlib import sha256
from typing import Any

import cloudpickle
import distributed

from tatamu.cluster.call import unpacked

LARGE = 16_384
"""Arguments of more bytes than this are shared."""
PLAIN = (str, bytes, int, float, bool, type(None))
"""Types whose size needs no pickling."""


class SharedArguments:
    """The large arguments that are on the workers, while somebody here has them."""

    def __init__(self, client: distributed.Client) -> None:
        self._client = client
        self._by_object: dict[int, distributed.Future] = {}
        self._by_content: weakref.WeakValueDictionary[str, distributed.Future] = weakref.WeakValueDictionary()

    def replaced(self, value: Any) -> Any:
        """A value, or what stands for it where it is large."""
        if isinstance(value, PLAIN):
            return value
        if id(value) in self._by_object:
            return self._by_object[id(value)]
        content = cloudpickle.dumps(value)
        if len(content) < LARGE:
            return value
        shared = self._share(content)
        try:
            weakref.finalize(value, self._by_object.pop, id(value), None)
        except TypeError:  # lists, dicts: known by their content alone
            return shared
        self._by_object[id(value)] = shared
        return shared

    def _share(self, content: bytes) -> distributed.Future:
        key = f"tatamu-shared-{sha256(content).hexdigest()[:24]}"
        known = self._by_content.get(key)
        if known is not None and not known.cancelled():
            return known
        shared = self._client.submit(unpacked, content, key=key)
        self._by_content[key] = shared
        return shared


def unbound(function: Callable[..., Any]) -> tuple[Callable[..., Any], tuple[Any, ...]]:
    """A function and its first arguments, where these are bound to it."""
    if isinstance(function, partial) and not function.keywords:
        inner, first = unbound(function.func)
        return inner, (*first, *function.args)
    owner = getattr(function, "__self__", None)
    if owner is not None and hasattr(type(owner), getattr(function, "__name__", "")):
        return getattr(type(owner), function.__name__), (owner,)
    return function, ()
