"""Folds that hold: what meshes, objectives and simulators say of learned folds in worlds that are a little off.

    python -m benchmarks.holds meshes                           the same worlds on four meshes
    python -m benchmarks.holds folds --out runs/holds           learned in disturbed worlds, and by least C
    python -m benchmarks.holds simulators --out runs/holds      two towels in Blender, or another simulator
    python -m benchmarks.holds two-meshes --out runs/holds      margins on two meshes against margins on the fold's own

Tables of docs/notes/margins.md; with `--write-docs` they replace the ones there. Everything goes on where it stopped:
a fold that was learned is not learned again, and no world is simulated twice. `--only CASE`, `--seeds` and `--learned`
restrict `folds` to some rows; the others of the table stay. `--known` publishes what is there, and learns nothing.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.tables import markdown, merged, publish, published
from tatamu.after.margins import Measured, measure
from tatamu.evaluation import Nominal
from tatamu.evaluation.disturbances import NOMINAL, Stream, default_disturbances, sample_worlds
from tatamu.evaluation.robustness import Verdict
from tatamu.folding.task import make_task
from tatamu.study.folder import ResultFolder
from tatamu.study.result import Result

MANIPULATIONS = {
    "x1 .08 z1 .19 x2 .44 z2 .02": {"x1": 0.08, "z1": 0.19, "x2": 0.44, "z2": 0.02, "g1": 0, "g2": 0},
    "x1 .05 z1 .28 x2 .78 z2 .03": {"x1": 0.05, "z1": 0.28, "x2": 0.78, "z2": 0.03, "g1": 0, "g2": 0},
    "x1 .04 z1 .13 x2 .31 z2 .44": {"x1": 0.04, "z1": 0.13, "x2": 0.31, "z2": 0.44, "g1": 0, "g2": 0},
}
"""Manipulations of the default towel."""
SPACINGS = (0.013, 0.020, 0.026, 0.030)
WORLDS = 16
LIMIT = 0.0125
JUDGING_SEED = 1
"""Random seed of the draws in which folds are compared."""
MARGINS_SEED = 0
"""Of those in which one mesh is compared with two, as `tatamu margins` has it."""
OBJECTIVES = {"least C": ["--disturbances", "none"], "in disturbed worlds": []}
"""Options of `tatamu learn`."""


@dataclass(frozen=True)
class Case:
    """A garment and a fold, as `tatamu learn` is asked for them."""

    name: str
    words: tuple[str, ...]
    draws: tuple[int, ...]
    """For the folds learned in disturbed worlds, by seed."""
    draws_of_least: tuple[int, ...]
    """For those of least C, whose share needs no such precision."""

    def folder(self, out: Path, seed: int, objective: str) -> Path:
        """Folder in which a fold is learned."""
        ending = "least" if objective == "least C" else "holds"
        return out / f"{self.name.replace(' ', '-')}-{seed}-{ending}"


CASES = (
    Case("towel half", ("towel",), (500, 500, 500), (100, 60, 60)),
    Case("towel quarters", ("towel", "--fold", "quarters"), (100, 100, 100), (60, 60, 60)),
    Case("trousers leg", ("trousers", "--fold", "leg"), (500, 500, 500), (60, 60, 60)),
    Case("tshirt half", ("tshirt",), (500, 500, 500), (60, 60, 60)),
    Case("trousers half", ("trousers", "--fold", "half"), (100, 100, 100), (60, 60, 60)),
    Case("tshirt shop", ("tshirt", "--fold", "shop"), (100,), (60,)),
)
ELSEWHERE = Case("towel half at 26 mm", ("towel", "--spacing", "0.026"), (48,), (48,))
"""The towel for other simulators, on a mesh on which they take seconds for a fold."""


def meshes(write: bool) -> None:
    """The same worlds on four meshes."""
    disturbances = default_disturbances()
    worlds = [NOMINAL, *sample_worlds(disturbances, WORLDS, 0, Stream.JUDGING)]
    rows = []
    for name, parameters in MANIPULATIONS.items():
        finest: np.ndarray | None = None
        for spacing in SPACINGS:
            task = make_task("towel", spacing=spacing)
            verdicts = [Verdict.of(Nominal(task).in_world(parameters, world)) for world in worlds]
            far = np.array([np.inf if v.mean_vertex_distance is None else v.mean_vertex_distance for v in verdicts])
            finest = far if finest is None else finest
            rows.append(
                {
                    "manipulation": name,
                    "mesh [mm]": f"{1e3 * spacing:g}",
                    "vertices": str(len(task.fold.start)),
                    "undisturbed": f"{1e3 * far[0]:.1f}",
                    "median": f"{1e3 * np.median(far[1:]):.1f}",
                    "90 %": f"{1e3 * np.quantile(far[1:], 0.9):.1f}",
                    "worst": f"{1e3 * far[1:].max():.1f}",
                    "fails in": f"{(far[1:] > LIMIT).sum()} of {WORLDS}",
                    "as on the finest": f"{((far > LIMIT) == (finest > LIMIT))[1:].sum()} of {WORLDS}",
                }
            )
            print(rows[-1], flush=True)
    show("margins: meshes", rows, write)


def learned(case: Case, seed: int, objective: str, out: Path, known: bool) -> list[Path]:
    """Learn a fold or a plan, unless it is there: the folders of its steps, those that are there."""
    folder = case.folder(out, seed, objective)
    ended = folder / "learned"
    if not ended.exists() and not known:
        words = ["learn", *case.words, *OBJECTIVES[objective], "--seed", str(seed), "--no-baselines"]
        subprocess.run(
            [sys.executable, "-m", "tatamu", *words, "--out", str(folder)], check=True, stdout=subprocess.DEVNULL
        )
        ended.touch()
    if not ended.exists():
        return []
    results = ResultFolder(folder)
    return [step.path for step in results.learned_steps()] if results.holds_plan else [folder]


def judged(
    folder: Path, draws: int, simulator: str | None = None, fine: bool = False, seed: int = JUDGING_SEED
) -> Measured:
    """All draws of a learned fold in the worlds that folds are compared in."""
    disturbances = default_disturbances()
    # one file for all seeds of a case, as two of them may find the same fold
    beside = folder.parent / f"draws-{simulator or 'native'}"
    return measure(
        Result.load(folder),
        disturbances,
        out=beside,
        draws=draws,
        seed=seed,
        simulator=simulator,
        fine=fine,
        alone=False,
        progress=lambda done, total: print(f"{folder.name}: {done} of {total}", flush=True) if done % 25 == 0 else None,
    )


def row(name: str, objective: str, measured: Measured) -> dict[str, str]:
    """Return a row of the table of folds."""
    result = measured.result
    spread = result.joint.mean_vertex_distance
    low, high = result.joint.interval
    spacing = result.mesh.own_spacing or result.mesh.spacing
    path = measured.learned.best.trajectory_length
    return {
        "fold": name,
        "learned": objective,
        "mesh [mm]": f"{1e3 * spacing:.3g}" + (f" ({1e3 * result.mesh.spacing:.3g})" if result.mesh.coarser else ""),
        "path [m]": f"{path:.3f}",
        "undisturbed [mm]": f"{1e3 * (result.undisturbed or np.nan):.1f}",
        "median": f"{1e3 * spread.median:.1f}",
        "90 %": f"{1e3 * spread.q90:.1f}",
        "worst": f"{1e3 * spread.worst:.1f}",
        "holds in": f"{result.joint.held} of {result.joint.draws} ({100 * low:.1f} to {100 * high:.1f} %)",
    }


@dataclass(frozen=True)
class Chosen:
    """The folds that are compared, as the command line names them; None: all."""

    cases: str | None
    seeds: str | None
    objectives: str | None

    def __contains__(self, fold: tuple[str, int, str]) -> bool:
        given = (self.cases, self.seeds, self.objectives)
        return all(names is None or str(value) in names.split(",") for names, value in zip(given, fold, strict=True))


def compared(chosen: Chosen, out: Path, known: bool) -> Iterator[dict[str, str]]:
    """Rows of folds, those learned in disturbed worlds first."""
    for case in CASES:
        for seed, counts in enumerate(zip(case.draws, case.draws_of_least, strict=True)):
            for objective, draws in zip(reversed(OBJECTIVES), counts, strict=True):
                if (case.name, seed, objective) not in chosen:
                    continue
                steps = learned(case, seed, objective, out, known)
                for number, folder in enumerate(steps, start=1):
                    step = f", step {number}" if len(steps) > 1 else ""
                    yield row(f"{case.name}{step}, seed {seed}", objective, judged(folder, draws))


def folds(out: Path, chosen: Chosen, known: bool, write: bool) -> None:
    """Folds learned in disturbed worlds against those of least C, in the same worlds that neither was learned in."""
    rows = []
    for found in compared(chosen, out, known):
        rows.append(found)
        print(found, flush=True)
    show("margins: folds", merged(published("margins: folds"), rows, "fold", "learned"), write)


def simulators(out: Path, known: bool, write: bool, draws: int, names: list[str]) -> None:
    """Folds of one mesh in several simulators, in the same worlds."""
    rows = []
    for simulator in names:
        for objective in reversed(OBJECTIVES):
            for folder in learned(ELSEWHERE, 0, objective, out, known):
                found = row(f"{ELSEWHERE.name}, in {simulator}", objective, judged(folder, draws, simulator, fine=True))
                rows.append(found)
                print(found, flush=True)
    show("margins: simulators", rows, write)


def two_meshes(out: Path, known: bool, write: bool) -> None:
    """The draws of `tatamu margins` on two meshes, and on the fold's own alone."""
    rows = []
    for folder in learned(CASES[0], 0, "in disturbed worlds", out, known):
        for fine in (False, True):
            measured = judged(folder, 200, fine=fine, seed=MARGINS_SEED)
            mesh = measured.result.mesh
            found = row("towel half, seed 0", "in disturbed worlds", measured)
            counts = {"simulations": measured.result.simulations, "on the fine mesh": mesh.own_simulations}
            rows.append({**found, **{name: str(count) for name, count in counts.items()}})
            print(rows[-1], flush=True)
    show("margins: two meshes", rows, write)


def show(name: str, rows: list[dict[str, str]], write: bool) -> None:
    """Print a table, and put it where the docs have it."""
    print(markdown(rows))
    if write:
        publish(name, markdown(rows))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["meshes", "folds", "simulators", "two-meshes"])
    parser.add_argument("--out", type=Path, default=Path("runs/holds"))
    parser.add_argument("--only", help=f"of {', '.join(case.name for case in CASES)}")
    parser.add_argument("--seeds", help="numbers, with commas")
    parser.add_argument("--learned", help=f"of {', '.join(OBJECTIVES)}")
    parser.add_argument("--known", action="store_true", help="only what was learned before")
    parser.add_argument("--draws", type=int, default=48, help="of `simulators`")
    parser.add_argument("--simulators", default="native,blender", help="names, with commas")
    parser.add_argument("--write-docs", action="store_true")
    options = parser.parse_args()
    if options.what == "meshes":
        meshes(options.write_docs)
    elif options.what == "folds":
        chosen = Chosen(options.only, options.seeds, options.learned)
        folds(options.out, chosen, options.known, options.write_docs)
    elif options.what == "simulators":
        names = options.simulators.split(",")
        simulators(options.out, options.known, options.write_docs, options.draws, names)
    else:
        two_meshes(options.out, options.known, options.write_docs)


if __name__ == "__main__":
    main()
