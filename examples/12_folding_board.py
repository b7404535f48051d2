"""A folding board folds a towel: two boards, of which one turns over on its hinge and back again.

python examples/12_folding_board.py [PICTURE.png]
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from tatamu import Cloth, Material, Scene, simulate
from tatamu.garments import towel
from tatamu.report.still import scene_picture
from tatamu.show.image import save_png
from tatamu.simulation.body import Body

SIDE = 0.12
"""Half the length of each board across the hinge, and along it [m]."""
THICKNESS = 0.003
"""Half the thickness of the boards [m]."""
FRAME = 84
"""Frame of the picture: the flap turns back and leaves the folded half behind."""
TURN = np.radians(150.0)
"""How far the flap turns over."""


def boards() -> list[Body]:
    """A board that lies, and a flap on a hinge along y: it turns over in half a second, waits, and turns back."""
    times = np.concatenate([[0.0], np.linspace(0.2, 0.7, 31), np.linspace(1.0, 1.6, 31)])
    angles = np.concatenate([[0.0], np.linspace(0.0, TURN, 31), np.linspace(TURN, 0.0, 31)])
    lying = Body(name="board", shape="box", size=[SIDE, SIDE, THICKNESS], positions=[[-SIDE - 0.001, 0.0, -THICKNESS]])
    x, z = SIDE + 0.001, -THICKNESS  # the centre of the flap, from the hinge
    flap = Body(
        name="flap",
        shape="box",
        size=[SIDE, SIDE, THICKNESS],
        times=times.tolist(),
        positions=[[x * np.cos(a) - z * np.sin(a), 0.0, x * np.sin(a) + z * np.cos(a)] for a in angles],
        orientations=[[np.cos(0.5 * a), 0.0, -np.sin(0.5 * a), 0.0] for a in angles],
    )
    return [lying, flap]


def main(picture: Path | None = None) -> float:
    """How far the folded half lies from its place, the mirror image of the other half, in the mean [m]."""
    material = Material(areal_density=0.2, stretch_stiffness=300.0, bending_rigidity=3e-5, thickness=0.001)
    cloth = towel((0.2, 0.2), material, spacing=0.015)
    flat = cloth.vertices - cloth.vertices.mean(axis=0) * [1.0, 1.0, 0.0]
    scene = Scene(
        cloth=Cloth(vertices=flat, faces=cloth.faces), material=material, bodies=boards(), duration=2.0, frame_rate=60
    )
    rollout = simulate(scene)
    moved = flat[:, 0] > 0.0
    place = flat[moved] * [-1.0, 1.0, 1.0] + [0.0, 0.0, material.thickness]
    away = float(np.linalg.norm(rollout.positions[-1][moved] - place, axis=1).mean())
    print(f"the folded half lies {1000 * away:.1f} mm from its place")
    if picture is not None:
        save_png(scene_picture(scene, rollout, FRAME), picture)
    return away


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
