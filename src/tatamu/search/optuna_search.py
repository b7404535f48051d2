"""Optuna's samplers as searches. Only Optuna's public interface is used."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import optuna
from optuna.distributions import BaseDistribution, FloatDistribution, IntDistribution
from optuna.samplers import BaseSampler, RandomSampler, TPESampler
from optuna.trial import create_trial

from tatamu.search.search import Evaluated, Proposal, Search
from tatamu.search.space import Parameters, Space

optuna.logging.set_verbosity(optuna.logging.ERROR)


def distributions(space: Space) -> dict[str, BaseDistribution]:
    """Return the bounds of a space in Optuna's form."""
    return {
        name: IntDistribution(int(each.low), int(each.high)) if each.whole else FloatDistribution(each.low, each.high)
        for name, each in space.bounds.items()
    }


class OptunaSearch(Search):
    """Base of searches by a sampler of Optuna.

    Each proposal has its own sampler with its own seed, so that a resumed study makes the same proposals.
    """

    make_sampler: Callable[..., BaseSampler]
    """Optuna's sampler."""

    def __init__(self, space: Space, seed: int = 0, first: Sequence[Parameters] = ()) -> None:
        super().__init__(space, seed, first)
        self._distributions = distributions(space)
        self._study = optuna.create_study(direction="minimize")
        self._asked: dict[int, optuna.Trial] = {}
        self._trial: optuna.Trial | None = None

    def propose(self) -> tuple[Parameters, float | None]:
        self._study.sampler = self.make_sampler(seed=self.sub_seed())
        self._trial = self._study.ask(self._distributions)
        return dict(self._trial.params), None

    def ask(self) -> Proposal:
        self._trial = None
        proposal = super().ask()
        if self._trial is not None:
            self._asked[id(proposal)] = self._trial
        return proposal

    def tell(self, proposal: Mapping[str, int | float], found: Evaluated | float) -> None:
        super().tell(proposal, found)
        objective = self.told[-1].objective
        asked = self._asked.pop(id(proposal), None)
        if asked is not None:
            self._study.tell(asked, objective)
        else:
            self._study.add_trial(
                create_trial(value=objective, params=dict(proposal), distributions=self._distributions)
            )


class RandomSearch(OptunaSearch):
    """Search that draws every proposal at random from the whole space."""

    make_sampler = RandomSampler


class TPESearch(OptunaSearch):
    """Search with the tree-structured Parzen estimator (Bergstra et al. 2011)."""

    make_sampler = TPESampler
