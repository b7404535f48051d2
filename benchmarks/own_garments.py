"""Garments of examples/garments folded as their outlines propose: the table of docs/notes/own-garments.md.

    python -m benchmarks.own_garments --out runs/own-garments [--only hoodie sock] [--trials 50] [--write-docs]

Each garment is learned by the best proposal of `tatamu plans`; studies that are there go on.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from benchmarks.tables import insert, markdown

from tatamu.files import write_json
from tatamu.folding.task import make_job
from tatamu.learning import learn_job

GARMENTS = Path("examples/garments")
PAGE = Path("docs/notes/own-garments.md")
SPACING = 0.03
"""Edge length of the meshes [m], or a ninth of the shorter side where that is less."""
SUCCESS, SEEN = 0.0125, 0.80
"""Mean vertex distance [m] (BiFold 2025) and mask IoU (FoldBack 2026) that count as folded."""


def spacing_of(path: Path) -> float:
    """A spacing that makes trials quick, by the garment's size [m]."""
    from tatamu.garments import make_garment

    return float(min(SPACING, round(min(make_garment(str(path)).size) / 12, 3)))


def fold(path: Path, out: Path, trials: int, fine: bool) -> list[dict[str, Any]]:
    """Learn the best proposal for one garment; a row for each of its steps."""
    spacing = None if fine else spacing_of(path)
    job = make_job(str(path), fold="auto", spacing=spacing)
    learn_job(job, out, trials=trials, baselines=False)
    result = json.loads((out / "result.json").read_text())
    head = {"garment": job.garment.name, "vertices": len(job.garment.vertices), "trials": trials}
    if len(job.plan.steps) == 1:
        best = result["trials"][result["best"]]
        return [{**head, "step": job.plan.steps[0].title, "own": best, "whole": best, "crossings": result["crossings"]}]
    return [
        {
            **head,
            "step": f"{number}. {step['title']}",
            "own": step,
            "whole": step["whole"],
            "crossings": step["crossings"],
        }
        for number, step in enumerate(result["steps"], start=1)
    ]


def shown(row: dict[str, Any]) -> dict[str, Any]:
    """A row of the table."""
    whole = row["whole"]
    folded = whole["mean_vertex_distance"] < SUCCESS and whole["mask_iou"] >= SEEN
    return {
        "garment": row["garment"],
        "fold": row["step"],
        "vertices": row["vertices"],
        "trials": row["trials"],
        "mean distance [mm]": f"{1e3 * row['own']['mean_vertex_distance']:.1f}",
        "mask IoU": f"{row['own']['mask_iou']:.3f}",
        "from flat: mean distance [mm]": f"{1e3 * whole['mean_vertex_distance']:.1f}",
        "from flat: IoU": f"{whole['mask_iou']:.3f}",
        "crossings": row["crossings"]["final"],
        "folded": "yes" if folded else "no",
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--only", nargs="+", default=sorted(path.stem for path in GARMENTS.glob("*.toml")))
    parser.add_argument("--trials", type=int, default=50)
    parser.add_argument("--fine", action="store_true", help="on the default mesh")
    parser.add_argument("--write-docs", action="store_true")
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    table = given.out / "table.json"
    kept: dict[str, Any] = json.loads(table.read_text()) if table.exists() else {}
    for name in given.only:
        kept[name] = fold(GARMENTS / f"{name}.toml", given.out / name, given.trials, given.fine)
        write_json(table, kept)
        print(markdown([shown(row) for row in kept[name]]), flush=True)
    if given.write_docs:
        rows = [shown(row) for name in sorted(kept) for row in kept[name]]
        insert("own-garments-fine" if given.fine else "own-garments", markdown(rows), PAGE)


if __name__ == "__main__":
    main()
