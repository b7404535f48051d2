"""A sheet falls on a table: build a scene, simulate it, read the rollout.

python examples/01_drop_a_sheet.py
"""

from __future__ import annotations

import numpy as np

from tatamu import Cloth, Material, Scene, Table, simulate
from tatamu.garments import towel


def main() -> float:
    """Height at which the sheet comes to rest [m]; it should be half its thickness."""
    material = Material(areal_density=0.2, stretch_stiffness=300.0, bending_rigidity=1.5e-5, thickness=0.001)
    sheet = towel((0.2, 0.2), material, spacing=0.02)
    scene = Scene(
        cloth=Cloth(vertices=sheet.vertices + np.array([0.0, 0.0, 0.05]), faces=sheet.faces),
        material=material,
        table=Table(),
        duration=1.0,
    )
    rollout = simulate(scene)
    height = float(rollout.positions[-1, :, 2].mean())
    print(f"after {rollout.times[-1]:g} s the sheet lies {1000 * height:.2f} mm over the table")
    return height


if __name__ == "__main__":
    main()
