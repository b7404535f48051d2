"""A search proposes points of a space (`ask`) and receives their values (`tell`).

A search uses only vectors of numbers. It does not depend on cloth or simulators, so it works for any objective:

    search = GPSearch(space, seed=0)
    x = search.ask()
    search.tell(x, objective(x))

A proposal depends only on the observations, the pending proposals, the seed and its own number. If the observations are
equal, a search makes equal proposals. An interrupted study therefore continues as if it had not been interrupted.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from tatamu.base.errors import InputError
from tatamu.search.space import Parameters, Space

LOW, HIGH = 0, 1
"""The two fidelities of an evaluation. At low fidelity, a cheaper model is evaluated instead of the model itself."""


@dataclass(frozen=True)
class Proposal(Mapping[str, int | float]):
    """Parameters that a search proposes. It is a mapping from the names of parameters to their values."""

    parameters: Parameters
    fidelity: int = HIGH
    """Fidelity at which the proposal is evaluated: `LOW` (a cheaper model) or `HIGH` (the model itself)."""
    gain: float | None = None
    """Expected improvement as a fraction of the best objective; None if the search does not estimate it."""

    def __getitem__(self, name: str) -> int | float:
        return self.parameters[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.parameters)

    def __len__(self) -> int:
        return len(self.parameters)


@dataclass(frozen=True)
class Observation:
    """The result of a proposal that was evaluated."""

    parameters: Parameters
    objective: float
    residuals: np.ndarray | None = None
    """Vector whose squares sum to the unknown part of the objective; None if the vector is not known."""


class Evaluated(Protocol):
    """The attributes of an evaluation that a search uses."""

    @property
    def objective(self) -> float:
        """The value that is minimised."""
        ...

    @property
    def residuals(self) -> np.ndarray | None:
        """Vector whose squares sum to the unknown part of the objective; None if the vector is not known."""
        ...


class Search(ABC):
    """Base class of all searches. It stores observations and pending proposals. Subclasses implement `propose`."""

    needs_residuals = False
    """Whether the search needs the residuals of an evaluation as well as its objective."""

    def __init__(self, space: Space, seed: int = 0, first: Sequence[Parameters] = ()) -> None:
        """Start a search.

        Args:
            space: Bounds of the parameters.
            seed: Random seed of the search.
            first: Parameters of the first proposals. Parameters that occur twice are proposed once. The proposal after
                them is random, because all first proposals may fail.
        """
        self.space = space
        self.seed = seed
        self.first = [dict(each) for number, each in enumerate(first) if each not in first[:number]]
        self.told: list[Observation] = []
        self.pending: list[Proposal] = []

    @property
    def number(self) -> int:
        """Number of the next proposal, from 0."""
        return len(self.told) + len(self.pending)

    @property
    def known(self) -> list[Observation]:
        """The observations on which the next proposal may depend."""
        return [] if self.number == len(self.first) else self.told

    @abstractmethod
    def propose(self) -> tuple[Parameters, float | None]:
        """Return the next parameters, and their expected improvement as a fraction of the best objective.

        The improvement is None if the search does not estimate it.
        """

    def ask(self, fidelity: int = HIGH) -> Proposal:
        """Return the next proposal. It stays pending until its result is reported with `tell`.

        Args:
            fidelity: Fidelity of the model that will be evaluated. A search with only one fidelity does not use this
                number, but the proposal contains it.
        """
        given = self.number < len(self.first)
        parameters, gain = (self.first[self.number], None) if given else self.propose()
        proposal = Proposal(dict(parameters), fidelity, gain)
        self.expect(proposal)
        return proposal

    def expect(self, proposal: Proposal) -> None:
        """Add a pending proposal, for example a proposal of an interrupted study."""
        self.pending.append(proposal)

    def tell(self, proposal: Mapping[str, int | float], found: Evaluated | float) -> None:
        """Report the result of a proposal.

        Args:
            proposal: A pending proposal, or any other parameters.
            found: An evaluation, or the value of its objective.

        Raises:
            InputError: If the objective is not finite.
        """
        self._settle(proposal)
        residuals = None if isinstance(found, int | float) or not self.needs_residuals else found.residuals
        objective = float(found) if isinstance(found, int | float) else found.objective
        if not np.isfinite(objective):
            raise InputError(f"objective: must be a finite number, given {objective}")
        self.told.append(Observation(dict(proposal), objective, residuals))

    def _settle(self, proposal: Mapping[str, int | float]) -> None:
        """Remove a proposal from the pending proposals, because its result is known."""
        for number, each in enumerate(self.pending):
            if each is proposal or each.parameters == dict(proposal):
                del self.pending[number]
                return

    def sub_seed(self) -> int:
        """Return the random seed for the next proposal."""
        return int(np.random.SeedSequence([self.seed, self.number]).generate_state(1)[0])
