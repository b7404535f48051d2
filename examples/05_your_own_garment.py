"""A garment of your own: draw its outline, name its open edges, look at it, let it fall on a table.

python examples/05_your_own_garment.py [FOLDER]
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np

from tatamu import Scene, Table, simulate
from tatamu.garments import make_garment
from tatamu.report.garment import diagram
from tatamu.simulation.scene import Cloth

OUTLINE = """<svg xmlns="http://www.w3.org/2000/svg" width="300mm" height="200mm" viewBox="0 0 300 200">
<path id="outline" d="M 30 0 L 270 0 C 280 60 300 150 300 200 L 0 200 C 0 150 20 60 30 0 Z"/>
<line id="waist" x1="30" y1="0" x2="270" y2="0"/>
<line id="hem" x1="0" y1="200" x2="300" y2="200"/>
</svg>"""
FILE = """[garment]
name = "skirt"
outline = "skirt.svg"
openings = ["waist", "hem"]
fabric = "denim"
"""


def main(folder: Path | None = None) -> float:
    """How high a skirt of two layers lies after a fall of 5 cm [m]; its upper layer lies 1.5 thicknesses high."""
    folder = folder or Path(tempfile.mkdtemp())
    (folder / "skirt.svg").write_text(OUTLINE)
    (folder / "skirt.toml").write_text(FILE)
    skirt = make_garment(str(folder / "skirt.toml"))
    (folder / "skirt.png").write_bytes(diagram(skirt).png())
    print(f"{folder / 'skirt.png'}: {len(skirt.vertices)} vertices in {skirt.layers} layers")
    flying = skirt.vertices + np.array([0.0, 0.0, 0.05])
    cloth = Cloth(vertices=flying, faces=skirt.faces, rest_vertices=skirt.rest, seams=skirt.seams)
    rollout = simulate(Scene(cloth=cloth, material=skirt.material, table=Table(), duration=1.0))
    height = float(np.quantile(rollout.positions[-1, :, 2], 0.95))
    print(f"after {rollout.times[-1]:g} s the upper layer lies {1000 * height:.2f} mm over the table")
    return height


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else None)
