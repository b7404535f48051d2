"""Garments from elsewhere, folded in half: how near the Li 2015 and triangle trajectories and a few trials come.

    python -m benchmarks.foreign --out runs/foreign [--trials 8] [--write-docs]

The drawings and meshes are made by `tests/foreign.py`. Prints a table and writes `table.json`; studies that are there
go on. With `--write-docs` the table in docs/notes/garments.md is replaced.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tests.foreign import BROKEN, GOOD

from benchmarks.tables import arguments, show
from tatamu.api import learn
from tatamu.base.errors import InputError
from tatamu.base.files import write_json
from tatamu.folding.task import make_task
from tatamu.study.options import LearnOptions
from tatamu.study.result import Result

OWN_MESH = ("cloth_obj", "bag_ply", "tube_glb")
SPACING = 0.02
SUCCESS, SEEN = 0.0125, 0.80
"""Mean vertex distance [m] (BiFold 2025) and mask IoU (FoldBack 2026) that count as folded."""


def fold(kind: str, out: Path, trials: int) -> dict[str, Any]:
    """Fold one garment in half."""
    files = out / "files"
    files.mkdir(parents=True, exist_ok=True)
    path = GOOD[kind](files)
    try:
        task = make_task(str(path), fold="half", spacing=None if kind in OWN_MESH else SPACING)
        options = LearnOptions(trials=trials, seed=0, disturbances="none")
        result = learn(task, options, out=out / kind)
    except InputError as error:
        return {"garment": kind, "refused": str(error).replace(str(files) + "/", "")}
    assert isinstance(result, Result)
    baselines = [each.score.mean_vertex_distance for each in result.record.baselines if each.score]
    return {
        "garment": kind,
        "vertices": len(task.fold.garment.vertices),
        "mean_vertex_distance": result.score.mean_vertex_distance,
        "mask_iou": result.score.mask_iou,
        "baseline": min(baselines, default=None),
        "crossings": result.record.crossings.model_dump() if result.record.crossings else None,
    }


def shown(row: dict[str, Any]) -> dict[str, Any]:
    """Return a row of the table."""
    columns = {"garment": row["garment"], "vertices": "-", "mean distance [mm]": "-", "mask IoU": "-", "crossings": "-"}
    if "refused" in row:
        return {**columns, "folded": f"refused: {row['refused']}"}
    distance, seen = row["mean_vertex_distance"], row["mask_iou"]
    figures = {
        "vertices": row["vertices"],
        "mean distance [mm]": f"{1e3 * distance:.1f}",
        "mask IoU": f"{seen:.3f}",
        "crossings": row["crossings"]["final"],
    }
    return {**columns, **figures, "folded": "yes" if distance < SUCCESS and seen >= SEEN else "no"}


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--trials", type=int, default=8)
    given = parser.parse_args()
    rows = []
    for kind in GOOD:
        rows.append(fold(kind, given.out, given.trials))
        print(rows[-1], flush=True)
    write_json(given.out / "table.json", rows)
    show({"foreign": [shown(row) for row in rows]}, given.write_docs)
    print(f"{len(BROKEN)} broken ones are refused, see tests/foreign.py")


if __name__ == "__main__":
    main()
