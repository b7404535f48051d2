"""The search against its alternatives: what each has found after 1 to 134 simulations. docs/notes/search.md.

    python benchmarks/search.py --out runs/search [--seeds 10] [--pair-seeds 20] [--write-docs]
    python benchmarks/search.py --out runs/search --show [--write-docs]      tables of what is there

Every simulation is kept in OUT/rollouts and every study in OUT/studies, so that a run that was stopped goes on. Studies
come seed by seed: what is there at any moment can be shown. Optuna's GPSampler needs torch, which tatamu does not
install (`pip install torch`); without it its row is left out.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import log
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
import optuna
from optuna.samplers import BaseSampler, GPSampler, RandomSampler, TPESampler
from optuna.trial import FrozenTrial, create_trial
from scipy.stats import qmc
from search_chart import draw
from tables import IMAGES, markdown, publish
from threadpoolctl import threadpool_limits

from tatamu.curves import sampled_bezier
from tatamu.files import write_text
from tatamu.folding.fold import Fold
from tatamu.folding.manipulation import Manipulation, trajectory_lengths
from tatamu.folding.score import vertex_distances
from tatamu.folding.task import Task, digest, make_task
from tatamu.learning.cma_es import EvolutionSampler
from tatamu.learning.gp_sampler import GaussianProcessSampler
from tatamu.learning.lm_sampler import ERRORS, LevenbergMarquardtSampler, packed
from tatamu.learning.space import Grasps, first_curves, low_curves, search_space
from tatamu.learning.unit_cube import UnitCube
from tatamu.results.result import Parameters

COUNTS = (1, 5, 10, 25, 50, 134)
"""Simulations after which the searches are compared."""
FEW, MANY = 50, 134
"""Simulations of a sequential search, and of those that need or bear more."""
GARMENTS = {
    "towel": ("towel", "half", 0.03),
    "T-shirt": ("tshirt", "half", 0.045),
    "trousers": ("trousers", "leg", 0.045),
}
"""Garment, fold and spacing of the mesh [m]: coarse, so that a fold takes a fraction of a second."""
FAR = 2.0
"""Times the span, beyond which GPSampler sees all objectives alike."""


@dataclass(frozen=True)
class Simulated:
    """One simulation."""

    objective: float
    """C of Eq. (10)."""
    distance: float
    """Mean vertex distance [m]; infinite where the trial failed."""
    errors: np.ndarray | None
    """e_i of Eq. (12) [m], shape (n,); None where the trial failed."""


class Setting:
    """One garment to fold, and the simulations of it that are there."""

    def __init__(self, name: str, folder: Path) -> None:
        """Open the simulations of a garment.

        Args:
            name: A key of `GARMENTS`.
            folder: Where they are kept.
        """
        self.name = name
        garment, fold, spacing = GARMENTS[name]
        self.task: Task = make_task(garment, fold=fold, spacing=spacing)
        folder.mkdir(parents=True, exist_ok=True)
        self._file = folder / f"{garment}.jsonl"
        self._known: dict[str, Simulated] = {}
        if self._file.exists():
            for line in self._file.read_text().splitlines():
                record = json.loads(line)
                errors = np.array(record["errors"]) if record["errors"] is not None else None
                distance = float(errors.mean()) if errors is not None else float("inf")
                self._known[record["key"]] = Simulated(record["objective"], distance, errors)

    @property
    def fold(self) -> Fold:
        """What is folded."""
        return self.task.fold

    @cached_property
    def spaces(self) -> dict[Grasps, dict[str, Any]]:
        """Bounds of the search, with whole and with floored grasps."""
        return {grasps: dict(search_space(self.fold, grasps)) for grasps in ("integer", "continuous")}

    def lengths(self, parameters: Mapping[str, np.ndarray]) -> np.ndarray:
        """l_x of Eq. (10) of parameters [m]."""
        return trajectory_lengths(self.fold, parameters)

    def simulated(self, manipulation: Manipulation) -> Simulated:
        """The simulation of a manipulation; run only if it is not there."""
        assert manipulation.control_points is not None
        key = digest(np.array(manipulation.grasps), *manipulation.control_points)
        if key not in self._known:
            outcome = self.task.evaluate(manipulation)
            errors = None
            if not outcome.failed and outcome.rollout is not None:
                errors = vertex_distances(self.fold.target, outcome.rollout.positions[-1])
            record = {
                "key": key,
                "objective": outcome.objective,
                "errors": None if errors is None else errors.tolist(),
            }
            with self._file.open("a") as file:
                file.write(json.dumps(record) + "\n")
            distance = float(errors.mean()) if errors is not None else float("inf")
            self._known[key] = Simulated(outcome.objective, distance, errors)
        return self._known[key]


Proposing = Callable[[Setting, int, int, Sequence[tuple[Any, Simulated]]], tuple[Any, Manipulation]]
"""From setting, seed, number of the trial and the trials before it (parameters, simulation) to parameters and what they
mean."""


@dataclass(frozen=True)
class Method:
    """A way to search."""

    title: str
    propose: Proposing
    trials: int = FEW
    """How many simulations it is given at most."""
    seeds: int | None = None
    """How often it is run; None: as often as the command says."""
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
    """log(C / span - 1), bad ones all alike: what Optuna's GPSampler was given while it was the default."""
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


@dataclass(frozen=True)
class Course:
    """Objectives and mean vertex distances [m] of a study's trials in order."""

    objectives: list[float]
    distances: list[float]

    def best(self, count: int) -> tuple[float, float]:
        """Least objective of the first trials, and the mean vertex distance of that trial."""
        place = int(np.argmin(self.objectives[:count]))
        return self.objectives[place], self.distances[place]


class Studies:
    """The studies that are there."""

    def __init__(self, out: Path) -> None:
        """Open a folder."""
        self._folder = out / "studies"
        self._folder.mkdir(parents=True, exist_ok=True)

    def run(self, method: str, setting: Setting, seed: int, trials: int) -> None:
        """Run a study of so many trials, unless it is there."""
        held = self.course(setting.name, method, seed)
        if held is not None and len(held.objectives) >= trials:
            return
        before: list[tuple[Any, Simulated]] = []
        for number in range(trials):
            parameters, manipulation = METHODS[method].propose(setting, seed, number, before)
            before.append((parameters, setting.simulated(manipulation)))
        records = [
            {"parameters": parameters, "objective": simulated.objective, "distance": simulated.distance}
            for parameters, simulated in before
        ]
        write_text(self._path(setting.name, method, seed), json.dumps(records))

    def course(self, garment: str, method: str, seed: int) -> Course | None:
        """The course of a study; None if it is not there."""
        path = self._path(garment, method, seed)
        if not path.exists():
            return None
        records = json.loads(path.read_text())
        return Course([each["objective"] for each in records], [each["distance"] for each in records])

    def courses(self, garment: str, method: str, count: int, seeds: int = 100) -> list[Course]:
        """All studies of a method that have so many trials, of the first `seeds` seeds."""
        found = [self.course(garment, method, seed) for seed in range(seeds)]
        return [each for each in found if each is not None and len(each.objectives) >= count]

    def _path(self, garment: str, method: str, seed: int) -> Path:
        return self._folder / f"{garment}-{method}-{seed}.json"


def run(out: Path, seeds: int, pair_seeds: int) -> None:
    """Run what is not there, what matters most first, seed by seed: the towel's, as its folds are the quickest."""
    settings = {name: Setting(name, out / "rollouts") for name in GARMENTS}
    studies = Studies(out)
    towel, all_garments, all_methods = ("towel",), tuple(GARMENTS), tuple(METHODS)
    few = min(2, seeds)
    for garments, names, trials, first, last in (
        (all_garments, all_methods, FEW, 0, few),
        (all_garments, ("lm",), MANY, 0, 1),
        (all_garments, ("grid",), MANY, 0, seeds),
        (towel, CORE, FEW, few, seeds),
        (all_garments, CORE, FEW, few, seeds),
        (towel, all_methods, FEW, few, seeds),
        (all_garments, all_methods, FEW, few, seeds),
        (all_garments, all_methods, MANY, 0, seeds),
        (all_garments, PAIR, FEW, seeds, pair_seeds),
    ):
        for seed in range(first, last):
            for garment in garments:
                for name in names:
                    method = METHODS[name]
                    if method.possible and seed < (method.seeds or last) and trials <= method.trials:
                        studies.run(name, settings[garment], seed, trials)
            print(f"{', '.join(garments)}: {', '.join(names)}, {trials} trials, seed {seed}: done", flush=True)


def table(studies: Studies, garment: str, seeds: int) -> list[dict[str, str]]:
    """A row for each method: median and worst of all seeds that are there."""
    rows = []
    for name, method in METHODS.items():
        counts = {count: studies.courses(garment, name, count, seeds) for count in COUNTS}
        if not counts[1]:
            continue
        row = {"search": method.title, "seeds": _seeds(counts)}
        for count, courses in counts.items():
            row[f"C {count}"] = _spread([course.best(count)[0] for course in courses], ".3f")
        for count in (10, 50, 134):
            row[f"mm {count}"] = _spread([1e3 * course.best(count)[1] for course in counts[count]], ".1f")
        rows.append(row)
    return rows


def _seeds(counts: Mapping[int, Sequence[Course]]) -> str:
    first, last = len(counts[FEW]), len(counts[MANY])
    return str(first) if last in (0, first) else f"{first}, {last} to {MANY}"


def _spread(values: Sequence[float], digits: str) -> str:
    """Median and worst."""
    if not values:
        return "-"
    if len(values) == 1:
        return format(values[0], digits)
    return f"{median(values):{digits}}, {max(values):{digits}}"


def pair_table(studies: Studies, seeds: int) -> list[dict[str, str]]:
    """Ours and Optuna's GPSampler over the seeds that both have."""
    rows = []
    for garment in GARMENTS:
        both = [
            (ours, theirs)
            for seed in range(seeds)
            for ours, theirs in [tuple(studies.course(garment, name, seed) for name in PAIR)]
            if ours is not None and theirs is not None
        ]
        if not both:
            continue
        row = {"garment": garment, "seeds": str(len(both))}
        for count in (10, 25, 50):
            for title, place in (("gp", 0), ("GPSampler", 1)):
                row[f"{title} {count}"] = _spread([pair[place].best(count)[0] for pair in both], ".4f")
        rows.append(row)
    return rows


def answers(studies: Studies, seeds: int) -> list[dict[str, str]]:
    """After how many trials ours has, in the median, what others have after `FEW`; over the seeds that both have."""
    rows = []
    for garment in GARMENTS:
        for ours in OURS:
            row = {"garment": garment, "search": METHODS[ours].title}
            for name, wanted in (("random", 10), ("plain", 25)):
                pairs = [
                    (studies.course(garment, ours, seed), studies.course(garment, name, seed)) for seed in range(seeds)
                ]
                both = [(own, theirs) for own, theirs in pairs if own is not None and theirs is not None]
                if both:
                    bar = median(theirs.best(FEW)[0] for _, theirs in both)
                    medians = {n: median(own.best(n)[0] for own, _ in both) for n in range(1, FEW + 1)}
                    trials = next((str(n) for n, value in medians.items() if value <= bar), f"not in {FEW}")
                    row[f"C of {name} after {FEW} (seeds)"] = f"{bar:.3f} ({len(both)})"
                    row[f"reached after (wanted: {wanted})"] = trials
            rows.append(row)
    return [row for row in rows if len(row) > 2]


def show(out: Path, seeds: int, pair_seeds: int, write: bool) -> None:
    """Print all tables; into the docs if they are to be written."""
    studies = Studies(out)
    texts = {f"search: {garment}": table(studies, garment, seeds) for garment in GARMENTS}
    texts["search: answers"] = answers(studies, seeds)
    texts["search: pair"] = pair_table(studies, pair_seeds)
    for name, rows in texts.items():
        if not rows:
            continue
        print(f"\n{name}\n\n{markdown(rows)}")
        if write:
            publish(name, markdown(rows))
    if write:
        draw(courses_of(studies, seeds), IMAGES / "search.svg")


def courses_of(studies: Studies, seeds: int) -> dict[str, dict[str, list[list[float]]]]:
    """Least objectives so far of every study, by garment and title, for the chart."""
    return {
        garment: {
            method.title: [
                np.minimum.accumulate(course.objectives).tolist()
                for course in studies.courses(garment, name, FEW, seeds)
            ]
            for name, method in METHODS.items()
        }
        for garment in GARMENTS
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--pair-seeds", type=int, default=20)
    parser.add_argument("--show", action="store_true", help="run nothing")
    parser.add_argument("--write-docs", action="store_true")
    given = parser.parse_args()
    if not given.show:
        with threadpool_limits(1):
            run(given.out, given.seeds, given.pair_seeds)
    show(given.out, given.seeds, given.pair_seeds, given.write_docs)


if __name__ == "__main__":
    main()
