"""How far a coarser mesh can be trusted in a search: the tables "coarser" of docs/notes/learning.md.

    python benchmarks/coarser.py --out runs/coarser [--folds 16] [--only CASE] [--write-docs]

A study of each garment is learned as by `tatamu learn --disturbances none`, and of its manipulations some are taken,
evenly from the best to the worst that did not fail. They are simulated on the default mesh, and on coarser ones with
the cloth as it is or softer to stretch. A later step of a plan begins on every mesh from the cloth as the step before
left it on the default one, and is also scored on that when the hands have arrived. What was simulated is kept in the
folder and not run again.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from time import thread_time
from typing import NamedTuple

import numpy as np
from scipy.stats import spearmanr

from benchmarks.tables import markdown, merged, publish, published
from tatamu.api import learn
from tatamu.base.files import read_json, write_json
from tatamu.evaluation import CoarseFirst, CoarseMesh, Incumbent, Nominal
from tatamu.evaluation.coarse import coarsened
from tatamu.folding.interpolation import interpolated
from tatamu.folding.task import Task, make_task
from tatamu.search import LOW, Parameters, Proposal
from tatamu.simulation.mesh.crossings import crossings
from tatamu.study.folder import ResultFolder
from tatamu.study.options import LearnOptions

TWO_LAYERS = ((1.4, 1.0), (1.4, 1.96), (1.7, 1.0), (1.7, 2.89), (1.7, 6.0), (2.0, 4.0))
LATER = ((1.3, 1.69), (1.5, 2.25), (1.7, 2.89))
"""Meshes for later steps of a plan."""


class Case(NamedTuple):
    """One fold of a garment, and the coarser meshes on which it is tried."""

    garment: str
    fold: str
    step: int
    """Number of the fold in its plan, counted from 0."""
    trials: int
    """Number of trials in the study of each step."""
    meshes: tuple[tuple[float, float], ...]
    """Factor of the spacing, and factor by which the cloth is softer to stretch."""


CASES = {
    "towel": Case("towel", "half", 0, 50, ((2.0, 1.0), (2.0, 4.0))),
    "T-shirt": Case("tshirt", "half", 0, 50, TWO_LAYERS),
    "trousers": Case("trousers", "leg", 0, 50, TWO_LAYERS),
    "T-shirt, shop, step 2": Case("tshirt", "shop", 1, 60, LATER),
    "T-shirt, shop, step 3": Case("tshirt", "shop", 2, 60, LATER),
}
MARKS = ("coarser", "coarser: later steps")
"""Tables of the docs: of first steps, and of later ones."""
DEFAULT = "default"
ON_ARRIVAL = "on arrival"
"""What was simulated until the hands had arrived, on the default mesh."""


@dataclass(frozen=True)
class Simulated:
    """One fold on one mesh."""

    objective: float
    """C in the numbers of the default mesh."""
    seconds: float
    """Processor time [s]."""


class Kept:
    """Kept simulations of one garment."""

    def __init__(self, file: Path) -> None:
        """Read the kept simulations."""
        self._file = file
        self._known = {tuple(key): Simulated(*held) for key, held in read_json(file)} if file.exists() else {}

    def simulated(self, key: tuple[str, int], objective_of: Callable[[], float]) -> Simulated:
        """Return a fold on a mesh; it is simulated only if it is not kept."""
        if key not in self._known:
            begin = thread_time()
            objective = objective_of()
            self._known[key] = Simulated(objective, thread_time() - begin)
            write_json(self._file, [[key, [each.objective, each.seconds]] for key, each in self._known.items()])
        return self._known[key]


@dataclass(frozen=True)
class OnMesh(CoarseFirst):
    """Evaluator of proposals of low fidelity on a given mesh."""

    mesh: Task | None = None

    @cached_property
    def coarse(self) -> Nominal | None:
        """Return the evaluator of the given mesh."""
        return None if self.mesh is None else Nominal(self.mesh)


def _objective(task: Task, fine: Task, parameters: Parameters) -> float:
    if task is fine:
        return Nominal(fine)(parameters).objective
    return OnMesh(Nominal(fine), mesh=task)(Proposal(parameters, LOW)).objective


def _on_arrival(fine: Task, parameters: Parameters) -> float:
    """The objective when the hands have arrived, which ends any fold that must beat an objective of 0."""
    return Nominal(fine, ends_early=True)(parameters, Incumbent(0.0)).objective


def learned(task: Task, folder: ResultFolder, case: Case) -> ResultFolder:
    """Return the folder of a step of a study, which is learned if it does not exist."""
    if not folder.complete:
        learn(task, LearnOptions(trials=case.trials, disturbances="none", baselines=False), out=folder.path)
    return folder.step(case.step) if len(task.plan.steps) > 1 else folder


def manipulations(study: ResultFolder, count: int) -> list[Parameters]:
    """Parameters of a study's trials, evenly from the best to the worst that did not fail."""
    complete = [trial for trial in study.record.trials if trial.state == "complete"]
    ordered = sorted(complete, key=lambda trial: (trial.minimised, trial.number))
    chosen = np.unique(np.linspace(0, len(ordered) - 1, count).round().astype(int))
    return [ordered[number].parameters for number in chosen]


def rows(name: str, out: Path, count: int) -> Iterator[dict[str, str]]:
    """Return the rows of a case, the default mesh first."""
    case = CASES[name]
    first = make_task(case.garment, fold=case.fold)
    plan = len(first.plan.steps) > 1
    study_name = f"{case.garment}-{case.fold}" if plan else case.garment
    study = learned(first, ResultFolder(out / study_name), case)
    state = study.rollout.positions[0] if case.step else None
    fine = first.at(case.step, state)
    kept = Kept(out / (f"{study_name}-{case.step + 1}.json" if plan else f"{study_name}.json"))
    folds = manipulations(study, count)
    known = [kept.simulated((DEFAULT, number), partial(_objective, fine, fine, x)) for number, x in enumerate(folds)]

    def row(spacing: str, softer: float, task: Task, found: Sequence[Simulated]) -> dict[str, str]:
        measured = _row(spacing, softer, task, found, known)
        return {"fold": name, "folds": f"{len(folds)}", **measured, **_start(case, task)}

    yield row("1", 1.0, fine, known)
    if case.step:
        found = [kept.simulated((ON_ARRIVAL, number), partial(_on_arrival, fine, x)) for number, x in enumerate(folds)]
        yield row(f"1, {ON_ARRIVAL}", 1.0, fine, found)
    for larger, softer in case.meshes:
        garment = coarsened(fine.garment, larger, softer)
        there = None if state is None else interpolated(fine.garment, state, garment)
        task = replace(fine, garment=garment, state=there, settle=CoarseMesh().settle)
        mesh = f"{larger:g}, {softer:g}"
        found = [kept.simulated((mesh, number), partial(_objective, task, fine, x)) for number, x in enumerate(folds)]
        yield row(f"{larger:g}", softer, task, found)


def _start(case: Case, task: Task) -> dict[str, str]:
    """How much a later step's cloth is within itself when it begins; first steps begin flat."""
    return {"crossings at the start": f"{crossings(task.fold.start, task.fold.garment.faces)}"} if case.step else {}


def _row(
    spacing: str, softer: float, task: Task, found: Sequence[Simulated], known: Sequence[Simulated]
) -> dict[str, str]:
    here = np.array([each.objective for each in found])
    there = np.array([each.objective for each in known])
    good = there <= np.median(there)
    best = there[np.argsort(here, kind="stable")[:3]]
    return {
        "times the spacing": spacing,
        "times softer": f"{softer:g}",
        "vertices": f"{len(task.fold.start)}",
        "processor seconds, each": f"{np.mean([each.seconds for each in found]):.2f}",
        "rank correlation": f"{spearmanr(here, there)[0]:.2f}",
        "of the better half": f"{spearmanr(here[good], there[good])[0]:.2f}",
        "off by, median": f"{100 * np.median(np.abs(here / there - 1.0)):.1f} %",
        "off by, worst": f"{100 * np.abs(here / there - 1.0).max():.0f} %",
        "too high by, at most": f"{100 * max(0.0, (here / there).max() - 1.0):.0f} %",
        "best of its best three": f"{best.min():.4f}",
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--folds", type=int, default=16, help="of each garment")
    parser.add_argument("--only", choices=CASES, action="append", help="a case; the others' rows of the docs stay")
    parser.add_argument("--write-docs", action="store_true")
    options = parser.parse_args()
    for mark in MARKS:
        chosen = [name for name in options.only or CASES if MARKS[bool(CASES[name].step)] == mark]
        if not chosen:
            continue
        found = []
        for name in chosen:
            for row in rows(name, options.out, options.folds):
                found.append(row)
                print(row, flush=True)
        table = markdown(merged(published(mark), found, "fold", "times the spacing", "times softer"))
        print(table)
        if options.write_docs:
            publish(mark, table)


if __name__ == "__main__":
    main()
