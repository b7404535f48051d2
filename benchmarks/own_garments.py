"""Garments of examples/garments folded as their outlines propose: the table of docs/notes/own-garments.md.

    python -m benchmarks.own_garments --out runs/own-garments [--only hoodie sock] [--trials 50] [--write-docs]

Each garment is learned by the best plan of `tatamu plans` on the meshes that `tatamu learn` makes by itself; studies
that are there go on.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from benchmarks.tables import arguments, markdown, show
from tatamu.api import learn
from tatamu.base.files import write_json
from tatamu.folding.task import make_task
from tatamu.study.options import LearnOptions
from tatamu.study.result import Result

GARMENTS = Path("examples/garments")
FULL = 50
"""Default number of trials of a step."""
SUCCESS = 0.0125
"""Mean vertex distance that counts as folded [m] (BiFold 2025)."""
SEEN = 0.80
"""Mask IoU that counts as folded (FoldBack 2026)."""


def fold(name: str, out: Path, trials: int) -> list[dict[str, Any]]:
    """Learn the best plan of one garment; return a row for each of its steps."""
    task = make_task(str(GARMENTS / f"{name}.toml"), fold="auto")
    options = LearnOptions(trials=trials, disturbances="none", baselines=False)
    result = learn(task, options, out=out)
    head = {"garment": name, "vertices": len(task.garment.vertices), "trials": trials}
    if isinstance(result, Result):
        best = result.score
        own = {"mean_vertex_distance": best.mean_vertex_distance, "mask_iou": best.mask_iou}
        crossings = result.record.crossings
        return [
            {**head, "step": task.title, "own": own, "whole": own, "crossings": crossings.final if crossings else None}
        ]
    return [
        {
            **head,
            "step": f"{number}. {step.title}",
            "own": {"mean_vertex_distance": learned.score.mean_vertex_distance, "mask_iou": learned.score.mask_iou},
            "whole": {"mean_vertex_distance": step.whole.mean_vertex_distance, "mask_iou": step.whole.mask_iou},
            "crossings": step.crossings.final,
        }
        for number, (step, learned) in enumerate(zip(result.record.steps, result.steps, strict=True), start=1)
    ]


def shown(row: dict[str, Any]) -> dict[str, Any]:
    """Return a row of the table."""
    own = row["own"]
    whole = row["whole"]
    folded = whole["mean_vertex_distance"] < SUCCESS and whole["mask_iou"] >= SEEN
    return {
        "garment": row["garment"],
        "fold": row["step"],
        "vertices": row["vertices"],
        "trials": row["trials"],
        "mean distance [mm]": f"{1e3 * own['mean_vertex_distance']:.1f}",
        "mask IoU": f"{own['mask_iou']:.3f}",
        "from flat: mean distance [mm]": f"{1e3 * whole['mean_vertex_distance']:.1f}",
        "from flat: IoU": f"{whole['mask_iou']:.3f}",
        "crossings": row["crossings"],
        "folded": "yes" if folded else "no",
    }


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--only", nargs="+", default=sorted(path.stem for path in GARMENTS.glob("*.toml")))
    parser.add_argument("--trials", type=int, default=FULL)
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    table = given.out / "table.json"
    kept: dict[str, Any] = json.loads(table.read_text()) if table.exists() else {}
    for name in given.only:
        kept[name] = fold(name, given.out / name, given.trials)
        write_json(table, kept)
        print(markdown([shown(row) for row in kept[name]]), flush=True)
    show({"own garments": [shown(row) for name in sorted(kept) for row in kept[name]]}, given.write_docs)


if __name__ == "__main__":
    main()
