"""Presets of the ten fabrics of Wang, O'Brien and Ramamoorthi (2011), from ARCSim's material files.

    python benchmarks/wang.py FOLDER    writes src/tatamu/simulation/presets/wang-*.toml; FOLDER has the ten JSON files

The data have stretching as C11, C12, C22 and shear at six samples of strain, and bending at 0, 45 and 90 degrees at
five curvatures. Kept are the medians over the strains, and bending at the least curvature. Lost is that stiffness grows
with strain and angle, and that bending changes with curvature; the ranges stand in [spread].
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np

from tatamu.base.files import write_text
from tatamu.simulation.material import PRESETS

DATA = "Wang, O'Brien, Ramamoorthi 2011 (ARCSim data)"
ASSUMED = {"thickness": 0.001, "friction_table": 0.5, "friction_cloth": 0.6}


def preset(name: str, density: float, stretching: np.ndarray, bending: np.ndarray) -> str:
    """The file of one fabric.

    Args:
        name: As ARCSim has it.
        density: [kg/m^2].
        stretching: C11, C12, C22, shear [N/m] in rows, shape (6, 4).
        bending: At 0, 45 and 90 degrees [N m], shape (3, 5).
    """
    c11, c12, c22, shear = np.median(stretching, axis=0)
    nu = c12 / np.sqrt(c11 * c22)
    free = 1.0 - nu * nu
    fields = {
        "areal_density": density,
        "stretch_stiffness": c11 * free,
        "stretch_stiffness_weft": c22 * free,
        "shear_stiffness": shear,
        "poisson_ratio": nu,
        "bending_rigidity": bending[0, 0],
        "bending_rigidity_weft": bending[2, 0],
        "bending_rigidity_bias": bending[1, 0],
    }
    spread = {
        "stretch_stiffness": stretching[:, 0],
        "stretch_stiffness_weft": stretching[:, 2],
        "shear_stiffness": stretching[stretching[:, 3] > 0, 3],
        "bending_rigidity": bending[0],
        "bending_rigidity_weft": bending[2],
        "bending_rigidity_bias": bending[1],
    }
    source = {
        "areal_density": DATA,
        "stretch_stiffness": f"{DATA}: median of C11 at six strains, sides free; spread: C11",
        "stretch_stiffness_weft": f"{DATA}: likewise of C22",
        "shear_stiffness": f"{DATA}: median at six strains; spread: those above 0",
        "poisson_ratio": f"{DATA}: C12 / sqrt(C11 C22) of the medians",
        "bending_rigidity": f"{DATA}: along the first direction at the least curvature; spread: all curvatures",
        "bending_rigidity_weft": f"{DATA}: likewise along the second",
        "bending_rigidity_bias": f"{DATA}: likewise at 45 degrees",
        **dict.fromkeys(ASSUMED, "assumed"),
    }
    values = {field: float(f"{value:.3g}") for field, value in fields.items()} | ASSUMED
    ranges = {
        field: (min(values[field], float(f"{low:.3g}")), max(values[field], float(f"{high:.3g}")))
        for field, (low, high) in ((field, (found.min(), found.max())) for field, found in spread.items())
    }
    lines = [
        "[preset]",
        f'title = "{name.replace("-", " ")}, measured by direction"',
        'note = "Stretch grows with strain in the data: its median is kept. No hysteresis and no air were measured."',
        "\n[material]",
        *(f"{field} = {value!r}" for field, value in values.items()),
        "\n[spread]",
        *(f"{field} = [{low!r}, {high!r}]" for field, (low, high) in ranges.items()),
        "\n[source]",
        *(f'{field} = "{text}"' for field, text in source.items()),
    ]
    return "\n".join(lines) + "\n"


def main() -> None:
    """Write a file for each fabric."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    for file in sorted(parser.parse_args().folder.glob("*.json")):
        data = json.loads(file.read_text())
        text = preset(file.stem, data["density"], np.array(data["stretching"]), np.array(data["bending"]))
        write_text(PRESETS / f"wang-{file.stem}.toml", text)


if __name__ == "__main__":
    main()
