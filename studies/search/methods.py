"""Defines the search methods that are compared, by name."""

from __future__ import annotations

import importlib.util
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from math import log
from typing import Any

import numpy as np
from optuna.samplers import BaseSampler, GPSampler
from scipy.stats import qmc
from studies.search.settings import Setting, Simulated

from tatamu import GPSearch, Manipulation, Search
from tatamu.base.curves import sampled_bezier
from tatamu.folding.parameters import first_curves, low_curves
from tatamu.search.cma import CMASearch
from tatamu.search.lm import LMSearch
from tatamu.search.optuna_search import OptunaSearch, RandomSearch, TPESearch

FEW, MANY = 50, 134
"""Number of trials that most search methods get, and number for methods that need more trials."""
FAR = 2.0
"""Factor that decides which trials the function `logarithms` treats as bad.

The excess of a trial is C / span - 1. A trial is bad if its excess is above 1, and also above this factor times the
lowest excess of all trials.
"""

Proposing = Callable[[Setting, int, int, Sequence[tuple[Any, Simulated]]], tuple[Any, Manipulation]]
"""Function that proposes a trial. It gets the setting, the seed, the number of the trial and all earlier trials. It
returns the parameters of the trial and the manipulation, the motion of the hands."""


@dataclass(frozen=True)
class Method:
    """A search method, with the number of trials that it gets."""

    title: str
    propose: Proposing
    trials: int = FEW
    """Largest number of trials of a study with this method."""
    seeds: int | None = None
    """Number of random seeds of this method; None for the number that the user gives."""
    needs: tuple[str, ...] = field(default=())
    """Names of Python modules that the search method needs. If a module is missing, the method is left out."""

    @property
    def possible(self) -> bool:
        """Whether all modules that the search method needs are installed."""
        return all(importlib.util.find_spec(module) for module in self.needs)


class GPSamplerSearch(OptunaSearch):
    """A search with Optuna's Gaussian process, the GPSampler."""

    def make_sampler(self, seed: int) -> BaseSampler:
        """Return an Optuna sampler, which is used for one proposal of a trial."""
        return GPSampler(seed=seed, n_startup_trials=1, deterministic_objective=True)


def by_search(
    make: Callable[[Setting, int], Search],
    seen: Callable[[Setting, Sequence[float]], Sequence[float]] | None = None,
) -> Proposing:
    """Return a function that proposes trials with a search of tatamu.

    For each proposal, a new search is made, and all earlier trials are given to it.

    Args:
        make: Function that makes the search from a setting and a seed.
        seen: Function that converts the objectives for the search; None to give the objectives unchanged.
    """

    def propose(
        setting: Setting, seed: int, number: int, before: Sequence[tuple[Any, Simulated]]
    ) -> tuple[Any, Manipulation]:
        search = make(setting, seed)
        told: Sequence[Any] = [simulated for _, simulated in before]
        if seen is not None:
            told = seen(setting, [simulated.objective for simulated in told])
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            for (parameters, _), found in zip(before, told, strict=True):
                search.tell(parameters, found)
            parameters = dict(search.ask())
        return parameters, setting.task.manipulation(parameters)

    return propose


def logarithms(setting: Setting, objectives: Sequence[float]) -> list[float]:
    """Return log(C / span - 1) for the objective C of each trial. All bad trials get the same value.

    The span is the horizontal distance that a hand moves. Optuna's GPSampler was given these values when it was
    tatamu's default search.
    """
    excess = [max(objective / setting.fold.span - 1.0, 1e-6) for objective in objectives]
    bad = max(1.0, FAR * min(excess, default=0.0))
    return [log(min(each, bad)) for each in excess]


def sobol(setting: Setting, seed: int, number: int, before: Sequence[Any]) -> tuple[Any, Manipulation]:
    """Propose a trial: the next point of a scrambled Sobol' sequence in the search space."""
    space = setting.spaces["integer"]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about 134, which is no power of two
        points = qmc.Sobol(space.dimensions, scramble=True, rng=np.random.default_rng(seed)).random(MANY)
    parameters = space.parameters(space.snap(points[number : number + 1])[0])
    return parameters, setting.task.manipulation(parameters)


def grid(setting: Setting, seed: int, number: int, before: Sequence[Any]) -> tuple[Any, Manipulation]:
    """Propose a trial from the grid of De Gusseme and wyffels (2022), in a random order.

    Each path is a quadratic Bezier curve whose middle control point is above the middle of the path. A span is the
    horizontal distance that a hand moves. The grid has 14 heights of the middle control point, from 0.1 to 1 spans. The
    curve is tilted about the line from grasp to release by 0 to 60 degrees. For higher curves, the grid has more tilts.
    Both hands tilt to the same side, and grasp the corners.
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
    patches = tuple(tuple(fold.patch(vertex)) for vertex in grasps)
    paths = tuple(map(sampled_bezier, curves))
    manipulation = Manipulation(grasps, places, paths, tuple(curves), fold.fingers.lift, patches=patches)
    return {"height": float(height), "tilt": float(tilt)}, manipulation


def after_low_curves(setting: Setting, seed: int, number: int, before: Sequence[Any]) -> tuple[Any, Manipulation]:
    """Propose a trial of a search that starts with low curves of the hands, without a random trial.

    After the low curves, the Gaussian process proposes the trials.
    """
    curves = low_curves(setting.fold)
    if number >= len(curves):
        return _gp(setting, seed, number, before)
    return curves[number], setting.task.manipulation(curves[number])


_gp = by_search(lambda setting, seed: GPSearch(setting.spaces["integer"], seed))

METHODS: dict[str, Method] = {
    "ours": Method(
        "ours: two arched and three low curves, a random trial, `gp`",
        by_search(lambda setting, seed: GPSearch(setting.spaces["integer"], seed, first_curves(setting.fold))),
    ),
    "low": Method("three low curves, then `gp` at once", after_low_curves, seeds=2),
    "gp": Method("`--sampler gp` from a random trial", _gp),
    "plain": Method(
        "the paper's: C itself, floored grasps",
        by_search(lambda setting, seed: GPSearch(replace(setting.spaces["continuous"], known_part=None), seed)),
    ),
    "gpsampler": Method(
        "Optuna's `GPSampler`, told log(C / span - 1)",
        by_search(lambda setting, seed: GPSamplerSearch(setting.spaces["integer"], seed), seen=logarithms),
        needs=("torch",),
    ),
    "tpe": Method(
        "tree of Parzen estimators: `--sampler tpe`",
        by_search(lambda setting, seed: TPESearch(setting.spaces["integer"], seed)),
    ),
    "cmaes": Method(
        "CMA-ES: `--sampler cmaes`", by_search(lambda setting, seed: CMASearch(setting.spaces["integer"], seed))
    ),
    "lm": Method(
        "Li et al. (2015): `--sampler lm`",
        by_search(lambda setting, seed: LMSearch(setting.spaces["integer"], seed)),
        trials=MANY,
        seeds=1,
    ),
    "grid": Method("grid of De Gusseme and wyffels (2022)", grid, trials=MANY),
    "sobol": Method("Sobol' sequence", sobol, trials=MANY),
    "random": Method(
        "random: `--sampler random`",
        by_search(lambda setting, seed: RandomSearch(setting.spaces["integer"], seed)),
        trials=MANY,
    ),
}
"""Search methods by name, in the order of the tables."""
CORE = ("ours", "plain", "random")
"""Names of the search methods that docs/notes/search.md compares first."""
OURS = ("ours", "low", "gp")
"""Names of the variants of tatamu's own search."""
PAIR = ("gp", "gpsampler")
"""Names of two search methods that are compared over more random seeds."""
