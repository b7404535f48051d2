"""The table of docs/notes/native.md on bending: how far a cantilever's tip is off with R alone, C alone, and Q.

    python benchmarks/statics.py [--write-docs]

A strip held by its middle row sags a little under a load of 1 per area, B = 1: linear statics, no simulation.
"""

from __future__ import annotations

import argparse
from functools import partial

import numpy as np
from tests.physics.meshes import LAYOUTS, Layout, irregular, mirrored, turned
from tests.physics.scenes import raised

from benchmarks.tables import markdown, publish
from tatamu.simulation.mesh.topology import Topology, areas, lumped
from tatamu.simulation.native.elastic import curvature, membrane
from tatamu.simulation.native.elastic.stable_step import hinge_gradients, hinge_stiffness
from tatamu.simulation.native.options import ElasticOptions

LENGTH, WIDTH = 0.10, 0.06
SPACINGS = (0.02, 0.01, 0.005)
PARTS = {"R^-1": 0.0, "C": 1.0, "Q": ElasticOptions().angle_sum_part}
"""Fraction of C in the operator that gives curvatures."""
OTHERS: dict[str, list[Layout]] = {
    "8 more irregular": [partial(irregular, seed=seed) for seed in range(2, 10)],
    "6 more angles": [partial(turned, degrees=angle) for angle in (7.0, 13.0, 20.0, 26.0, 35.0, 41.0)],
}
"""Meshes that no textbook check has: the part of C in Q was chosen on them."""


def tip(layout: Layout, spacing: float, angle_sum_part: float = PARTS["Q"]) -> float:
    """Sag of the tip over the exact w L^4 / 8 B, for B = w = 1."""
    plan, faces = mirrored(layout(LENGTH, WIDTH, spacing))
    rest, topology = raised(plan), Topology(faces)
    free = np.zeros(len(topology.hinges), dtype=bool)
    curved = curvature.maps(rest, topology, membrane.rest_frames(rest, faces), free, angle_sum_part)
    K = curvature.stiffness(curved, np.diag([1.0, 1.0, 2.0]))
    at = curved.hinges
    G = hinge_gradients(rest, topology.hinges)[0][:, 2::3]
    loose = np.abs(plan[:, 0]) > 1e-12  # all but the middle row, about which a load on both sides turns nothing
    turn = plan[loose, 0] / np.linalg.norm(plan[loose, 0])
    S = (G.T @ hinge_stiffness(K, at, len(topology.hinges)) @ G).toarray()[np.ix_(loose, loose)]
    sag = np.zeros(len(plan))
    load = lumped(areas(rest, faces), faces, len(rest))[loose]
    sag[loose] = np.linalg.solve(S + S.diagonal().mean() * np.outer(turn, turn), load)
    return float(sag[np.abs(plan[:, 0]) > LENGTH - 1e-9].mean() / (LENGTH**4 / 8))


def rows() -> list[dict[str, str]]:
    """Each layout: the error of the tip [%] for each map to curvatures, on three meshes; of several their mean."""
    lines = []
    for kind, layouts in ({name: [layout] for name, layout in LAYOUTS.items()} | OTHERS).items():
        line = {"mesh": kind}
        for name, part in PARTS.items():
            errors = np.array([[100 * (tip(layout, s, part) - 1.0) for s in SPACINGS] for layout in layouts])
            line[f"{name}: {', '.join(f'{1e3 * s:g}' for s in SPACINGS)} mm"] = ", ".join(map(_words, errors.T))
        lines.append(line)
    return lines


def _words(errors: np.ndarray) -> str:
    return f"{errors.mean():+.1f}" + (f" ± {errors.std():.1f}" if len(errors) > 1 else "")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write-docs", action="store_true")
    table = markdown(rows())
    print(table)
    if parser.parse_args().write_docs:
        publish("statics", table)


if __name__ == "__main__":
    main()
