"""What Tables I and II make of cloth in Blender: the SI fields of the presets, and processor time of one fold.

python benchmarks/paper_numbers.py [--spacing 0.02]
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from scipy.optimize import brentq

from tatamu.garments.towel import staggered_rectangle
from tatamu.material import Material, load_material
from tatamu.scene import Cloth, Scene
from tatamu.simulators import simulate
from tatamu.validation.elastica import cantilever
from tatamu.validation.scenes import held

GRAVITY = 9.81


def stiffness(material: Material, spacing: float, length: float = 0.6) -> float:
    """Y [N/m] by which a strip hung by its end stretches."""
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
    """l_b [m] by which a strip hangs over an edge, held by its middle row, 4 cells long on either side."""
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


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--spacing", type=float, default=0.02)
    spacing = parser.parse_args().spacing
    print("| | Y [N/m] | l_b over spacing | B [N m] |\n|---|---|---|---|")
    for garment in ("tshirt", "towel", "trousers"):
        material = load_material(Path(f"paper-{garment}"))
        length = bending_length(material, spacing)
        rigidity = material.areal_density * GRAVITY * length**3
        row = f"{stiffness(material, spacing):.0f} | {length / spacing:.2f} | {rigidity:.1e}"
        print(f"| {garment} | {row} |", flush=True)


if __name__ == "__main__":
    main()
