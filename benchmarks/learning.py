"""Figures of docs/learning.md: five seeds of the default towel, against random search and the fixed trajectories.

    python benchmarks/learning.py --out runs/learning [--seeds 5] [--trials 50]

Prints a table and writes `table.json`; a study that is there already is not run again.
"""

from __future__ import annotations

import argparse
import json
import resource
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from tatamu.folding.task import Task, make_task
from tatamu.learning import learn

MEASURES = ("objective", "trajectory_length", "mean_vertex_distance", "mask_iou", "area_error", "slip", "residual_bend")


def study(task: Task, folder: Path, sampler: str, seed: int, trials: int) -> dict[str, Any]:
    """Run one study, or read it; its best trial."""
    learn(task, folder, trials=trials, seed=seed, sampler=sampler)
    result = json.loads((folder / "result.json").read_text())
    best = result["trials"][result["best"]]
    shown = {**best, "seconds": result["wall_seconds"]}
    return {"sampler": sampler, "seed": seed, "best": result["best"], **shown, "all": result}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--trials", type=int, default=50)
    options = parser.parse_args()
    task = make_task("towel")
    rows = [
        study(task, options.out / f"{sampler}-{seed}", sampler, seed, options.trials)
        for seed in range(options.seeds)
        for sampler in ("gp", "random")
    ]
    rows += [{"sampler": b["name"], "seed": "", "best": "", **b} for b in rows[0]["all"]["baselines"]]
    table = Table(
        title=f"{task.fold.garment.name}, {len(task.fold.garment.vertices)} vertices, {options.trials} trials"
    )
    for column in ("search", "seed", "best trial", *MEASURES, "seconds"):
        table.add_column(column.replace("_", " "))
    for row in rows:
        shown = [f"{row[name]:.4f}" for name in MEASURES]
        table.add_row(row["sampler"], str(row["seed"]), str(row["best"]), *shown, f"{row['seconds']:.1f}")
    Console(width=170).print(table)
    for row in rows:
        row.pop("all", None)
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"peak memory {memory:.0f} MB")
    (options.out / "table.json").write_text(json.dumps({"rows": rows, "peak_memory_mb": memory}, indent=1))


if __name__ == "__main__":
    main()
