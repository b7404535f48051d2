"""Searches by name, imported when they are used for the first time."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from typing import Protocol

from tatamu.base.errors import InputError
from tatamu.search.search import Search
from tatamu.search.space import Parameters, Space


class MakeSearch(Protocol):
    """A callable that makes a search: a subclass of `Search`, or a function."""

    def __call__(self, space: Space, seed: int = 0, first: Sequence[Parameters] = ()) -> Search: ...


_OWN = {
    "gp": "gp:GPSearch",
    "tpe": "optuna_search:TPESearch",
    "cmaes": "cma:CMASearch",
    "random": "optuna_search:RandomSearch",
}
_REGISTERED: dict[str, MakeSearch] = {}


def search_names() -> list[str]:
    """Return the names of all searches."""
    return [*_OWN, *_REGISTERED]


def register_search(name: str, make: MakeSearch) -> None:
    """Add a search under a new name, for `LearnOptions(sampler=name)`."""
    if name in search_names():
        raise InputError(f"name: must be new, given the existing search {name!r}")
    _REGISTERED[name] = make


def check_search(name: str) -> None:
    """Raise InputError if no search has this name."""
    if name not in search_names():
        raise InputError(f"sampler: must be one of {', '.join(search_names())}, given {name!r}")


def find_search(name: str) -> MakeSearch:
    """Return the callable that makes a search."""
    check_search(name)
    if name in _REGISTERED:
        return _REGISTERED[name]
    module, kind = _OWN[name].split(":")
    made: MakeSearch = getattr(import_module(f"tatamu.search.{module}"), kind)
    return made
