"""The base of searches, what passes between a search and the trials, and searches by name."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Protocol

import numpy as np

from tatamu.base.errors import InputError
from tatamu.search.space import Parameters, Space


class Proposal(Parameters):
    """Parameters that a search proposes."""

    def __init__(self, parameters: Mapping[str, int | float], gain: float | None = None) -> None:
        super().__init__(parameters)
        self.gain = gain
        """Expected improvement, as a fraction of the lowest objective; None if the search does not estimate it."""


@dataclass(frozen=True)
class Observation:
    """Parameters and their objective."""

    parameters: Parameters
    objective: float


class Evaluated(Protocol):
    """A result of a trial."""

    @property
    def objective(self) -> float:
        """The value that the search minimises."""
        ...


class Search(ABC):
    """Proposes parameters.

    A proposal depends only on the reported results, the pending proposals, the seed and how many proposals there were.
    A resumed study therefore makes the same proposals again.
    """

    def __init__(self, space: Space, seed: int = 0, first: Sequence[Parameters] = ()) -> None:
        """Start a search that first proposes the parameters in `first`, in this order, repeated ones once."""
        self.space = space
        self.seed = seed
        self.first = [dict(each) for index, each in enumerate(first) if each not in first[:index]]
        self.told: list[Observation] = []
        self.pending: list[Proposal] = []

    @property
    def count(self) -> int:
        return len(self.told) + len(self.pending)

    @property
    def known(self) -> list[Observation]:
        """Results on which a proposal may depend: none for the first own one, so it waits for no given ones."""
        return [] if self.count == len(self.first) else self.told

    @abstractmethod
    def propose(self) -> tuple[Parameters, float | None]:
        """Return the next parameters and their expected improvement, as a fraction of the lowest objective, or None."""

    def ask(self) -> Proposal:
        """Return the next proposal. It is pending until its result is reported with `tell`."""
        given = self.count < len(self.first)
        proposal = Proposal(self.first[self.count]) if given else Proposal(*self.propose())
        self.expect(proposal)
        return proposal

    def expect(self, proposal: Proposal) -> None:
        """Add a pending proposal, for example one of an interrupted study."""
        self.pending.append(proposal)

    def tell(self, proposal: Mapping[str, int | float], found: Evaluated | float) -> None:
        """Report the result, a finite number, of a proposal, or of parameters that were not proposed."""
        objective = float(found) if isinstance(found, int | float) else found.objective
        if not np.isfinite(objective):
            raise InputError(f"objective: must be a finite number, given {objective}")
        index = next((index for index, each in enumerate(self.pending) if each is proposal), None)
        if index is None:
            index = next((index for index, each in enumerate(self.pending) if each == dict(proposal)), None)
        if index is not None:
            del self.pending[index]
        self.told.append(Observation(dict(proposal), objective))

    def sub_seed(self) -> int:
        return int(np.random.SeedSequence([self.seed, self.count]).generate_state(1)[0])


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
        raise InputError(f"name: must be new, but there is already a search {name!r}")
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
