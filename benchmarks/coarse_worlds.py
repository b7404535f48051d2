"""How far a coarse mesh can be trusted in disturbed worlds: a table of docs/notes/learning.md.

    python -m benchmarks.coarse_worlds --out runs/coarse-worlds [--only CASE] [--folds 8] [--worlds 8] [--write-docs]

A fold is learned in disturbed worlds as by `tatamu learn --trials 24`. Some of its manipulations are taken, evenly from
the best to the worst that did not fail. Each is simulated in the same worlds on the default mesh and on the coarse mesh
of the search. Simulations are kept in the folder and not run again.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from time import thread_time

import numpy as np
from scipy.stats import spearmanr

from benchmarks.coarser import manipulations
from benchmarks.earned import CASES
from benchmarks.tables import markdown, merged, publish, published
from tatamu.api import learn
from tatamu.base.files import read_json, write_json
from tatamu.evaluation import CoarseFirst, Disturbed, Nominal
from tatamu.evaluation.disturbances import NOMINAL, Stream, World, default_disturbances, sample_sobol
from tatamu.evaluation.robustness import FoldOnMesh, Verdict
from tatamu.evaluation.robustness.judge import verdict_in
from tatamu.folding.score import ALPHA, Limits
from tatamu.folding.task import Task
from tatamu.search import Parameters
from tatamu.study.folder import ResultFolder
from tatamu.study.options import LearnOptions

TRIALS = 24
UNUSED_SEED = 1000
"""Random seed of the worlds. No study used it."""
LIMITS = Limits()


class Kept:
    """Kept distances of one case: mean vertex distance [m] and processor time [s] of each simulation."""

    def __init__(self, file: Path) -> None:
        """Read the kept simulations."""
        self._file = file
        self._known: dict[str, list[float]] = read_json(file) if file.exists() else {}

    def simulated(self, key: str, fold: FoldOnMesh, world: World) -> tuple[bool, float, float]:
        """Return whether a fold holds in a world, its mean vertex distance [m], and the processor time [s]."""
        if key not in self._known:
            begin = thread_time()
            verdict = verdict_in(fold.evaluator, fold.parameters, world)
            self._known[key] = [LIMITS.hold(verdict), _distance(verdict), thread_time() - begin]
            write_json(self._file, self._known)
        holds, distance, seconds = self._known[key]
        return bool(holds), distance, seconds


def _distance(verdict: Verdict) -> float:
    """The mean vertex distance [m]; ten times the limit for a simulation that failed."""
    found = verdict.mean_vertex_distance
    return 10.0 * LIMITS.mean_vertex_distance if found is None else found


def robust(task: Task, parameters: Parameters, found: Sequence[tuple[bool, float, float]]) -> float:
    """Return the robust objective of a fold from its simulations, of which the first has no disturbances."""
    length, count = task.manipulation(parameters).trajectory_length, len(task.fold.start)
    values = [length + (1.0 if holds else 2.0) * ALPHA * count * distance for holds, distance, _ in found]
    in_worlds = [values[0] if holds else value for (holds, _, _), value in zip(found[1:], values[1:], strict=True)]
    return Disturbed(Nominal(task), default_disturbances(), worlds=len(in_worlds)).aggregate(in_worlds)


def row(name: str, out: Path, folds: int, count: int) -> dict[str, str]:
    """Measure one case."""
    task = CASES[name].task()
    folder = ResultFolder(out / name)
    if not folder.complete:
        with ThreadPoolExecutor(1) as workers:
            learn(task, LearnOptions(trials=TRIALS, baselines=False), out=folder.path, executor=workers)
    worlds = [NOMINAL, *sample_sobol(default_disturbances(), count, UNUSED_SEED, Stream.MARGINS)]
    evaluator = CoarseFirst(Nominal(task))
    kept = Kept(out / f"{name}.json")
    chosen = manipulations(folder, folds)
    on_meshes: dict[str, list[FoldOnMesh]] = {
        "default": [FoldOnMesh(evaluator, parameters) for parameters in chosen],
        "coarse": [FoldOnMesh(*low) for parameters in chosen if (low := evaluator.low_fidelity(parameters))],
    }
    found = [
        [
            [kept.simulated(f"{mesh} {number} {n}", fold, world) for n, world in enumerate(worlds)]
            for number, fold in enumerate(folds_there)
        ]
        for mesh, folds_there in on_meshes.items()
    ]
    objectives = [
        [robust(task, parameters, each) for parameters, each in zip(chosen, there, strict=True)] for there in found
    ]
    numbers: np.ndarray = np.array(found, dtype=np.float64)
    """Three numbers of each simulation, shape (meshes, folds, worlds, 3)."""
    holds, seconds = numbers[..., 0] > 0.0, numbers[..., 2]
    simulated = seconds.min(axis=0) > 0.01  # a hand that misses the cloth ends a fold before its simulation
    return {
        "fold": CASES[name].name,
        "folds": f"{len(chosen)}",
        "worlds": f"{count}",
        "time on the coarse mesh": f"{seconds[1][simulated].mean() / seconds[0][simulated].mean():.2f}",
        "rank correlation": f"{spearmanr(*objectives)[0]:.2f}",
        "same verdict": _share(holds[0] == holds[1], simulated),
        "holds only on the coarse mesh": _share(~holds[0] & holds[1], simulated),
        "holds only on the default mesh": _share(holds[0] & ~holds[1], simulated),
    }


def _share(which: np.ndarray, simulated: np.ndarray) -> str:
    return f"{int((which & simulated).sum())} of {int(simulated.sum())}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--only", choices=CASES, action="append", help="a case; the others' rows of the docs stay")
    parser.add_argument("--folds", type=int, default=8, help="of each case")
    parser.add_argument("--worlds", type=int, default=8)
    parser.add_argument("--write-docs", action="store_true")
    options = parser.parse_args()
    found = [row(name, options.out, options.folds, options.worlds) for name in options.only or reversed(CASES)]
    table = markdown(merged(published("coarser: disturbed worlds"), found, "fold"))
    print(table)
    if options.write_docs:
        publish("coarser: disturbed worlds", table)


if __name__ == "__main__":
    main()
