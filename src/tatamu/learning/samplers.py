"""Samplers by name. Each trial gets a sampler of its own, seeded by study seed and trial number.

So what a trial proposes depends on the finished trials, the seed and its number only, not on how often the study was
interrupted.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np
from optuna.exceptions import ExperimentalWarning
from optuna.samplers import BaseSampler, GPSampler, RandomSampler, TPESampler

from tatamu.errors import InputError


def _gp(seed: int) -> BaseSampler:
    """Gaussian process with Matern 5/2 kernel, expected improvement, one random trial first, no noise (beta = 0)."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ExperimentalWarning)
        return GPSampler(seed=seed, n_startup_trials=1, deterministic_objective=True)


def _tpe(seed: int) -> BaseSampler:
    return TPESampler(seed=seed)


def _random(seed: int) -> BaseSampler:
    return RandomSampler(seed=seed)


SAMPLERS: dict[str, Callable[[int], BaseSampler]] = {"gp": _gp, "tpe": _tpe, "random": _random}
"""Name of each sampler and its maker from a seed."""


def make_sampler(name: str, seed: int, number: int) -> BaseSampler:
    """The sampler of one trial.

    Raises:
        InputError: There is no such sampler.
    """
    if name not in SAMPLERS:
        raise InputError(f"sampler: must be one of {', '.join(SAMPLERS)}, given {name!r}")
    return SAMPLERS[name](int(np.random.SeedSequence([seed, number]).generate_state(1)[0]))
