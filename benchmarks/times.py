"""How long whole commands take, as ratios to one rollout of the same run: the table "times" of docs/notes/learning.md.

    python -m benchmarks.times --out runs/times [--cases towel,tshirt,leg,disturbed,shop] [--seeds 1] [--write-docs]

Every command is a process of its own, one after the other, with compiled kernels there; its report and its three fixed
trajectories are part of it. The reference is one fold of the default towel on its default mesh, simulated before and
after every command, alone in a process: its mean is what a command is compared with, so that a busy or a slow machine
changes both. Processor seconds count those of all threads; with two processors to itself a command takes about half.
What was measured is kept in the folder and not run again; cases that were measured before have their rows too.
"""

from __future__ import annotations

import resource
import subprocess
import sys
from pathlib import Path
from shutil import rmtree
from statistics import median
from time import perf_counter
from typing import NamedTuple

from benchmarks.tables import arguments, markdown, merged, published, show
from tatamu.base.files import read_json, write_json
from tatamu.evaluation.nominal import Nominal
from tatamu.folding.baselines import triangle
from tatamu.folding.task import make_task
from tatamu.simulation.side_by_side import processors
from tatamu.study.folder import ResultFolder
from tatamu.study.record import PlanRecord, ResultRecord

NOMINAL = ["--disturbances", "none"]
CASES = {
    "towel": ["towel", *NOMINAL],
    "tshirt": ["tshirt", *NOMINAL],
    "leg": ["trousers", "--fold", "leg", *NOMINAL],
    "disturbed": ["towel"],
    "shop": ["tshirt", "--fold", "shop", "--trials", "60", *NOMINAL],
}
"""Arguments of `tatamu learn`."""
KEPT = "times.json"
"""File of a command's times in its folder."""


class Used(NamedTuple):
    """Times of a process [s]."""

    wall: float
    processor: float


class Measured(NamedTuple):
    """One command, and the reference rollout beside it."""

    command: Used
    reference: Used
    folder: ResultFolder

    @property
    def found(self) -> ResultRecord | PlanRecord:
        """Return the result of the command."""
        return self.folder.plan_record if self.folder.holds_plan else self.folder.record


def timed(words: list[str]) -> Used:
    """Run a command to its end."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    begin = perf_counter()
    subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
    wall = perf_counter() - begin
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return Used(wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)


def reference() -> Used:
    """Simulate one fold of the default towel, alone."""
    task = make_task("towel")
    begin = resource.getrusage(resource.RUSAGE_THREAD)
    outcome = Nominal(task).fixed(triangle(task.fold))
    end = resource.getrusage(resource.RUSAGE_THREAD)
    assert outcome.rollout is not None, "the fold is a plain one"
    return Used(outcome.rollout.info["wall_seconds"], end.ru_utime + end.ru_stime - begin.ru_utime - begin.ru_stime)


def folder_of(words: list[str], seed: int, out: Path) -> Path:
    """Folder in which a command is measured."""
    return out / "-".join([*(word.strip("-") for word in words), str(seed)])


def measured(words: list[str], seed: int, out: Path) -> Measured:
    """Run one command in an empty folder, between two reference rollouts; one that was measured is not run again."""
    folder = folder_of(words, seed, out)
    kept = folder / KEPT
    if not kept.exists():
        rmtree(folder, ignore_errors=True)
        around = [reference()]
        used = timed([sys.executable, "-m", "tatamu", *words, "--seed", str(seed), "--out", str(folder)])
        around.append(reference())
        mean = [sum(each) / 2 for each in zip(*around, strict=True)]
        write_json(kept, {"command": used, "reference": mean})
    times = read_json(kept)
    return Measured(Used(*times["command"]), Used(*times["reference"]), ResultFolder(folder))


def row(words: list[str], runs: list[Measured]) -> dict[str, str]:
    """A row of the table: medians over seeds, the worst fold."""
    worst = max((run.found for run in runs), key=_objective)
    if isinstance(worst, PlanRecord):
        fold = f"IoU from flat {worst.final.mask_iou:.3f}"
    else:
        fold = f"C {worst.best_trial.objective:.4f}, {1e3 * worst.best_score.mean_vertex_distance:.1f} mm"
        fold += f", {worst.success.headline}" if worst.success else ""
    return {
        "command": f"`{' '.join(['tatamu', *words])}`",
        "seeds": str(len(runs)),
        "seconds": f"{median(run.command.wall for run in runs):.0f}",
        "reference rollouts": f"{median(run.command.wall / run.reference.wall for run in runs):.0f}",
        "processor seconds": f"{median(run.command.processor for run in runs):.0f}",
        "of the reference's": f"{median(run.command.processor / run.reference.processor for run in runs):.0f}",
        "worst fold": fold,
    }


def _objective(found: ResultRecord | PlanRecord) -> float:
    if isinstance(found, PlanRecord):
        return -found.final.mask_iou
    return found.best_trial.objective or 0.0


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--cases", default="towel,tshirt,leg,disturbed", help=f"of {', '.join(CASES)}")
    parser.add_argument("--seeds", type=int, default=1)
    options = parser.parse_args()
    reference()  # loads the kernels
    rows = []
    wanted = options.cases.split(",")
    for case, given in CASES.items():
        words = ["learn", *given]
        there = [seed for seed in range(options.seeds) if (folder_of(words, seed, options.out) / KEPT).exists()]
        seeds = range(options.seeds) if case in wanted else there
        if seeds:
            rows.append(row(words, [measured(words, seed, options.out) for seed in seeds]))
            print(rows[-1], flush=True)
    one = reference()
    table = markdown(merged(published("times"), rows, "command"))
    note = f"{processors()} processors; the reference rollout took {one.processor:.2f} processor seconds."
    show({"times": f"{table}\n\n{note}"}, options.write_docs)


if __name__ == "__main__":
    main()
