"""The table of docs/native.md on bending: how far a cantilever's tip is off with R alone, C alone, their mean.

    python benchmarks/statics.py [--write-docs]

A strip held by its middle row sags a little under a load of 1 per area, B = 1: linear statics, no simulation.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from unittest.mock import patch

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import spsolve
from tables import insert, markdown

from tatamu.simulators.native import bending, membrane
from tatamu.simulators.native.frequencies import hinge_gradients
from tatamu.topology import Topology, areas, lumped
from tatamu.validation.meshes import LAYOUTS, mirrored
from tatamu.validation.scenes import raised

LENGTH, WIDTH = 0.10, 0.06
SPACINGS = (0.02, 0.01, 0.005)
CURVATURES: dict[str, Callable[[np.ndarray, np.ndarray], np.ndarray]] = {
    "R^-1": lambda R, C: np.asarray(np.linalg.inv(R)),
    "C": lambda R, C: C,
    "Q, their mean": bending.curvatures,
}


def tip(layout: str, spacing: float) -> float:
    """Sag of the tip over the exact w L^4 / 8 B, for B = w = 1."""
    plan, faces = mirrored(LAYOUTS[layout](LENGTH, WIDTH, spacing))
    rest, topology = raised(plan), Topology(faces)
    free = np.zeros(len(topology.hinges), dtype=bool)
    weights, others = bending.constants(rest, topology, membrane.rest_frames(rest, faces), free, 1.0)
    K = sparse.csr_array((weights.ravel(), (np.tile(np.arange(len(free)), 5), others.ravel())))
    G = hinge_gradients(rest, topology.hinges)[0][:, 2::3]
    S = (G.T @ K @ G).tocsr()
    loose = np.abs(plan[:, 0]) > 1e-12  # all but the middle row, where the slope is zero by symmetry
    sag = np.zeros(len(plan))
    sag[loose] = spsolve(S[loose][:, loose].tocsc(), lumped(areas(rest, faces), faces, len(rest))[loose])
    return float(sag[np.abs(plan[:, 0]) > LENGTH - 1e-9].mean() / (LENGTH**4 / 8))


def rows() -> list[dict[str, str]]:
    """Each layout: the error of the tip [%] for each way to find curvatures, on three meshes."""
    lines = []
    for layout in LAYOUTS:
        line = {"mesh": layout}
        for name, curvatures in CURVATURES.items():
            with patch.object(bending, "curvatures", curvatures):
                errors = [100 * (tip(layout, spacing) - 1.0) for spacing in SPACINGS]
            line[f"{name}: {', '.join(f'{1e3 * s:g}' for s in SPACINGS)} mm"] = ", ".join(f"{e:+.1f}" for e in errors)
        lines.append(line)
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write-docs", action="store_true")
    table = markdown(rows())
    print(table)
    if parser.parse_args().write_docs:
        insert("statics", table, Path("docs/native.md"))


if __name__ == "__main__":
    main()
