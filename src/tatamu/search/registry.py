"""Searches by name. The module of a search is imported when the search is used for the first time."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from typing import Protocol

from tatamu.base.errors import InputError
from tatamu.search.search import Search
from tatamu.search.space import Parameters, Space


class MakeSearch(Protocol):
    """A callable that makes a search: a subclass of `Search`, or a function."""

    def __call__(self, space: Space, seed: int = 0, first: Sequence[Parameters] = ()) -> Search:
        """Return a search that first proposes the parameters in `first`."""
        ...


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
    """Add a search to the registry. After that, `LearnOptions(sampler=name)` uses it.

    Args:
        name: Name of the search.
        make: Callable that makes the search from a space, a seed and first parameters.

    Raises:
        InputError: If a search with this name exists.
    """
    if name in search_names():
        raise InputError(f"name: must be new, given {name!r}, which is a search already")
    _REGISTERED[name] = make


def check_search(name: str) -> None:
    """Check that a search exists.

    Raises:
        InputError: If no search has this name.
    """
    if name not in search_names():
        raise InputError(f"sampler: must be one of {', '.join(search_names())}, given {name!r}")


def find_search(name: str) -> MakeSearch:
    """Return the callable that makes a search.

    Raises:
        InputError: If no search has this name.
    """
    check_search(name)
    if name in _REGISTERED:
        return _REGISTERED[name]
    module, kind = _OWN[name].split(":")
    made: MakeSearch = getattr(import_module(f"tatamu.search.{module}"), kind)
    return made
