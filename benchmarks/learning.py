"""Write the figures of docs/notes/learning.md: five seeds of the default towel, random search, fixed curves.

Trials run one by one, all on the default mesh, and no curves are given, so the table compares the searches alone.

    python benchmarks/learning.py --out runs/learning [--seeds 5] [--trials 50] [--write-docs]

Prints a table and writes `table.json`. Finished studies in the folder are not repeated. `--write-docs` replaces the
table in docs/notes/learning.md.
"""

from __future__ import annotations

import resource
from pathlib import Path
from typing import Any

from benchmarks.tables import SCORES, Columns, arguments, show, shown
from tatamu.api import learn
from tatamu.base.files import write_json
from tatamu.folding.task import Task, make_task
from tatamu.search import register_search
from tatamu.search.gp import GPSearch
from tatamu.study.options import LearnOptions
from tatamu.study.result import Result

COLUMNS: Columns = {
    "search": lambda row: row["search"],
    "seed": lambda row: row["seed"],
    "best trial": lambda row: row["best"],
    "C": lambda row: f"{row['objective']:.4f}",
    "l_x [m]": lambda row: f"{row['trajectory_length']:.3f}",
    **SCORES,
    "failed trials": lambda row: row["failed"],
    "search [s]": lambda row: f"{row['seconds']:.0f}",
}
ALONE = {"gp": "gp alone", "random": "random"}
"""Searches, and the names under which they are not given the curves that `gp` starts with."""
register_search(ALONE["gp"], GPSearch)


def study(task: Task, folder: Path, sampler: str, seed: int, trials: int) -> tuple[dict[str, Any], list[Any]]:
    """Run one study, or read it: its best trial, and its baselines."""
    options = LearnOptions(trials=trials, seed=seed, sampler=ALONE[sampler], parallel=1, disturbances="none")
    learned = learn(task, options, out=folder)
    assert isinstance(learned, Result)
    result = learned.record
    failed = sum(trial.state == "failed" for trial in result.trials)
    row = {**result.best_trial.model_dump(), "seconds": result.wall_seconds, "failed": failed}
    baselines = [baseline.model_dump() for baseline in result.baselines]
    return {"search": sampler, "seed": seed, "best": result.best, **row}, baselines


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--trials", type=int, default=50)
    options = parser.parse_args()
    task = make_task("towel")
    rows: list[dict[str, Any]] = []
    baselines: list[dict[str, Any]] = []
    for sampler in ("gp", "random"):
        for seed in range(options.seeds):
            row, baselines = study(task, options.out / f"{sampler}-{seed}", sampler, seed, options.trials)
            rows.append(row)
    rows += [{"search": b["title"], "seed": "-", "best": "-", "failed": "-", **b} for b in baselines]
    write_json(options.out / "table.json", rows)
    show({"learning: long": shown(rows, COLUMNS)}, options.write_docs)
    print(f"peak memory of this process {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MB")


if __name__ == "__main__":
    main()
