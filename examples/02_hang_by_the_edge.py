"""A sheet hangs by one edge and stretches under its own weight, as in the first of the paper's three measurements.

python examples/02_hang_by_the_edge.py
"""

from __future__ import annotations

import numpy as np

from tatamu import Cloth, Gripper, Material, Scene, simulate
from tatamu.garments import towel


def main() -> float:
    """Measured elongation over the textbook's rho g L^2 / (2 Y); it should be 1."""
    material = Material(
        areal_density=0.2, stretch_stiffness=100.0, poisson_ratio=0.0, bending_rigidity=1.5e-5, air_drag=2.0
    )
    sheet = towel((0.1, 0.3), material, spacing=0.02)
    hung = sheet.vertices[:, [2, 1, 0]]  # its length downwards
    top = np.flatnonzero(hung[:, 2] > hung[:, 2].max() - 1e-9)
    hand = Gripper(vertices=top.tolist(), times=[0.0], displacements=[[0.0, 0.0, 0.0]])
    rollout = simulate(
        Scene(cloth=Cloth(vertices=hung, faces=sheet.faces), material=material, grippers=[hand], duration=3)
    )
    elongation = hung[:, 2].min() - rollout.positions[-1, :, 2].min()
    exact = material.areal_density * 9.81 * 0.3**2 / (2 * material.stretch_stiffness)
    print(f"elongation {1000 * elongation:.3f} mm, textbook {1000 * exact:.3f} mm")
    return float(elongation / exact)


if __name__ == "__main__":
    main()
