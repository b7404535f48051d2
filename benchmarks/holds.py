"""Folds that hold: what meshes, objectives and simulators say of learned folds in worlds that are a little off.

    python benchmarks/holds.py meshes            docs/notes/margins.md: the same worlds on four meshes

Everything goes on where it stopped.
"""

from __future__ import annotations

import argparse

import numpy as np
from benchmarks.tables import markdown, publish

from tatamu.disturbances import CALM, Stream, drawn, judge, load_disturbances
from tatamu.folding.task import make_task

MANIPULATIONS = {
    "x1 .08 z1 .19 x2 .44 z2 .02": {"x1": 0.08, "z1": 0.19, "x2": 0.44, "z2": 0.02, "g1": 0, "g2": 0},
    "x1 .05 z1 .28 x2 .78 z2 .03": {"x1": 0.05, "z1": 0.28, "x2": 0.78, "z2": 0.03, "g1": 0, "g2": 0},
    "x1 .04 z1 .13 x2 .31 z2 .44": {"x1": 0.04, "z1": 0.13, "x2": 0.31, "z2": 0.44, "g1": 0, "g2": 0},
}
"""Manipulations of the default towel."""
SPACINGS = (0.013, 0.020, 0.026, 0.030)
WORLDS = 16
LIMIT = 0.0125


def meshes() -> None:
    disturbances = load_disturbances("default")
    assert disturbances is not None
    worlds = [CALM, *drawn(disturbances, WORLDS, 0, Stream.JUDGING)]
    rows = []
    for name, parameters in MANIPULATIONS.items():
        finest: np.ndarray | None = None
        for spacing in SPACINGS:
            task = make_task("towel", spacing=spacing)
            manipulation = task.manipulation(parameters)
            verdicts = [judge(task, manipulation, world) for world in worlds]
            far = np.array([np.inf if v.mean_vertex_distance is None else v.mean_vertex_distance for v in verdicts])
            finest = far if finest is None else finest
            rows.append(
                {
                    "manipulation": name,
                    "mesh [mm]": f"{1e3 * spacing:g}",
                    "vertices": len(task.fold.start),
                    "undisturbed": f"{1e3 * far[0]:.1f}",
                    "median": f"{1e3 * np.median(far[1:]):.1f}",
                    "90 %": f"{1e3 * np.quantile(far[1:], 0.9):.1f}",
                    "worst": f"{1e3 * far[1:].max():.1f}",
                    "fails in": f"{(far[1:] > LIMIT).sum()} of {WORLDS}",
                    "as on the finest": f"{((far > LIMIT) == (finest > LIMIT))[1:].sum()} of {WORLDS}",
                }
            )
            print(rows[-1], flush=True)
    publish("margins: meshes", markdown(rows))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["meshes"])
    parser.parse_args()
    meshes()


if __name__ == "__main__":
    main()
