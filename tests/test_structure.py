"""The shape of the package: imports point one way, exports are what they say."""

from __future__ import annotations

import ast
from pathlib import Path

import tatamu

SOURCE = Path(tatamu.__file__).parent
ORDER = [
    ["errors"],
    ["files", "records", "curves", "size"],
    ["topology", "heavy_strip", "plate_in_air", "zbuffer", "meshing"],
    ["material"],
    ["settling"],
    ["presets"],
    ["scene", "rollout", "crossings"],
    ["subdivision"],
    ["presentation"],
    ["instruments"],
    ["simulators"],
    ["cluster"],
    ["search"],
    ["options"],
    ["garments"],
    ["calibration"],
    ["folding"],
    ["disturbances"],
    ["evaluation"],
    ["robustness"],
    ["study"],
    ["report"],
    ["crosscheck", "margins"],
    ["validation"],
    ["robots"],
    ["sweep"],
    ["api"],
