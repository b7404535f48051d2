"""Figures of README and docs/notes/learning.md: five seeds of the default towel, random search, fixed trajectories.

Trials one by one, all on the default mesh: what the sampler is worth without help.

    python benchmarks/learning.py --out runs/learning [--seeds 5] [--trials 50] [--write-docs]

Prints a table and writes `table.json`; a study that is there already is not run again. With `--write-docs` the tables
in README.md and docs/notes/learning.md are replaced.
"""

from __future__ import annotations

import argparse
import resource
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from tables import markdown, publish

from tatamu.api import Result, learn
from tatamu.files import write_json
from tatamu.folding.task import Task, make_task
from tatamu.options import LearnOptions
from tatamu.search import register_search
from tatamu.search.gp import GPSearch

COLUMNS = {
    "search": lambda row: row["search"],
    "seed": lambda row: row["seed"],
    "best trial": lambda row: row["best"],
    "C": lambda row: f"{row['objective']:.4f}",
    "l_x [m]": lambda row: f"{row['trajectory_length']:.3f}",
    "mean distance [mm]": lambda row: f"{1e3 * row['mean_vertex_distance']:.2f}",
    "mask IoU": lambda row: f"{row['mask_iou']:.3f}",
    "E_f [%]": lambda row: f"{row['area_error']:.2f}",
    "slip [mm]": lambda row: f"{1e3 * row['slip']:.2f}",
    "residual bend [mm]": lambda row: f"{1e3 * row['residual_bend']:.1f}",
    "failed trials": lambda row: row["failed"],
    "search [s]": lambda row: f"{row['seconds']:.0f}",
}
SHORT = ("search", "C", "mean distance [mm]", "mask IoU", "E_f [%]")


ALONE = {"gp": "gp alone", "random": "random"}
"""Searches, and the names under which they are not given the curves that `gp` starts with."""
register_search(ALONE["gp"], GPSearch)


def study(task: Task, folder: Path, sampler: str, seed: int, trials: int) -> tuple[dict[str, Any], list[Any]]:
    """Run one study, or read it: its best trial, and its baselines."""
    options = LearnOptions(
        trials=trials, seed=seed, sampler=ALONE[sampler], parallel=1, disturbances="none", coarse=False
    )
    learned = learn(task, options, out=folder)
    assert isinstance(learned, Result)
    result = learned.record
    failed = sum(trial.state == "failed" for trial in result.trials)
    row = {**result.best_trial.model_dump(), "seconds": result.wall_seconds, "failed": failed}
    baselines = [baseline.model_dump() for baseline in result.baselines]
    return {"search": sampler, "seed": seed, "best": result.best, **row}, baselines


def shown(rows: list[dict[str, Any]], columns: Iterable[str] = COLUMNS) -> list[dict[str, Any]]:
    """Some columns of searches and baselines."""
    return [{name: COLUMNS[name](row) for name in columns} for row in rows]


def summary(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Worst seed of each search, and the baselines."""
    searches = dict.fromkeys(row["search"] for row in rows)
    worst = []
    for search in searches:
        own = [row for row in rows if row["search"] == search]
        high = {key: max(row[key] for row in own) for key in ("objective", "mean_vertex_distance", "area_error")}
        name = f"{search}, worst of {len(own)} seeds" if len(own) > 1 else search
        worst.append({**own[0], **high, "mask_iou": min(row["mask_iou"] for row in own), "search": name})
    return worst


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--trials", type=int, default=50)
    parser.add_argument("--write-docs", action="store_true")
    options = parser.parse_args()
    task, rows, baselines = make_task("towel"), [], []
    for sampler in ("gp", "random"):
        for seed in range(options.seeds):
            row, baselines = study(task, options.out / f"{sampler}-{seed}", sampler, seed, options.trials)
            rows.append(row)
    rows += [{"search": b["title"], "seed": "-", "best": "-", "failed": "-", **b} for b in baselines]
    write_json(options.out / "table.json", rows)
    print(markdown(shown(rows)))
    print(f"\npeak memory of this process {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MB")
    if options.write_docs:
        publish("learning: short", markdown(shown(summary(rows), SHORT)))
        publish("learning: long", markdown(shown(rows)))


if __name__ == "__main__":
    main()
