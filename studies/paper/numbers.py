"""Writes the tables of docs/notes/reproduction.md.

The tables show how the paper's cloth (Tables I and II) behaves in Blender, the time of its simulation, and the results
of a run.

    python -m studies.paper.numbers [--run runs/paper] [--spacing 0.02] [--only cloth] [--write-docs]
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from benchmarks.tables import IMAGES, markdown, publish
from scipy.optimize import brentq
from tests.physics.scenes import held

from studies.paper.claims import TWO_PEAKS
from studies.paper.experiment import FOLDS, SPACING, Choices
from tatamu.folding.baselines import BASELINES
from tatamu.folding.trial_scene import scene_of
from tatamu.simulation.blender.process import WORKERS
from tatamu.simulation.heavy_strip import cantilever
from tatamu.simulation.material import GRAVITY, Material, load_material
from tatamu.simulation.mesh.meshing import staggered_rectangle
from tatamu.simulation.scene import Cloth, Scene
from tatamu.simulation.simulators import simulate

PARTS = ("cloth", "time", "run")
Row = dict[str, object]


def stiffness(material: Material, spacing: float, length: float = 0.6) -> float:
    """Return the stretch stiffness Y [N/m] of simulated cloth, from the stretch of a strip that hangs by its end."""
    flat, faces = staggered_rectangle(0.2, length, spacing)
    hung = np.column_stack([0 * flat[:, 0], flat[:, 1], flat[:, 0]])
    top, low = flat[:, 0] > length / 2 - 1e-9, flat[:, 0] < 1e-9 - length / 2
    cloth = Cloth(vertices=hung, faces=faces)
    rollout = simulate(
        Scene(cloth=cloth, material=material, grippers=[held(np.flatnonzero(top))], duration=4.0), "blender"
    )
    down = float((hung - rollout.positions[-1])[low, 2].mean())
    return material.areal_density * GRAVITY * length**2 / (2 * down)


def bending_length(material: Material, spacing: float) -> float:
    """Return the bending length l_b [m] of simulated cloth.

    A strip of the cloth is fixed at its middle row and hangs down on both sides. The bending length follows from the
    shape of the sides. Each side is as long as four edges of the mesh.
    """
    length = 4 * spacing
    flat, faces = staggered_rectangle(0.3, 2 * length, spacing)
    middle = np.flatnonzero(np.abs(flat[:, 0]) < 0.3 * spacing)
    scene = Scene(cloth=Cloth(vertices=flat, faces=faces), material=material, grippers=[held(middle)], duration=4.0)
    tip = simulate(scene, "blender").positions[-1][flat[:, 0] > length - 1e-6].mean(axis=0)
    wanted = np.arctan2(-tip[2], tip[0])

    def chord(gamma: float) -> float:
        x, y = cantilever(gamma)[-1]
        return float(np.arctan2(abs(y), x) - wanted)

    return float(length / brentq(chord, 0.02, 150.0) ** (1 / 3))


def cloths(spacing: float) -> list[Row]:
    """Return a table with the stretch stiffness and the bending length of the cloth of each garment."""
    rows: list[Row] = []
    for garment in FOLDS:
        material = load_material(Path(f"paper-{garment}"))
        length = bending_length(material, spacing)
        cells = {
            "Y [N/m]": f"{stiffness(material, spacing):.0f}",
            "l_b over spacing": f"{length / spacing:.2f}",
            "B [N m]": f"{material.areal_density * GRAVITY * length**3:.1e}",
            "the preset's Y": f"{material.stretch_stiffness:.0f}",
            "its B": f"{material.bending_rigidity:.1e}",
        }
        rows.append({"": garment, **cells})
    return rows


def times() -> list[Row]:
    """Return a table with the processor time of one fold and of fifty folds, without the time to start Blender.

    In these folds, the hands move along a triangle.
    """
    rows: list[Row] = []
    for garment in FOLDS:
        fold = Choices().task(garment).fold
        scene = scene_of(fold, BASELINES["triangle"][1](fold))
        seconds = spent(scene) - spent(scene.model_copy(update={"duration": 1.0 / scene.frame_rate}))
        rows.append(
            {
                "": garment,
                "vertices": len(scene.cloth.vertices),
                "scene [s]": f"{scene.duration:.1f}",
                "one fold, processor [s]": f"{seconds:.1f}",
                "50 folds, one core [min]": f"{50 * seconds / 60:.1f}",
            }
        )
    return rows


def spent(scene: Scene) -> float:
    """Return the processor time of Blender from its start to its end, while it simulates a scene [s]."""
    WORKERS.close()
    before = sum(os.times()[2:4])
    simulate(scene, "blender")
    WORKERS.close()
    return sum(os.times()[2:4]) - before


def outcomes(told: dict[str, Any]) -> list[Row]:
    """Return a table with the results of a run of `studies.paper`, by garment and by number of trials in the search."""
    return [
        {
            "garment": garment,
            "trials": moment["after"],
            "mean e_i [mm]": _mm(moment["mean_vertex_distance"]),
            "slip [mm]": _mm(moment["slip"]),
            "l_x [mm]": _mm(moment["trajectory_length"]),
        }
        for garment, found in told["garments"].items()
        for moment in found["moments"]
    ]


def answers(told: dict[str, Any]) -> list[Row]:
    """Return a table with the paper's claims, and the number of seeds for which each claim is true."""
    seeds = told["seeds"]
    rows: list[Row] = []
    for garment, found in told["garments"].items():
        medians, peaks = found["medians"], found["separation_of_peaks"]
        rows.append(
            {
                "garment": garment,
                "errors move left": f"{found['moved_left']} of {seeds}",
                "two peaks": f"{sum(peak > TWO_PEAKS for peak in peaks)} of {seeds}",
                "Ashman's D": ", ".join(f"{peak:.1f}" for peak in peaks),
                "slips less than the first": f"{found['slipped_less']} of {seeds}",
                "mask IoU": f"{medians['mask_iou']:.3f}",
                "edges through triangles": ", ".join(map(str, found["crossings_by_seed"])),
            }
        )
    return rows


def _mm(metres: float | None) -> str:
    return "failed" if metres is None else f"{1e3 * metres:.1f}"


def main() -> None:
    """Parse the command line, and print the tables of docs/notes/reproduction.md or write them into this file."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--spacing", type=float, default=SPACING)
    parser.add_argument("--run", type=Path, help="a folder of `studies.paper`, whose outcome is shown too")
    parser.add_argument("--only", nargs="+", choices=PARTS, default=list(PARTS))
    parser.add_argument("--write-docs", action="store_true", help="write the tables into docs/notes/reproduction.md")
    options = parser.parse_args()
    for mark, rows in tables(options):
        print(markdown(rows), flush=True)
        if options.write_docs:
            publish(mark, markdown(rows))
    if options.write_docs and options.run and "run" in options.only:
        shutil.copy(options.run / "figure-5.png", IMAGES / "reproduction.png")


def tables(options: argparse.Namespace) -> Iterator[tuple[str, list[Row]]]:
    """Yield the chosen tables of docs/notes/reproduction.md, each with the name of its marks in this file."""
    if "cloth" in options.only:
        yield "cloth", cloths(options.spacing)
    if "time" in options.only:
        yield "time", times()
    if "run" in options.only and options.run:
        told = json.loads((options.run / "reproduction.json").read_text())
        about = {key: told[key] for key in ("simulator", "seeds", "trials")}
        yield "run", [about]
        yield "outcomes", outcomes(told)
        yield "answers", answers(told)


if __name__ == "__main__":
    main()
