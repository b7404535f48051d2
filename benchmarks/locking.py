"""Membrane locking: whether a small sheet drapes too stiffly whose cells are coarse for how hard it is to stretch.

    python benchmarks/locking.py [--write-docs]        the table of docs/notes/native.md; a few minutes on one core

A flat triangle cannot bend: cells that a sheet with curvature in two directions lies on must stretch, and they resist
that the more, the larger Y h^2 / B. A square sheet is held in its middle and drapes; what its border sinks is compared
with the same sheet, of the same Y, on cells of a quarter of a bending length.
"""

from __future__ import annotations

import argparse

import numpy as np
from tests.physics.scenes import held

from benchmarks.tables import markdown, publish
from tatamu import Scene, simulate
from tatamu.simulation.material import Material
from tatamu.simulation.mesh.meshing import staggered_rectangle
from tatamu.simulation.native.simulation import locking
from tatamu.simulation.scene import Cloth

SIDE, HELD = 0.16, 0.03
"""Of the sheet, and radius of what is held [m]."""
LIMP = Material(areal_density=0.15, stretch_stiffness=300.0, bending_rigidity=1e-5, air_drag=3.0)
STIFFNESSES = (100.0, 1000.0, 3000.0)
CELLS = (0.65, 0.5, 0.37)
"""Spacings in bending lengths."""
FINE = 0.25
SECONDS = 2.0
UNEVEN = 2e-4
"""Of the start [m]: an even sheet stays symmetric, and does not fold."""


def sunk(stiffness: float, cell: float) -> tuple[float, float]:
    """Mean depth of the border under the held middle [m], and Y h^2 / B."""
    material = LIMP.model_copy(update={"stretch_stiffness": stiffness})
    vertices, faces = staggered_rectangle(SIDE, SIDE, cell * material.bending_length)
    middle = np.flatnonzero(np.hypot(vertices[:, 0], vertices[:, 1]) < HELD)
    start = vertices + np.outer(UNEVEN * np.random.default_rng(1).normal(size=len(vertices)), [0.0, 0.0, 1.0])
    cloth = Cloth(vertices=start, faces=faces, rest_vertices=vertices)
    scene = Scene(cloth=cloth, material=material, grippers=[held(middle)], duration=SECONDS, frame_rate=20)
    end = simulate(scene).positions[-1]
    border = np.abs(vertices[:, :2]).max(axis=1) > SIDE / 2 - 1e-6
    return -float(end[border, 2].mean()), locking(cloth, material)


def rows() -> list[dict[str, str]]:
    """One row per stiffness and spacing."""
    found = []
    for stiffness in STIFFNESSES:
        right, _ = sunk(stiffness, FINE)
        for cell in CELLS:
            depth, ratio = sunk(stiffness, cell)
            found.append(
                {
                    "Y [N/m]": f"{stiffness:g}",
                    "cells [l_b]": f"{cell:g}",
                    "Y h² / B": f"{ratio:,.0f}",
                    "border sinks [mm]": f"{1e3 * depth:.1f}",
                    "on fine cells [mm]": f"{1e3 * right:.1f}",
                    "too little": f"{100 * (1 - depth / right):.0f} %",
                }
            )
    return found


def main() -> None:
    """Measure, print, and put the table into its page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write-docs", action="store_true")
    wanted = parser.parse_args().write_docs
    table = markdown(rows())
    print(table)
    if wanted:
        publish("locking", table)


if __name__ == "__main__":
    main()
