"""Whether a search earns its fold: given curves, folds of least C and folds learned in disturbed worlds, over seeds.

    python -m benchmarks.earned --out runs/earned [--seeds tshirt=1,leg=1,towel=10] [--jobs 2]
    python -m benchmarks.earned --out runs/earned --table [--write-docs]

Each study runs in a process of its own on one core, and its fold is judged in 100 disturbed worlds that no search used,
on two meshes as in `tatamu margins`. Worlds in which no fold holds tell nothing of a fold: hands that are 20 mm off put
every fold off. So a fold holds in a share of the worlds in which any fold measured here does. A file of the folder
keeps what one study found, so that a killed run goes on; `--table` only shows what is there. Processor time is a
multiple of a load, 700 products of 300 x 300 matrices on one core, which is measured before and after each study: a
busy or a slow machine changes both.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from statistics import median
from time import process_time
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks.tables import IMAGES, markdown, merged, publish, published
from tatamu.api import learn
from tatamu.base.files import read_json, write_json
from tatamu.evaluation import CoarseFirst, Evaluator, Nominal
from tatamu.evaluation.disturbances import Stream, default_disturbances, sample_worlds
from tatamu.evaluation.robustness import FoldOnMesh, Judge, SuccessRate, VerdictCache
from tatamu.folding.parameters import first_curves
from tatamu.folding.score import Limits
from tatamu.folding.task import Task, make_task
from tatamu.search import Parameters
from tatamu.simulation.simulators import named
from tatamu.study.options import LearnOptions
from tatamu.study.result import Result

DRAWS = 100
UNUSED_SEED = 1000
"""Random seed of the worlds in which folds are judged, the same for all."""
GIVEN, LEAST, ROBUST = "given", "least C", "in disturbed worlds"
SHORTER = 0.97
"""Largest length of an earned fold's path, as a fraction of the best given curve's."""
ENOUGH = 0.99
"""Smallest share of the worlds, of those in which any fold holds, in which a fold must hold."""
LEAST_SEEDS = 1
"""A study of least C says what holding costs; one seed does."""
CURVES = 3
"""Of the curves that a search is given: both arched ones and the highest of the low ones."""


@dataclass(frozen=True)
class Case:
    """A garment and its fold."""

    name: str
    garment: str
    fold: str

    def task(self) -> Task:
        """The fold as a task."""
        return make_task(self.garment, fold=self.fold)


CASES = {
    "tshirt": Case("T-shirt in half", "tshirt", "half"),
    "leg": Case("trousers, leg over leg", "trousers", "leg"),
    "towel": Case("towel in half", "towel", "half"),
}


@dataclass(frozen=True)
class Job:
    """One study, or one given curve."""

    case: str
    kind: str
    number: int
    """The seed of a study, or the number of a curve."""

    def file(self, out: Path) -> Path:
        """File in which its result is kept."""
        return out / f"{self.case}-{self.kind.replace(' ', '-')}-{self.number}.json"


def jobs(seeds: Mapping[str, int]) -> list[Job]:
    """All that is to be measured, for numbers of seeds by case; the longest first."""
    studies = [Job(case, ROBUST, seed) for case, count in seeds.items() for seed in range(count)]
    least = [Job(case, LEAST, seed) for case, count in seeds.items() for seed in range(min(count, LEAST_SEEDS))]
    curves = [Job(case, GIVEN, number) for case in seeds for number in range(CURVES)]
    return [*studies, *least, *curves]


def load() -> float:
    """Processor time of a load [s]."""
    matrix = np.random.default_rng(0).random((300, 300))
    with threadpool_limits(1):
        begin = process_time()
        for _ in range(700):
            matrix @ matrix
        return process_time() - begin


def judged(task: Task, parameters: Parameters, workers: ThreadPoolExecutor) -> tuple[SuccessRate, list[bool]]:
    """How often a fold holds in the worlds that no search used, and in which of them."""
    evaluator: Evaluator = CoarseFirst(Nominal(task))
    low = evaluator.low_fidelity(parameters)
    judge = Judge(FoldOnMesh(evaluator, parameters), FoldOnMesh(*low) if low else None, workers, VerdictCache())
    worlds = sample_worlds(default_disturbances(), DRAWS, UNUSED_SEED, Stream.MARGINS)
    verdicts = judge.judge(worlds, Limits()).worlds
    return SuccessRate.of(task.fold, verdicts, Limits()), [Limits().hold(each.verdict) for each in verdicts]


def measure(job: Job, out: Path) -> None:
    """Learn and judge the fold, unless its result is kept."""
    file = job.file(out)
    if file.exists():
        return
    task = CASES[job.case].task()
    found: dict[str, Any] = {"case": job.case, "kind": job.kind, "number": job.number}
    with ThreadPoolExecutor(1) as workers:
        if job.kind == GIVEN:
            parameters = first_curves(task.fold)[job.number]
            score = Nominal(task)(parameters).score
        else:
            options = LearnOptions(seed=job.number, disturbances="none" if job.kind == LEAST else "default")
            before, begin = load(), process_time()
            result = learn(task, options, executor=workers)
            seconds = process_time() - begin
            assert isinstance(result, Result), "these plans have one step"
            parameters, score = result.best.parameters, result.score
            simulations = [trial.worlds or 1 for trial in result.trials]
            coarse = [result.record.is_coarse(trial) for trial in result.trials]
            found |= {
                "seconds": seconds,
                "loads": seconds / (0.5 * (before + load())),
                "coarse": sum(n for n, each in zip(simulations, coarse, strict=True) if each),
                "fine": sum(n for n, each in zip(simulations, coarse, strict=True) if not each),
                "given": result.record.best_is_given,
            }
        rate, holds = judged(task, parameters, workers)
    found |= {
        "path": task.manipulation(parameters).trajectory_length,
        "distance": None if score is None else score.mean_vertex_distance,
        "objective": None if score is None else score.objective,
        "q90": rate.mean_vertex_distance.q90,
        "holds": holds,
        "parameters": dict(parameters),
    }
    write_json(file, found)


def run(wanted: Sequence[Job], out: Path, count: int) -> None:
    """Measure what is not there, in processes side by side."""
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
        os.environ[name] = "1"
    named("native").prepare()  # kernels are compiled once
    left = [job for job in wanted if not job.file(out).exists()]
    with ProcessPoolExecutor(count, mp_context=get_context("spawn")) as pool:
        futures = {pool.submit(measure, job, out): job for job in left}
        for done, future in enumerate(as_completed(futures), 1):
            future.result()
            print(f"{done}/{len(left)}", futures[future].file(out).name, flush=True)


def known(wanted: Sequence[Job], out: Path) -> list[dict[str, Any]]:
    """What was measured, with the share of the worlds in which a fold holds, of those in which any of its case does."""
    found: list[dict[str, Any]] = [read_json(job.file(out)) for job in wanted if job.file(out).exists()]
    for each in found:
        able = np.any([other["holds"] for other in found if other["case"] == each["case"]], axis=0)
        each |= {"able": int(able.sum()), "held": sum(each["holds"]) / max(1, int(able.sum()))}
    return found


def measured_cases(found: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return the names of the cases with a learned fold, the towel first."""
    return [name for name in reversed(CASES) if any(each["case"] == name and each["kind"] != GIVEN for each in found)]


def best_given(found: Sequence[Mapping[str, Any]], case: str) -> Mapping[str, Any]:
    """The shortest of the given curves that hold as often as is asked; otherwise the one that holds most often."""
    curves = [each for each in found if each["case"] == case and each["kind"] == GIVEN]
    able = [each for each in curves if each["held"] >= ENOUGH]
    return min(able, key=lambda each: each["path"]) if able else max(curves, key=lambda each: each["held"])


def rows(found: Sequence[Mapping[str, Any]]) -> list[dict[str, str]]:
    """Return one row for each case and way to a fold."""
    table = []
    for case in measured_cases(found):
        given = best_given(found, case)
        for kind, title in ((GIVEN, "best given curve"), (LEAST, "learned, least C"), (ROBUST, "learned to hold")):
            here = [each for each in found if each["case"] == case and each["kind"] == kind]
            here = [given] if kind == GIVEN else here
            if here:
                table.append({"fold": CASES[case].name, "path": title, **_row(here, given, studied=kind != GIVEN)})
    return table


def _row(here: Sequence[Mapping[str, Any]], given: Mapping[str, Any], studied: bool) -> dict[str, str]:
    paths = [each["path"] for each in here]
    held = [each["held"] for each in here]
    earned = sum(each["path"] <= SHORTER * given["path"] for each in here)
    loads = f"{median(each['loads'] for each in here):.0f}" if studied else "-"
    return {
        "seeds": f"{len(here)}" if studied else "-",
        "length [m], median": f"{median(paths):.3f}",
        "shortest to longest": f"{min(paths):.3f} to {max(paths):.3f}" if studied else "-",
        "3 % shorter than the best given": f"{earned} of {len(here)}" if studied else "-",
        "error undisturbed [mm]": f"{1e3 * median(each['distance'] for each in here):.1f}",
        "error in 90 % of the worlds [mm]": f"{1e3 * median(each['q90'] for each in here):.1f}",
        "holds, median": f"{100 * median(held):.1f} %",
        "least often": f"{100 * min(held):.1f} %",
        "of so many worlds": f"{here[0]['able']} of {DRAWS}",
        "loads": loads,
    }


TITLES = {
    "best given curve": "best curve that a search is given",
    "learned, least C": "learned without disturbances",
    "learned to hold": "learned with disturbances, the default",
}
"""Paths of the long table, as the README calls them."""


def short(table: Sequence[Mapping[str, str]]) -> list[dict[str, str]]:
    """Return the part of the long table that the README has."""
    return [
        {
            "fold": row["fold"],
            "path": TITLES[row["path"]],
            "length of a hand's path [m]": row["length [m], median"],
            "undisturbed, mean distance from the target [mm]": row["error undisturbed [mm]"],
            "holds, of the simulations in which any fold does": f"{float(row['holds, median'].rstrip(' %')):.0f} %",
        }
        for row in table
    ]


def draw(found: Sequence[Mapping[str, Any]], case: str, file: Path) -> None:
    """Draw the hands' ways from the side: the best given curve, and what each study found."""
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams.update({"svg.hashsalt": "tatamu", "svg.fonttype": "none"})  # the same bytes; text as text
    from matplotlib import pyplot

    task = CASES[case].task()
    figure, axes = pyplot.subplots(figsize=(7.0, 2.0), layout="constrained")
    given = best_given(found, case)
    styles = {
        GIVEN: ("#888888", "best given curve"),
        LEAST: ("#d95f02", "learned without disturbances"),
        ROBUST: ("#1b6ca8", "learned with disturbances"),
    }
    for kind, (colour, title) in styles.items():
        studies = [each for each in found if each["case"] == case and each["kind"] == kind]
        for number, each in enumerate([given] if kind == GIVEN else studies):
            path = task.manipulation(each["parameters"]).paths[0]
            lengths = f"{median(one['path'] for one in ([given] if kind == GIVEN else studies)):.3f} m"
            label = f"{title}, {lengths}" if number == 0 else None
            axes.plot(
                *(path - path[0])[:, [0, 2]].T, color=colour, lw=1.5, alpha=1.0 if kind == GIVEN else 0.6, label=label
            )
    axes.set(xlabel="way over the table [m]", ylabel="height [m]", aspect="equal")
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, fontsize=7.5, ncols=3, handlelength=1.5, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    figure.savefig(file, metadata={"Date": None})


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--seeds", default="tshirt=1,leg=1,towel=10", help=f"how many of each of {', '.join(CASES)}")
    parser.add_argument("--jobs", type=int, default=2, help="processes side by side")
    parser.add_argument("--table", action="store_true", help="show what is there, and learn nothing")
    parser.add_argument("--write-docs", action="store_true")
    options = parser.parse_args()
    counts = dict(part.split("=") for part in options.seeds.split(","))
    wanted = jobs({case: int(counts[case]) for case in CASES if case in counts})
    options.out.mkdir(parents=True, exist_ok=True)
    if not options.table:
        run(wanted, options.out, options.jobs)
    found = known(wanted, options.out)
    table = merged(published("earned"), rows(found), "fold", "path")
    print(markdown(table))
    if options.write_docs:
        publish("earned", markdown(table))
        publish("earned: short", markdown(short(table)))
        if "towel" in measured_cases(found):
            draw(found, "towel", IMAGES / "earned.svg")


if __name__ == "__main__":
    main()
