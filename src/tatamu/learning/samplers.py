"""Samplers by name. Each trial gets a sampler of its own, seeded by study seed and trial number.

So what a trial proposes depends on the finished trials, the seed and its number only, not on how often the study was
interrupted.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from optuna.samplers import BaseSampler, RandomSampler, TPESampler

from tatamu.errors import InputError
from tatamu.learning.cma_es import EvolutionSampler
from tatamu.learning.gp_sampler import GaussianProcessSampler, KnownPart
from tatamu.learning.lm_sampler import LevenbergMarquardtSampler


def _gp(seed: int, known: KnownPart) -> BaseSampler:
    return GaussianProcessSampler(seed, known)


def _tpe(seed: int, known: KnownPart) -> BaseSampler:
    return TPESampler(seed=seed)


def _random(seed: int, known: KnownPart) -> BaseSampler:
    return RandomSampler(seed=seed)


def _cmaes(seed: int, known: KnownPart) -> BaseSampler:
    return EvolutionSampler(seed)


def _lm(seed: int, known: KnownPart) -> BaseSampler:
    return LevenbergMarquardtSampler(known)


SAMPLERS: dict[str, Callable[[int, KnownPart], BaseSampler]] = {
    "gp": _gp,
    "tpe": _tpe,
    "cmaes": _cmaes,
    "lm": _lm,
    "random": _random,
}
"""Name of each sampler and its maker, from a seed and the known part of the objective."""
OVER_ERRORS = frozenset({"lm"})
"""Those that need the errors e_i of finished trials, `lm_sampler.ERRORS`, beside their objective."""


def check_sampler(name: str) -> None:
    """Refuse a sampler that there is not."""
    if name not in SAMPLERS:
        raise InputError(f"sampler: must be one of {', '.join(SAMPLERS)}, given {name!r}")


def make_sampler(name: str, seed: int, number: int, known: KnownPart) -> BaseSampler:
    """The sampler of one trial.

    Args:
        name: Of the sampler.
        seed: Of the study.
        number: Of the trial.
        known: The part of the objective that is known before a trial runs.

    Raises:
        InputError: There is no such sampler.
    """
    check_sampler(name)
    return SAMPLERS[name](int(np.random.SeedSequence([seed, number]).generate_state(1)[0]), known)
