"""What learning gains over a hand-designed curve: folds of several seeds, each in 100 scenarios that no search used.

    python -m benchmarks.gains --out runs/gains [--seeds towel=5,tshirt=3,leg=3] [--jobs 1]
    python -m benchmarks.gains --out runs/gains --table [--write-docs]

The hand-designed curves are the arched one with grasps half-way inwards, and one half as high. Their hands aim like
those of learned folds. A file of the folder keeps what one study found, so that a killed run goes on. Times are
multiples of a load, 700 products of 300 x 300 matrices on one core, which is measured before and after each study.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor, as_completed
from dataclasses import dataclass, replace
from multiprocessing import get_context
from multiprocessing.queues import Queue
from pathlib import Path
from statistics import median
from time import perf_counter, process_time
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks.tables import IMAGES, arguments, show
from tatamu.base.files import read_json, write_json
from tatamu.evaluation.disturbances import Stream, default_disturbances, sample_scenarios
from tatamu.evaluation.disturbances.aim import aim_for
from tatamu.evaluation.draws import Draws, Subject
from tatamu.evaluation.nominal import Nominal
from tatamu.evaluation.success import Success
from tatamu.folding.parameters import ARCHED, arched_inwards
from tatamu.folding.score import Limits
from tatamu.folding.task import Task, make_task
from tatamu.simulation.side_by_side import processors
from tatamu.simulation.simulators import named
from tatamu.study.learn import learn
from tatamu.study.options import LearnOptions
from tatamu.study.result import Result

DRAWS = 100
UNUSED_SEED = 1000
"""Random seed of the scenarios in which folds are compared, the same for all."""
CURVE, LOWER, UNDISTURBED, LEARNED = "curve", "lower", "undisturbed", "learned"
TITLES = {
    CURVE: "hand-designed curve",
    LOWER: "hand-designed curve, half as high",
    UNDISTURBED: "learned without disturbances",
    LEARNED: "learned, the default",
}
HEIGHTS = {CURVE: ARCHED, LOWER: 0.5 * ARCHED}
"""Heights of the hand-designed curves [spans]."""


@dataclass(frozen=True)
class Case:
    """A garment and its fold."""

    name: str
    garment: str
    fold: str

    def task(self) -> Task:
        """Return the fold, with the fingers and the aim of the default disturbances."""
        disturbances = default_disturbances()
        aim = aim_for(disturbances, disturbances.fingers)
        return replace(make_task(self.garment, fold=self.fold), fingers=disturbances.fingers, aim=aim)


CASES = {
    "towel": Case("towel in half", "towel", "half"),
    "tshirt": Case("T-shirt in half", "tshirt", "half"),
    "leg": Case("trousers, leg over leg", "trousers", "leg"),
}


@dataclass(frozen=True)
class Job:
    """One study, or the hand-designed curve."""

    case: str
    kind: str
    seed: int

    def file(self, out: Path) -> Path:
        """Return the file in which its result is kept."""
        return out / f"{self.case}-{self.kind}-{self.seed}.json"


def jobs(seeds: Mapping[str, int]) -> list[Job]:
    """Return all that is to be measured, for numbers of seeds by case, the longest first."""
    learned = [Job(case, LEARNED, seed) for case, count in seeds.items() for seed in range(count)]
    others = [Job(case, kind, 0) for case in seeds for kind in (UNDISTURBED, CURVE, LOWER)]
    return sorted([*learned, *others], key=lambda job: (job.kind != LEARNED, job.case == "towel"))


def load() -> float:
    """Return the processor time of a load [s]."""
    matrix = np.random.default_rng(0).random((300, 300))
    with threadpool_limits(1):
        begin = process_time()
        for _ in range(700):
            matrix @ matrix
        return process_time() - begin


def in_fresh_scenarios(task: Task, parameters: Mapping[str, int | float]) -> Success:
    """Simulate a fold in scenarios that no search used."""
    scenarios = sample_scenarios(default_disturbances(), DRAWS, UNUSED_SEED, Stream.MARGINS)
    with ThreadPoolExecutor(processors()) as workers:
        return Success.of(task.fold, Draws(Subject(task, parameters), workers).outcomes(scenarios), Limits())


def simulations_of(result: Result) -> int:
    """Return how many simulations a search took."""
    return len(result.trials) + sum(trial.scenarios.simulated for trial in result.trials if trial.scenarios)


def measure(job: Job, out: Path) -> None:
    """Learn the fold and simulate it in fresh scenarios, unless its result is kept."""
    file = job.file(out)
    if file.exists():
        return
    task = CASES[job.case].task()
    found: dict[str, Any] = {"case": job.case, "kind": job.kind, "seed": job.seed}
    if job.kind in HEIGHTS:
        parameters = arched_inwards(task.fold, HEIGHTS[job.kind])
        score = Nominal(task)(parameters).score
    else:
        options = LearnOptions(seed=job.seed, disturbances="none" if job.kind == UNDISTURBED else "default")
        before, begin, wall = load(), process_time(), perf_counter()
        result = learn(make_task(CASES[job.case].garment, fold=CASES[job.case].fold), options)
        seconds, wall = process_time() - begin, perf_counter() - wall
        assert isinstance(result, Result), "these plans have one step"
        parameters, score = result.best.parameters, result.best.score
        one = 0.5 * (before + load())
        found |= {"loads": wall / one, "processor": seconds / one, "simulations": simulations_of(result)}
        task = task if job.kind == LEARNED else replace(result.task, fingers=task.fingers)
    success = in_fresh_scenarios(task, parameters)
    found |= {
        "path": task.manipulation(parameters).trajectory_length,
        "distance": None if score is None else score.mean_vertex_distance,
        "succeeded": success.succeeded,
        "causes": success.causes,
        "parameters": dict(parameters),
    }
    write_json(file, found)


def _pin(own: Queue[list[int]]) -> None:
    """Use the processors of this process alone."""
    os.sched_setaffinity(0, own.get())


def run(wanted: Sequence[Job], out: Path, count: int) -> None:
    """Measure what is not there."""
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
        os.environ[name] = "1"
    named("native").prepare()  # kernels are compiled once
    left = [job for job in wanted if not job.file(out).exists()]
    context = get_context("spawn")
    own: Queue[list[int]] = context.Queue()
    shares = np.array_split(sorted(os.sched_getaffinity(0)), count)
    for share in shares:
        own.put(share.tolist())
    with ProcessPoolExecutor(count, context, _pin, (own,)) as pool:
        futures = {pool.submit(measure, job, out): job for job in left}
        for done, future in enumerate(as_completed(futures), 1):
            future.result()
            print(f"{done}/{len(left)}", futures[future].file(out).name, flush=True)


def rows(found: Sequence[Mapping[str, Any]]) -> list[dict[str, str]]:
    """Return one row for each case and way to a fold. With several seeds, numbers are medians, and ranges follow."""
    table = []
    for case, title in CASES.items():
        for kind, path in TITLES.items():
            here = [each for each in found if (each["case"], each["kind"]) == (case, kind)]
            if here:
                table.append({"fold": title.name, "path": path, **_row(here)})
    return table


def _row(here: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    causes: Counter[str] = Counter()
    for each in here:
        causes.update(each["causes"])
    means = {cause: round(count / len(here)) for cause, count in causes.most_common()}
    failed = ", ".join(f"{cause} {mean}" for cause, mean in means.items() if mean)
    return {
        "seeds": f"{len(here)}" if here[0]["kind"] not in HEIGHTS else "-",
        "length of a hand's path [m]": ranged([each["path"] for each in here], 3),
        "distance from the target without errors [mm]": ranged([1e3 * each["distance"] for each in here], 1),
        f"succeeds, of {DRAWS} simulations (median)": ranged([each["succeeded"] for each in here], 0),
        "what fails (mean)": failed or "-",
        "simulations": ranged([each["simulations"] for each in here], 0) if "simulations" in here[0] else "-",
        "loads of processor time": ranged([each["processor"] for each in here], 0) if "processor" in here[0] else "-",
    }


def ranged(values: Sequence[float], digits: int) -> str:
    """Return the median, and the range if there is one."""
    low, middle, high = (f"{value:.{digits}f}" for value in (min(values), median(values), max(values)))
    return middle if low == high else f"{middle} ({low} to {high})"


def short(table: Sequence[Mapping[str, str]]) -> list[dict[str, str]]:
    """Return what the README shows: the folds of the towel, without the cost of the search."""
    left_out = ("fold", "simulations", "loads of processor time")
    towel = [row for row in table if row["fold"] == CASES["towel"].name]
    return [{name: row[name] for name in row if name not in left_out} for row in towel]


def draw(found: Sequence[Mapping[str, Any]], case: str, file: Path) -> None:
    """Draw the hands' ways from the side."""
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams.update({"svg.hashsalt": "tatamu", "svg.fonttype": "none"})  # the same bytes; text as text
    from matplotlib import pyplot

    task = CASES[case].task()
    figure, axes = pyplot.subplots(figsize=(7.0, 2.2), layout="constrained")
    colours = {CURVE: "#888888", LOWER: "#bbbbbb", UNDISTURBED: "#d95f02", LEARNED: "#1b6ca8"}
    for kind, title in TITLES.items():
        here = [each for each in found if (each["case"], each["kind"]) == (case, kind)]
        for number, each in enumerate(here):
            path = task.manipulation(each["parameters"]).paths[0]
            label = f"{title}, {median(one['path'] for one in here):.3f} m" if number == 0 else None
            axes.plot(*(path - path[0])[:, [0, 2]].T, color=colours[kind], lw=1.5, alpha=0.7, label=label)
    axes.set(xlabel="way over the table [m]", ylabel="height [m]", aspect="equal")
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, fontsize=7.5, ncols=2, handlelength=1.5, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    figure.savefig(file, metadata={"Date": None})


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--seeds", default="towel=5,tshirt=3,leg=3", help=f"how many of each of {', '.join(CASES)}")
    parser.add_argument("--jobs", type=int, default=1, help="processes side by side")
    parser.add_argument("--table", action="store_true", help="show what is there, and learn nothing")
    options = parser.parse_args()
    counts = dict(part.split("=") for part in options.seeds.split(","))
    wanted = jobs({case: int(counts[case]) for case in CASES if case in counts})
    options.out.mkdir(parents=True, exist_ok=True)
    if not options.table:
        run(wanted, options.out, options.jobs)
    found = [read_json(job.file(options.out)) for job in wanted if job.file(options.out).exists()]
    table = rows(found)
    show({"gains": table, "gains: short": short(table)}, options.write_docs)
    if options.write_docs:
        draw(found, "towel", IMAGES / "gains.svg")


if __name__ == "__main__":
    main()
