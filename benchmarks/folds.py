"""Figures of docs/notes/folds.md: every garment's folds, learned with several seeds.

    python benchmarks/folds.py --out runs/folds [--seeds 3] [--trials 60] [--only NAME] [--targets] [--write-docs]

Prints a table and writes `table.json`; a plan that is there already is not run again. With `--write-docs` the table in
docs/notes/folds.md and its pictures are replaced.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.tables import IMAGES, SCORES, Columns, arguments, markdown, show, shown
from tatamu.api import learn
from tatamu.base.files import write_json
from tatamu.folding.fold import Fold, ideal_folds
from tatamu.folding.plans import PLANS
from tatamu.folding.task import make_task
from tatamu.garments import make_garment
from tatamu.report import picture
from tatamu.simulation.mesh.crossings import crossings
from tatamu.simulation.mesh.topology import Topology, edge_lengths
from tatamu.study.folder import ResultFolder
from tatamu.study.options import LearnOptions
from tatamu.study.record import ResultRecord
from tatamu.study.result import Result

FOLDS = {
    "tshirt-half": ("tshirt", "half", 3, 50),
    "trousers-half": ("trousers", "half", 3, 50),
    "tshirt-shop": ("tshirt", "shop", 2, 60),
    "trousers-thirds": ("trousers", "thirds", 1, 20),
    "towel-quarters": ("towel", "quarters", 1, 20),
}
"""Garment, fold, largest number of seeds, and trials for each step. Both plans of the trousers start with `leg`."""
COLUMNS: Columns = {
    "fold": lambda row: row["fold"],
    "seed": lambda row: row["seed"],
    "vertices": lambda row: row["vertices"],
    "trials": lambda row: row["trials"],
    **SCORES,
    "crossings, end (most)": lambda row: f"{row['crossings']['final']} ({row['crossings']['most']})",
    "from flat: mean distance [mm]": lambda row: f"{1e3 * row['whole']['mean_vertex_distance']:.2f}",
    "from flat: IoU": lambda row: f"{row['whole']['mask_iou']:.3f}",
    "failed trials": lambda row: row["failed"],
    "search [s]": lambda row: f"{row['seconds']:.0f}",
}
PICTURES = {
    "tshirt-half": ("tshirt-half-0", "A T-shirt folded in half"),
    "trousers-leg": ("trousers-half-0/step-1", "Trousers, leg over leg"),
    "trousers-half": ("trousers-half-0/step-2", "Trousers, hems to waist after leg over leg"),
    "tshirt-shop": ("tshirt-shop-0/step-3", "The last of the three steps of a T-shirt's shop fold"),
}
"""Pictures of the docs: the folder of a study, and what the picture shows."""


def target_rows() -> list[dict[str, str]]:
    """Faults of each ideal shape: layers that cross, and edges whose length is not that of the flat cloth."""
    rows = []
    for garment, plans in PLANS.items():
        made = make_garment(garment)
        for name, plan in plans.items():
            for number, fold in enumerate(ideal_folds(made, plan), start=1):
                away, strain = _strain(fold)
                rows.append(
                    {
                        "fold": f"{garment} {name}, {number}",
                        "M": str(fold.candidates),
                        "crossings": str(crossings(fold.target, made.faces)),
                        "edges longer than 5 % [%]": f"{100 * (strain > 0.05).mean():.2f}",
                        "edges shorter than 5 % [%]": f"{100 * (strain < -0.05).mean():.2f}",
                        "away from the crease, 99 % within [%]": f"{100 * np.quantile(np.abs(strain[away]), 0.99):.2f}",
                    }
                )
    return rows


def _strain(fold: Fold) -> tuple[np.ndarray, np.ndarray]:
    """Of every edge: whether it lies away from this fold's crease, and the relative change of its length."""
    garment = fold.garment
    rest = garment.vertices if garment.rest is None else garment.rest
    edges = Topology(garment.faces).edges
    wanted, flat = (edge_lengths(shape, edges) for shape in (fold.target, rest))
    distance = np.abs(fold.crease.split(fold.start)[0])
    return distance[edges].min(axis=1) > 4.5 * garment.material.bending_length, wanted / flat - 1.0


def learned(name: str, garment: str, fold: str, seed: int, trials: int, out: Path) -> list[dict[str, Any]]:
    """Learn a plan, or read it: one row for each step."""
    options = LearnOptions(trials=trials, seed=seed, disturbances="none", baselines=False)
    result = learn(make_task(garment, fold=fold), options, out=out / f"{name}-{seed}")
    if isinstance(result, Result):
        return [_row(_single(result.record), result.record, f"{garment} {fold}", seed)]
    return [
        _row(step.model_dump(), learned.record, f"{garment} {fold}, {number}. {step.title}", seed)
        for number, (step, learned) in enumerate(zip(result.record.steps, result.steps, strict=True), start=1)
    ]


def _row(step: dict[str, Any], result: ResultRecord, name: str, seed: int) -> dict[str, Any]:
    return {
        **step,
        "fold": name,
        "seed": seed,
        "vertices": result.task.vertices,
        "trials": len(result.trials),
        "failed": sum(trial.state == "failed" for trial in result.trials),
        "seconds": result.wall_seconds,
    }


def _single(result: ResultRecord) -> dict[str, Any]:
    """A fold in one step in the form of a step of a plan: its own target is the flat garment's."""
    best = result.best_trial.model_dump()
    crossings = result.crossings.model_dump() if result.crossings else None
    return {**best, "folder": ".", "title": "", "crossings": crossings, "whole": best}


def draw(out: Path, images: Path) -> str:
    """Draw the pictures of the docs: learned folds, and the shop fold's plan on the flat T-shirt; their Markdown."""
    links = ""
    for name, (folder, title) in PICTURES.items():
        if ResultFolder(out / folder).result_file.exists():
            picture(out / folder, images / f"{name}.png")
            links += f"\n\n![{title}](../images/{name}.png)"
    command = shutil.which("tatamu", path=str(Path(sys.executable).parent)) or "tatamu"
    subprocess.run([command, "show", "tshirt", "--plan", "shop", "--out", str(images / "shop-plan.png")], check=True)
    return links


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--trials", type=int, default=60)
    parser.add_argument("--only", choices=FOLDS, action="append")
    parser.add_argument("--targets", action="store_true", help="only the table of ideal shapes")
    options = parser.parse_args()
    show({"targets": target_rows()}, options.write_docs)
    if options.targets:
        return
    rows = []
    for name, (garment, fold, seeds, trials) in FOLDS.items():
        for seed in range(min(seeds, options.seeds)):
            if not options.only or name in options.only:
                rows += learned(name, garment, fold, seed, min(trials, options.trials), options.out)
                print(markdown(shown(rows[-1:], COLUMNS)), flush=True)
    write_json(options.out / "table.json", rows)
    drawings = draw(options.out, IMAGES) if options.write_docs else ""
    show({"folds": markdown(shown(rows, COLUMNS)) + drawings}, options.write_docs)


if __name__ == "__main__":
    main()
