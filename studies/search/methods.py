"""The searches that are compared, by name."""

from __future__ import annotations

import importlib.util
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import log
from typing import Any

import numpy as np
import optuna
from optuna.samplers import BaseSampler, GPSampler, RandomSampler, TPESampler
from optuna.trial import FrozenTrial, create_trial
from scipy.stats import qmc
from studies.search.settings import Setting, Simulated
from tatamu.learning.cma_es import EvolutionSampler
from tatamu.learning.gp_sampler import GaussianProcessSampler
from tatamu.learning.lm_sampler import ERRORS, LevenbergMarquardtSampler, packed
from tatamu.learning.space import Grasps, first_curves, low_curves
from tatamu.learning.unit_cube import UnitCube
from tatamu.results.result import Parameters

from tatamu.curves import sampled_bezier
from tatamu.folding.fold import Fold
from tatamu.folding.manipulation import Manipulation

FEW, MANY = 50, 134
"""Simulations of a sequential search, and of those that need or bear more."""
FAR = 2.0
"""Objective over span beyond which GPSampler gets one equal value."""

Proposing = Callable[[Setting, int, int, Sequence[tuple[Any, Simulated]]], tuple[Any, Manipulation]]
"""From setting, seed, number of the trial and the trials before it (parameters, simulation) to parameters and the
manipulation that they mean."""


@dataclass(frozen=True)
class Method:
    """A way to search."""

    title: str
    propose: Proposing
    trials: int = FEW
    """How many simulations it is given at most."""
    seeds: int | None = None
    """Number of seeds; None for the number of the command."""
    needs: tuple[str, ...] = field(default=())
    """Modules without which it is left out."""

    @property
    def possible(self) -> bool:
        """Whether all that it needs is there."""
        return all(importlib.util.find_spec(module) for module in self.needs)


def trial_seed(seed: int, number: int) -> int:
    """The seed of one trial's sampler, as in `tatamu.learning.samplers`."""
    return int(np.random.SeedSequence([seed, number]).generate_state(1)[0])


def by_optuna(
    make: Callable[[Setting, int], BaseSampler],
    grasps: Grasps = "integer",
    seen: Callable[[Setting, Sequence[float]], list[float]] = lambda _, objectives: list(objectives),
) -> Proposing:
    """A search by an Optuna sampler, each trial with a sampler of its own as in `tatamu learn`.

    Args:
        make: The sampler, of a setting and a seed.
        grasps: Whole numbers, or real numbers that are floored.
        seen: Objectives as the sampler is given them.
    """

    def propose(
        setting: Setting, seed: int, number: int, before: Sequence[tuple[Any, Simulated]]
    ) -> tuple[Any, Manipulation]:
        space = setting.spaces[grasps]
        study = optuna.create_study(sampler=make(setting, trial_seed(seed, number)), direction="minimize")
        values = seen(setting, [simulated.objective for _, simulated in before])
        study.add_trials(_finished(space, before, values))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            parameters = dict(study.ask(space).params)
        return parameters, setting.task.manipulation(parameters)

    return propose


def _finished(space: dict[str, Any], before: Sequence[tuple[Any, Simulated]], values: list[float]) -> list[FrozenTrial]:
    return [
        create_trial(
            value=value,
            params=parameters,
            distributions=space,
            system_attrs={} if simulated.errors is None else {ERRORS: packed(simulated.errors)},
        )
        for (parameters, simulated), value in zip(before, values, strict=True)
    ]


def logarithms(setting: Setting, objectives: Sequence[float]) -> list[float]:
    """Return log(C / span - 1), equal for all bad trials, which Optuna's GPSampler got while it was the default."""
    excess = [max(objective / setting.fold.span - 1.0, 1e-6) for objective in objectives]
    bad = max(1.0, FAR * min(excess, default=0.0))
    return [log(min(each, bad)) for each in excess]


def sobol(setting: Setting, seed: int, number: int, before: Sequence[Any]) -> tuple[Any, Manipulation]:
    """A scrambled Sobol' sequence."""
    cube = UnitCube(setting.spaces["integer"])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that 134 is no power of two
        points = qmc.Sobol(cube.dimensions, scramble=True, rng=np.random.default_rng(seed)).random(MANY)
    parameters = cube.parameters(cube.snapped(points[number : number + 1])[0])
    return parameters, setting.task.manipulation(parameters)


def grid(setting: Setting, seed: int, number: int, before: Sequence[Any]) -> tuple[Any, Manipulation]:
    """The grid of De Gusseme and wyffels (2022), in an order drawn by the seed.

    A quadratic Bezier curve whose middle control point lies height times the span over the middle, turned about the
    line from grasp to release by a tilt: 14 heights from 0.1 to 1, and the more tilts from 0 to 60 degrees the higher.
    Both hands lean to the same side; they grasp the corners.
    """
    points = [
        (height, tilt)
        for height in np.linspace(0.1, 1.0, 14)
        for tilt in np.linspace(0.0, np.pi / 3.0, max(2, int(18 * height)))
    ]
    assert len(points) == MANY
    height, tilt = points[np.random.default_rng(seed).permutation(MANY)[number]]
    fold = setting.fold
    grasps = tuple(int(hand[0]) for hand in (fold.left, fold.right)[: fold.hands])
    curves = []
    for vertex in grasps:
        release = fold.translation(vertex)
        lean = np.array([-fold.normal[1], fold.normal[0], 0.0]) * np.sin(tilt) + np.array([0.0, 0.0, np.cos(tilt)])
        middle = 0.5 * release + height * fold.span_of(vertex) * lean
        curves.append(np.stack([np.zeros(3), 2.0 / 3.0 * middle, (release + 2.0 * middle) / 3.0, release]))
    places = tuple(fold.start[vertex] for vertex in grasps)
    manipulation = Manipulation(grasps, places, tuple(map(sampled_bezier, curves)), tuple(curves))
    return {"height": float(height), "tilt": float(tilt)}, manipulation


_gaussian_process = by_optuna(lambda setting, seed: GaussianProcessSampler(seed, setting.lengths))


def after_curves(curves: Callable[[Fold], list[Parameters]], random_trial: bool) -> Proposing:
    """Some curves, a random trial if it is wanted, then the Gaussian process."""

    def propose(
        setting: Setting, seed: int, number: int, before: Sequence[tuple[Any, Simulated]]
    ) -> tuple[Any, Manipulation]:
        first = curves(setting.fold)
        if number < len(first):
            return first[number], setting.task.manipulation(first[number])
        at_random = random_trial and number == len(first)
        return _gaussian_process(setting, seed, number, [] if at_random else before)

    return propose


METHODS: dict[str, Method] = {
    "ours": Method(
        "ours: two arched and three low curves, a random trial, `gp`", after_curves(first_curves, random_trial=True)
    ),
    "low": Method("three low curves, then `gp` at once", after_curves(low_curves, random_trial=False), seeds=2),
    "gp": Method("`--sampler gp` from a random trial", _gaussian_process),
    "plain": Method(
        "the paper's: C itself, floored grasps",
        by_optuna(lambda setting, seed: GaussianProcessSampler(seed), grasps="continuous"),
    ),
    "gpsampler": Method(
        "Optuna's `GPSampler`, told log(C / span - 1)",
        by_optuna(
            lambda setting, seed: GPSampler(seed=seed, n_startup_trials=1, deterministic_objective=True),
            seen=logarithms,
        ),
        needs=("torch",),
    ),
    "tpe": Method("tree of Parzen estimators: `--sampler tpe`", by_optuna(lambda _, seed: TPESampler(seed=seed))),
    "cmaes": Method("CMA-ES: `--sampler cmaes`", by_optuna(lambda _, seed: EvolutionSampler(seed))),
    "lm": Method(
        "Li et al. (2015): `--sampler lm`",
        by_optuna(lambda setting, _: LevenbergMarquardtSampler(setting.lengths)),
        trials=MANY,
        seeds=1,
    ),
    "grid": Method("grid of De Gusseme and wyffels (2022)", grid, trials=MANY),
    "sobol": Method("Sobol' sequence", sobol, trials=MANY),
    "random": Method("random: `--sampler random`", by_optuna(lambda _, seed: RandomSampler(seed=seed)), trials=MANY),
}
"""Ways to search by name, in the order of the tables."""
CORE = ("ours", "plain", "random")
"""Those that the page's first question is about."""
OURS = ("ours", "low", "gp")
"""Forms of our own search."""
PAIR = ("gp", "gpsampler")
"""Two that are compared over more seeds."""
