"""Optuna's samplers as searches. Only Optuna's public interface is used."""

from __future__ import annotations

from collections.abc import Callable

import optuna
from optuna.distributions import BaseDistribution, FloatDistribution, IntDistribution
from optuna.samplers import BaseSampler, RandomSampler, TPESampler
from optuna.trial import create_trial

from tatamu.search.search import Search
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

    Each proposal has its own sampler, with its own seed and all results in the order in which they were reported, so
    that a resumed study makes the same proposals.
    """

    make_sampler: Callable[..., BaseSampler]
    """Optuna's sampler."""

    def propose(self) -> tuple[Parameters, float | None]:
        bounds = distributions(self.space)
        study = optuna.create_study(sampler=self.make_sampler(seed=self.sub_seed()))
        study.add_trials(
            create_trial(value=each.objective, params=each.parameters, distributions=bounds) for each in self.known
        )
        return dict(study.ask(bounds).params), None


class RandomSearch(OptunaSearch):
    """Search that draws every proposal at random from the whole space."""

    make_sampler = RandomSampler


class TPESearch(OptunaSearch):
    """Search with the tree-structured Parzen estimator (Bergstra et al. 2011)."""

    make_sampler = TPESampler
