"""How the given curves fold a T-shirt and trousers of their former and of their present default fabric.

    python -m benchmarks.fabrics [--write-docs]

Every curve that a search is given is simulated without disturbances on the garment's usual mesh. Two minutes.
"""

from __future__ import annotations

import argparse
from time import process_time

from benchmarks.tables import markdown, publish
from tatamu.evaluation import Nominal
from tatamu.folding.parameters import first_curves
from tatamu.folding.score import Score
from tatamu.folding.task import make_task
from tatamu.simulation.simulators import named

CASES = (("T-shirt in half", "tshirt", "half", "jersey"), ("trousers, leg over leg", "trousers", "leg", "denim"))
"""Name, garment, fold and former fabric; the present one is the garment's default."""


def row(name: str, garment: str, fold: str, fabric: str | None) -> dict[str, str]:
    """Simulate the given curves on one fabric."""
    task = make_task(garment, fold=fold, material=fabric)
    begin = process_time()
    found = [Nominal(task)(curve).score for curve in first_curves(task.fold)]
    seconds = process_time() - begin
    scores: list[Score] = [each for each in found if each is not None]
    cloth = task.garment.material
    return {
        "fold": name,
        "fabric": fabric or "the default",
        "weight [g/m2]": f"{1e3 * cloth.areal_density:.0f}",
        "B [uN m]": f"{1e6 * cloth.bending_rigidity:.1f}",
        "bending length [mm]": f"{1e3 * cloth.bending_length:.1f}",
        "vertices": f"{len(task.garment.vertices):,}",
        "errors of the given curves [mm]": ", ".join(f"{1e3 * each.mean_vertex_distance:.1f}" for each in scores),
        "least overlap": f"{min(each.mask_iou for each in scores):.2f}",
        "failed": f"{len(found) - len(scores)} of {len(found)}",
        "seconds": f"{seconds / len(found):.1f}",
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write-docs", action="store_true")
    options = parser.parse_args()
    named("native").prepare()  # kernels are compiled once
    rows = []
    for name, garment, fold, former in CASES:
        for fabric in (former, None):
            rows.append(row(name, garment, fold, fabric))
        before, after = (float(each.pop("seconds")) for each in rows[-2:])
        rows[-2]["time"], rows[-1]["time"] = "1", f"{after / before:.2f}"
    table = markdown(rows)
    print(table)
    if options.write_docs:
        publish("fabrics", table)


if __name__ == "__main__":
    main()
