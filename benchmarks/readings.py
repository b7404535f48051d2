"""Hidden parameters from the readings that are not the paper's: plate, swing, fading, bias, crease.

    python benchmarks/readings.py --out runs/readings [--draws 100] [--only plate] [--write-docs]

Each draw hides a fabric, reads it in native with other seeds and with the errors that a person makes, and calibrates.
An interval is the parameter found, times or divided by e to twice its stated relative uncertainty. What is there is not
run again; rows of the table that were not asked for stay.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.tables import arguments, kept, merged, published, show
from tatamu.calibration import Measurements, calibrate
from tatamu.calibration.bias import Bias
from tatamu.calibration.crease import PressedCrease
from tatamu.calibration.elongation import Elongation, Grasp
from tatamu.calibration.fading import Fading
from tatamu.calibration.plate import Plate
from tatamu.calibration.readings import Errors
from tatamu.calibration.sag import Sag
from tatamu.calibration.swing import TenSwings
from tatamu.garments import make_garment
from tatamu.simulation.material import GRAVITY, Material, load_material
from tatamu.simulation.simulators import simulate

SIZE = (0.24, 0.36)
"""Size of the cloth [m]."""
LARGE = (0.6, 0.9)
"""Size of the cloth that is hung by an edge and from which a strip on the bias is cut [m]."""
STRIP = (0.7, 0.08)
"""Length and width of the strip on the bias [m]."""
OTHER = 0.7
"""Largest difference of the logarithm of a rigidity that nothing measures from the preset's."""
FINER = 0.014
"""Spacing of the mesh on which that is read [m]."""
FINER_COLUMNS = 9
"""Cells across the strip on the bias."""
FINER_ROWS = 16
"""Cells along the strip whose sag is read."""
COVERING = 2.0
"""Half width of an interval, in standard uncertainties."""
ERRORS = Errors()
TERRY = load_material(Path("terry"))
Tables = dict[str, dict[str, Any]]


def plate(random: np.random.Generator) -> tuple[Material, Tables]:
    """A disc of 0.30 over 0.18 m, read twice."""
    density = float(np.exp(random.uniform(np.log(0.1), np.log(0.4))))
    length = random.uniform(0.017, 0.024)
    hidden = _terry(areal_density=density, bending_rigidity=density * GRAVITY * length**3)
    read = []
    for seed in (11, 12):
        test = Plate(0.15, 0.09, 0.7, seed=seed)
        value = test.coefficient_of(test.reading(simulate(test.scene(hidden))))
        read.append(float(np.clip(value + ERRORS.drape * random.standard_normal(), 0.1, 0.92)))
    return hidden, {"plate": {"disc": 0.3, "plate": 0.18, "drape_coefficient": read}}


def swing(random: np.random.Generator) -> tuple[Material, Tables]:
    """Ten swings by a stopwatch."""
    hidden = _air(random)
    test = _ten_swings()
    return hidden, {"swing": _swing(test, hidden, random)}


def fading(random: np.random.Generator) -> tuple[Material, Tables]:
    """Ten swings, and swings until a quarter."""
    hidden = _air(random)
    ten = _ten_swings()
    test = Fading(ten.garment, ten.edge, ten.aside, 0.0175, 4.0)
    count = test.reading(simulate(test.scene(hidden))) + ERRORS.swings * random.standard_normal()
    table = {"edge": "bottom", "aside": 0.07, "to": 0.0175, "count": [max(0.3, float(count))]}
    return hidden, {"swing": _swing(ten, hidden, random), "fading": table}


def bias(random: np.random.Generator) -> tuple[Material, Tables]:
    """Hung by its lower edge, and a strip on the bias hung by either end; read on meshes finer than calibration's."""
    garment = make_garment("towel", size=LARGE, spacing=FINER)
    hidden = _terry(
        areal_density=random.uniform(0.15, 0.4),
        stretch_stiffness=float(np.exp(random.uniform(np.log(200.0), np.log(600.0)))),
        shear_stiffness=float(np.exp(random.uniform(np.log(10.0), np.log(60.0)))),
        bending_rigidity=TERRY.bending_rigidity * float(np.exp(random.uniform(-OTHER, OTHER))),
        poisson_ratio=random.uniform(0.15, 0.35),
    )
    whole = Elongation(garment, (Grasp(edge="bottom"),))
    strip = Bias(*STRIP, STRIP[1] / FINER_COLUMNS)
    longer = whole.reading(simulate(whole.scene(hidden)))
    pulled = strip.reading(simulate(strip.scene(hidden)))
    hung, lying = (_read(value, random) for value in (whole.length + longer, whole.length))
    ends = {"L1": strip.length + pulled, "L2": strip.length}
    by_ends = {name: [_read(value, random) for _ in range(2)] for name, value in ends.items()}
    return hidden, {
        "elongation": {"grasps": [{"edge": "bottom"}], "L1": max(hung, lying + 1e-4), "L2": lying},
        "bias": {"width": STRIP[1], **by_ends},
    }


def crease(random: np.random.Generator) -> tuple[Material, Tables]:
    """A sag, and a hinge of 10 mm round two boards of 3 mm, opened twice."""
    density = float(np.exp(random.uniform(np.log(0.1), np.log(0.4))))
    length = random.uniform(0.017, 0.03)
    rigidity = density * GRAVITY * length**3
    stays = float(np.exp(random.uniform(np.log(20.0), np.log(120.0))))
    hidden = _terry(areal_density=density, bending_rigidity=rigidity, bending_hysteresis=stays * rigidity)
    test = PressedCrease(0.01, 0.006 + hidden.thickness, hidden.bending_length)
    angle = float(np.degrees(test.angle_of(simulate(test.scene(hidden)).positions[-1])))
    angles = [float(np.clip(angle + ERRORS.angle * random.standard_normal(), 0.0, 180.0)) for _ in range(2)]
    strip = Sag(2.0 * length, 2.0 * length / FINER_ROWS)
    sag = strip.reading(simulate(strip.scene(hidden))) + ERRORS.length * random.standard_normal()
    return hidden, {
        "sag": {"edge": "bottom", "free_length": strip.free_length, "sag": float(sag)},
        "crease": {"gap": 0.01, "board": 0.003, "angle": angles},
    }


READINGS: dict[str, tuple[str, Callable[[np.random.Generator], tuple[Material, Tables]]]] = {
    "plate": ("bending_rigidity", plate),
    "swing": ("air_added_mass", swing),
    "fading": ("air_drag_quadratic", fading),
    "bias": ("shear_stiffness", bias),
    "crease": ("bending_hysteresis", crease),
}
"""Parameter of each test, and the function that reads it."""


def _terry(**changed: float) -> Material:
    return TERRY.model_copy(update=changed)


def _air(random: np.random.Generator) -> Material:
    return _terry(
        areal_density=random.uniform(0.15, 0.4),
        air_added_mass=float(np.exp(random.uniform(np.log(0.08), np.log(0.25)))),
        air_drag_quadratic=float(np.exp(random.uniform(np.log(0.5), np.log(4.0)))),
        air_drag=0.0,
    )


def _ten_swings() -> TenSwings:
    return TenSwings(make_garment("towel", size=SIZE), "bottom", 0.07, None)


def _read(length: float, random: np.random.Generator) -> float:
    """Return a length as a person reads it [m]."""
    return float(length + ERRORS.length * random.standard_normal())


def _swing(test: TenSwings, hidden: Material, random: np.random.Generator) -> dict[str, Any]:
    seconds = test.reading(simulate(test.scene(hidden))) + ERRORS.time * random.standard_normal()
    return {"edge": "bottom", "aside": test.aside, "ten_swings": float(seconds)}


def recovered(name: str, draw: int) -> dict[str, Any]:
    """One draw: the hidden parameter, the one found, and its stated relative uncertainty."""
    parameter, read = READINGS[name]
    random = np.random.default_rng([27, list(READINGS).index(name), draw])
    hidden, tables = read(random)
    size = LARGE if name == "bias" else SIZE
    mass = hidden.areal_density * size[0] * size[1]
    found = calibrate(Measurements.model_validate({"garment": {"name": "towel", "size": size, "mass": mass}, **tables}))
    return {
        "true": getattr(hidden, parameter),
        "found": getattr(found.material, parameter),
        "stated": found.relative(parameter),
        "bound": None if found.bounding(parameter) is None else str(found.bounding(parameter)),
    }


def line(name: str, rows: list[dict[str, Any]]) -> dict[str, str]:
    """How often the interval holds the truth, where the reading tells the parameter."""
    told = [row for row in rows if row["bound"] is None]
    off = np.array([abs(np.log(row["found"] / row["true"])) for row in told])
    stated = np.array([row["stated"] for row in told])
    return {
        "reading": f"`{name}`",
        "parameter": READINGS[name][0],
        "told": f"{len(told)} of {len(rows)}",
        "within twice the stated uncertainty": f"{int((off <= COVERING * stated).sum())} of {len(told)}",
        "median error": f"{100 * np.median(off):.0f} %",
        "median stated": f"{100 * np.median(stated):.0f} %",
    }


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--draws", type=int, default=100)
    parser.add_argument("--only", action="append", default=[], metavar="READING", choices=list(READINGS))
    parser.add_argument("--kept", action="store_true", help="only the first draws, those that are there")
    options = parser.parse_args()
    lines = []
    for name in options.only or READINGS:
        rows = []
        for draw in range(options.draws):
            file = options.out / f"{name}-{draw}.json"
            if options.kept and not file.exists():
                break
            rows.append(kept(file, partial(recovered, name, draw)))
            print(f"{name} {draw}: {rows[-1]}", flush=True)
        lines.append(line(name, rows))
    before = published("calibration: readings")
    show({"calibration: readings": merged(before, lines, "reading")}, options.write_docs)


if __name__ == "__main__":
    main()
