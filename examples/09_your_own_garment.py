"""Add a garment that a program makes: a napkin that is narrower at one end, folded in half.

A garment with an outline needs no program: see 05_your_own_garment.py.

python examples/09_your_own_garment.py
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import tatamu as tt

NARROWER = 0.8
"""Width of the end at +x over the width of the end at -x."""


def make_napkin(size: tuple[float, float] = (0.3, 0.4), **given: Any) -> tt.Garment:
    """Return a napkin of a width and a length [m]; `given` may have a material and a spacing."""
    sheet = tt.make_garment("towel", size, **given)
    vertices = sheet.vertices.copy()
    part = vertices[:, 0] / size[1] + 0.5
    vertices[:, 1] *= 1.0 + (NARROWER - 1.0) * part
    return replace(sheet, name="napkin", vertices=vertices)


tt.register_garment("napkin", make_napkin, "a towel that is narrower at one end")


def main() -> float:
    """Return the mean distance of the folded napkin from its target [m]."""
    task = tt.make_task("napkin", fold="half", spacing=0.03)
    options = tt.LearnOptions(trials=6, disturbances="none", baselines=False)
    result = tt.learn(task, options, progress=print)
    return result.score.mean_vertex_distance


if __name__ == "__main__":
    main()
