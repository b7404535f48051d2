"""Searches by name; a module is imported when its search is first made."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from typing import Protocol

from tatamu.errors import InputError
from tatamu.search.search import Search
from tatamu.search.space import Parameters, Space


class MakeSearch(Protocol):
    """Makes a search: a subclass of `Search`, or a function."""

    def __call__(self, space: Space, seed: int = 0, first: Sequence[Parameters] = ()) -> Search:
        """Return a search of `space` with a random seed, whose first proposals are `first`."""
        ...


_OWN = {"gp": "gp:GPSearch", "tpe": "optuna_search:TPESearch", "cmaes": "cma:CMASearch", "lm": "lm:LMSearch",
        "random": "optuna_search:RandomSearch"}  # fmt: skip
_REGISTERED: dict[str, MakeSearch] = {}


def search_names() -> list[str]:
    """Return the names of all searches."""
    return [*_OWN, *_REGISTERED]


def register_search(name: str, make: MakeSearch) -> None:
    """Add a search, so that `LearnOptions(sampler=name)` uses it.

    Args:
        name: Name of the search.
        make: Makes it from a space, a seed and first parameters.

    Raises:
        InputError: If a search of that name exists.
    """
    if name in search_names():
        raise InputError(f"name: must be new, given {name!r}, which is a search already")
    _REGISTERED[name] = make


def check_search(name: str) -> None:
    """Refuse an unknown search.

    Raises:
        InputError: If no search has that name.
    """
    if name not in search_names():
        raise InputError(f"sampler: must be one of {', '.join(search_names())}, given {name!r}")


def find_search(name: str) -> MakeSearch:
    """Return the maker of a search.

    Raises:
        InputError: If no search has that name.
    """
    check_search(name)
    if name in _REGISTERED:
        return _REGISTERED[name]
    module, kind = _OWN[name].split(":")
    made: MakeSearch = getattr(import_module(f"tatamu.search.{module}"), kind)
    return made
