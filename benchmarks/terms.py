"""What air, friction of bending and shear would change in folds that were learned without them.

    python -m benchmarks.terms runs/towel runs/shop .. --out runs/terms [--write-docs]

Each folder holds a fold, or a plan of several, that was learned with the default fabric of its garment. It is replayed
with terms that were measured or are typical, one by one and all together: undisturbed, and in the worlds of the default
disturbances with none and with all of them. Goes on where it stopped.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import plate_in_air
from benchmarks.tables import markdown, publish
from tatamu.base.files import read_json, write_json
from tatamu.evaluation import Nominal
from tatamu.evaluation.disturbances import Stream, default_disturbances, sample_worlds
from tatamu.evaluation.robustness import Verdict
from tatamu.folding.score import Limits
from tatamu.folding.task import Task
from tatamu.simulation.material import Material
from tatamu.study.folder import ResultFolder
from tatamu.study.result import Result

SHEAR = {"towel": 34.0, "tshirt": 27.5, "trousers": 69.5}
"""Shear stiffness [N/m]: median of ten fabrics, grey interlock and black denim of Wang et al. 2011."""
STAYS = {"towel": 22.0, "tshirt": 22.0, "trousers": 49.0}
"""HB over B [1/m]: median of the four fabrics of Matsudaira et al. 2015, 18 to 53, as none is known of terry or jersey;
of six denims (J. Textiles 2016, 4614168, table 5: 23 to 54)."""
SIDE = 0.3
"""Of the plate whose air is carried [m]."""
SWING_RATE = 0.9
"""Swings per second by which air drags along the surface, as docs/theory/air.md has it [1/s]."""


def variants(garment: str, today: Material) -> dict[str, Material]:
    """Return the fabric with each term, and with all."""
    air = {
        "air_drag": 0.0,
        "air_added_mass": plate_in_air.rectangle_added_mass(SIDE, SIDE),
        "air_drag_quadratic": plate_in_air.steady_drag(),
        "air_drag_turning": plate_in_air.turning_drag(SIDE),
        "air_drag_tangential": plate_in_air.skin_drag(SWING_RATE),
    }
    friction = {"bending_hysteresis": STAYS[garment] * today.bending_rigidity}
    shear = {"shear_stiffness": SHEAR[garment]}
    terms = {"today": {}, "air": air, "friction": friction, "shear": shear, "all": {**air, **friction, **shear}}
    return {name: today.model_copy(update=changed) for name, changed in terms.items()}


def of_fabric(task: Task, material: Material) -> Task:
    """Return the same fold of another fabric, to the same target."""
    other = replace(task, garment=replace(task.garment, material=material))
    assert np.array_equal(other.fold.target, task.fold.target), "no term bends the target"
    return other


def replayed(step: Path, count: int, kept: Path) -> dict[str, Any]:
    """Return the distances of the replays of a step."""
    if kept.exists():
        found: dict[str, Any] = read_json(kept)
        return found
    learned = Result.load(step)
    parameters = learned.best.parameters
    worlds = sample_worlds(default_disturbances(), count, 0, Stream.JUDGING)
    shapes: dict[str, np.ndarray] = {}
    found = {}
    garment = learned.task.garment
    for name, material in variants(garment.name, garment.material).items():
        evaluate = Nominal(of_fabric(learned.task, material))
        nominal = evaluate(parameters)
        assert nominal.score is not None and nominal.rollout is not None, nominal.error
        shapes[name] = nominal.rollout.positions[-1]
        apart = np.linalg.norm(shapes[name] - shapes["today"], axis=1).mean()
        found[name] = {"off": nominal.score.mean_vertex_distance, "apart": float(apart), "holds": []}
        for world in worlds if name in ("today", "all") else ():
            verdict = Verdict.of(evaluate.in_world(parameters, world))
            found[name]["holds"].append(Limits().hold(verdict))
        print(kept.stem, name, found[name], flush=True)
    write_json(kept, found)
    return found


def share(held: list[bool]) -> str:
    """Return the number of worlds in which a fold holds."""
    return f"{sum(held)} of {len(held)}" if held else "–"


def steps_of(folder: Path) -> dict[str, Path]:
    """Return the folders of learned folds, by their names in the table."""
    results = ResultFolder(folder)
    if not results.holds_plan:
        return {folder.name: folder}
    return {f"{folder.name}-{step.path.name}": step.path for step in results.learned_steps()}


def rows(out: Path, worlds: int, folders: list[Path]) -> Iterator[dict[str, str]]:
    """Return a line of the table for each step of each fold."""
    for folder in folders:
        for label, step in steps_of(folder).items():
            found = replayed(step, worlds, out / f"{label}.json")
            off = {term: f"{1e3 * values['off']:.1f}" for term, values in found.items()}
            yield {
                "fold": label,
                "off the target today [mm]": off["today"],
                **{
                    f"{term}: off (moved)": f"{off[term]} ({1e3 * values['apart']:.1f})"
                    for term, values in found.items()
                    if term != "today"
                },
                "holds today": share(found["today"]["holds"]),
                "with all": share(found["all"]["holds"]),
            }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", type=Path, nargs="+", metavar="FOLDER")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--worlds", type=int, default=8, help="disturbed worlds of each fold")
    parser.add_argument("--write-docs", action="store_true", help="write the table into docs/notes/real-cloth.md")
    options = parser.parse_args()
    table = markdown(list(rows(options.out, options.worlds, options.folders)))
    print(table)
    if options.write_docs:
        publish("real: terms", table)


if __name__ == "__main__":
    main()
