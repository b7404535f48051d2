"""Trials side by side: how long 50 trials of the default towel take, and what they find.

The table "learning: parallel" of docs/notes/learning.md:

    python benchmarks/parallel.py [--seeds 3] [--trials 50] [--write-docs]

Every study runs in a process of its own, one after the other; those of one seed follow each other, so that they meet
the same machine. Compiled kernels are there; the time runs from the study's opening to its last trial's end.
"""

from __future__ import annotations

import argparse
import multiprocessing
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import NamedTuple

from tables import markdown, publish

from tatamu.folding.task import make_task
from tatamu.learning import Progress, learn
from tatamu.results import ResultFolder

AT_A_TIME = (1, 2, 3)


class Found(NamedTuple):
    """Result of one study."""

    seconds: float
    objective: float
    distance: float


def study(parallel: int, seed: int, trials: int) -> Found:
    """Run one study in a folder that is thrown away."""
    times: list[float] = []

    def note(_: Progress) -> None:
        times.append(perf_counter())

    with TemporaryDirectory() as folder:
        task, options = make_task("towel"), {"trials": trials, "seed": seed, "parallel": parallel}
        learn(task, Path(folder), baselines=False, progress=note, **options)
        best = ResultFolder(Path(folder)).result.best_trial
    assert best.objective is not None and best.mean_vertex_distance is not None, "the best trial is complete"
    return Found(times[-1] - times[0], best.objective, best.mean_vertex_distance)


def alone(parallel: int, seed: int, trials: int) -> Found:
    """`study` in a process of its own: a library that one has loaded would be there for the next."""
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as process:
        return process.submit(study, parallel, seed, trials).result()


def line(parallel: int, found: list[Found], one_by_one: list[Found]) -> dict[str, object]:
    """A row of the table."""
    seconds = [each.seconds for each in found]
    ratios = [each.seconds / one.seconds for each, one in zip(found, one_by_one, strict=True)]
    return {
        "trials at a time": parallel,
        "seconds": f"{median(seconds):.0f} ({min(seconds):.0f} to {max(seconds):.0f})",
        "of one by one": f"{median(ratios):.2f}",
        "C, median and worst": f"{median(e.objective for e in found):.4f}, {max(e.objective for e in found):.4f}",
        "mean distance, worst [mm]": f"{1e3 * max(each.distance for each in found):.2f}",
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--trials", type=int, default=50)
    parser.add_argument("--write-docs", action="store_true")
    options = parser.parse_args()
    alone(1, 0, 1)  # compiles
    found: dict[int, list[Found]] = {parallel: [] for parallel in AT_A_TIME}
    for seed in range(options.seeds):
        for parallel in AT_A_TIME:
            found[parallel].append(alone(parallel, seed, options.trials))
            print(f"seed {seed}, {parallel} at a time: {found[parallel][-1].seconds:.1f} s", flush=True)
    table = markdown([line(parallel, found[parallel], found[1]) for parallel in AT_A_TIME])
    print(table)
    if options.write_docs:
        publish("learning: parallel", table)


if __name__ == "__main__":
    main()
