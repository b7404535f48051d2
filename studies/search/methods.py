"""The searches that are compared, by name."""

from __future__ import annotations

import importlib.util
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import log

import numpy as np
import optuna
from optuna.samplers import GPSampler
from optuna.trial import create_trial
from scipy.stats import qmc
from studies.search.settings import Setting

from tatamu.curves import sampled_bezier
from tatamu.folding.manipulation import Manipulation
from tatamu.folding.parameters import first_curves, low_curves
from tatamu.search import Bounds, Observation, Parameters, Search, Space, find_search
from tatamu.search.gp import GPSearch
from tatamu.search.optuna_search import distributions

FEW, MANY = 50, 134
"""Simulations of a sequential search, and of those that need or bear more."""
FAR = 2.0
"""Times the span, beyond which GPSampler sees all objectives alike."""
Making = Callable[[Setting, int], Search]
"""From a setting and a seed to a search."""


def bezier(setting: Setting, parameters: Mapping[str, float]) -> Manipulation:
    """Return the manipulation of x1 to g2."""
    return setting.task.manipulation(parameters)


@dataclass(frozen=True)
class Method:
    """A way to search."""

    title: str
    make: Making
    trials: int = FEW
    """How many simulations it is given at most."""
    seeds: int | None = None
    """How often it is run; None for as often as the command says."""
    needs: tuple[str, ...] = field(default=())
    """Modules without which it is left out."""
    manipulation: Callable[[Setting, Mapping[str, float]], Manipulation] = bezier
    """The manipulation of parameters."""

    @property
    def possible(self) -> bool:
        """Whether all that it needs is there."""
        return all(importlib.util.find_spec(module) for module in self.needs)


def named(name: str) -> Making:
    """Return a search of `tatamu learn` by its name, which starts from a random trial."""
    return lambda setting, seed: find_search(name)(setting.spaces["integer"], seed)


class WithoutRandomTrial(GPSearch):
    """The Gaussian process with no random trial after the first parameters."""

    @property
    def known(self) -> list[Observation]:
        """The observations that the next proposal may depend on."""
        return self.told


class OptunaGP(Search):
    """Optuna's `GPSampler`, told log(C / span - 1), all bad trials alike: once the default of tatamu."""

    def propose(self) -> tuple[Parameters, float | None]:
        """Return the next parameters; a new study each time, since what counts as bad depends on the best."""
        ranges = distributions(self.space)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            sampler = GPSampler(seed=self.sub_seed(), n_startup_trials=1, deterministic_objective=True)
            study = optuna.create_study(sampler=sampler, direction="minimize")
            for each, value in zip(self.told, self._logarithms(), strict=True):
                study.add_trial(create_trial(value=value, params=each.parameters, distributions=ranges))
            return dict(study.ask(ranges).params), None

    def _logarithms(self) -> list[float]:
        span = self.space.bounds["x1"].high
        excess = [max(each.objective / span - 1.0, 1e-6) for each in self.told]
        bad = max(1.0, FAR * min(excess, default=0.0))
        return [log(min(each, bad)) for each in excess]


class SobolSearch(Search):
    """A scrambled Sobol' sequence."""

    @cached_property
    def _points(self) -> np.ndarray:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that 134 is no power of two
            drawn = qmc.Sobol(self.space.dimensions, scramble=True, rng=np.random.default_rng(self.seed)).random(MANY)
        return self.space.snap(drawn)

    def propose(self) -> tuple[Parameters, float | None]:
        """Return the next parameters."""
        return self.space.parameters(self._points[self.number]), None


class GridSearch(Search):
    """The grid of De Gusseme and wyffels (2022), in an order drawn by the seed.

    14 heights from 0.1 to 1, and the more tilts from 0 to 60 degrees the higher.
    """

    @cached_property
    def _points(self) -> list[Parameters]:
        points: list[Parameters] = [
            {"height": float(height), "tilt": float(tilt)}
            for height in np.linspace(0.1, 1.0, 14)
            for tilt in np.linspace(0.0, np.pi / 3.0, max(2, int(18 * height)))
        ]
        assert len(points) == MANY
        return [points[number] for number in np.random.default_rng(self.seed).permutation(MANY)]

    def propose(self) -> tuple[Parameters, float | None]:
        """Return the next height and tilt."""
        return self._points[self.number], None


GRID_SPACE = Space({"height": Bounds(0.1, 1.0), "tilt": Bounds(0.0, np.pi / 3.0)})


def leaning_curve(setting: Setting, parameters: Mapping[str, float]) -> Manipulation:
    """Return the manipulation of a height and a tilt.

    A quadratic Bezier curve whose middle control point lies height times the span over the middle, turned about the
    line from grasp to release by the tilt. Both hands lean to the same side; they grasp the corners.
    """
    height, tilt = parameters["height"], parameters["tilt"]
    fold = setting.fold
    grasps = tuple(int(hand[0]) for hand in (fold.left, fold.right)[: fold.hands])
    curves = []
    for vertex in grasps:
        release = fold.translation(vertex)
        lean = np.array([-fold.normal[1], fold.normal[0], 0.0]) * np.sin(tilt) + np.array([0.0, 0.0, np.cos(tilt)])
        middle = 0.5 * release + height * fold.span_of(vertex) * lean
        curves.append(np.stack([np.zeros(3), 2.0 / 3.0 * middle, (release + 2.0 * middle) / 3.0, release]))
    places = tuple(fold.start[vertex] for vertex in grasps)
    return Manipulation(grasps, places, tuple(map(sampled_bezier, curves)), tuple(curves))


METHODS: dict[str, Method] = {
    "ours": Method(
        "ours: two arched and three low curves, a random trial, `gp`",
        lambda setting, seed: GPSearch(setting.spaces["integer"], seed, first_curves(setting.fold)),
    ),
    "low": Method(
        "three low curves, then `gp` at once",
        lambda setting, seed: WithoutRandomTrial(setting.spaces["integer"], seed, low_curves(setting.fold)),
        seeds=2,
    ),
    "gp": Method("`--sampler gp` from a random trial", named("gp")),
    "plain": Method(
        "the paper's: C itself, floored grasps",
        lambda setting, seed: GPSearch(replace(setting.spaces["continuous"], known_part=None), seed),
    ),
    "gpsampler": Method(
        "Optuna's `GPSampler`, told log(C / span - 1)",
        lambda setting, seed: OptunaGP(setting.spaces["integer"], seed),
        needs=("torch",),
    ),
    "tpe": Method("tree of Parzen estimators: `--sampler tpe`", named("tpe")),
    "cmaes": Method("CMA-ES: `--sampler cmaes`", named("cmaes")),
    "lm": Method("Li et al. (2015): `--sampler lm`", named("lm"), trials=MANY, seeds=1),
    "grid": Method(
        "grid of De Gusseme and wyffels (2022)",
        lambda setting, seed: GridSearch(GRID_SPACE, seed),
        trials=MANY,
        manipulation=leaning_curve,
    ),
    "sobol": Method("Sobol' sequence", lambda setting, seed: SobolSearch(setting.spaces["integer"], seed), trials=MANY),
    "random": Method("random: `--sampler random`", named("random"), trials=MANY),
}
"""Ways to search by name, in the order of the tables."""
CORE = ("ours", "plain", "random")
"""Those that the page's first question is about."""
OURS = ("ours", "low", "gp")
"""Forms of our own search."""
PAIR = ("gp", "gpsampler")
"""Two that are compared over more seeds."""
