"""Proofs of docs/notes/calibration.md, drawings of docs/guide/calibration.md.

    python benchmarks/calibration.py recovery [--draws 20] [--repeats 4]      hidden materials come back
    python benchmarks/calibration.py pinch                                    why the sag is read at a straight grip
    python benchmarks/calibration.py drawings                                 docs/images/measure-*.svg

All but the last write under --out and, with --write-docs, their tables into docs/notes/calibration.md. What is there is
not run again.
"""

from __future__ import annotations

import time
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import binom

from benchmarks.ruler import HUMAN, MARK, measured, readings
from benchmarks.tables import IMAGES, arguments, kept, show
from tatamu.base.files import write_text
from tatamu.calibration import Calibration, calibrate
from tatamu.calibration.bias import Bias
from tatamu.calibration.crease import PressedCrease
from tatamu.calibration.elongation import Elongation, Grasp
from tatamu.calibration.friction import Slope
from tatamu.calibration.loop import Loop
from tatamu.calibration.plate import Plate
from tatamu.calibration.push import Push
from tatamu.calibration.sag import Sag
from tatamu.calibration.swing import TenSwings
from tatamu.calibration.test import CalibrationTest
from tatamu.garments import make_garment
from tatamu.simulation.material import GRAVITY, Material, load_material
from tatamu.simulation.scene import Gripper, Scene, Table
from tatamu.simulation.simulators import simulate

LIMITS = {"stretch_stiffness": 0.05, "bending_rigidity": 0.10, "friction_table": 0.5}
"""Limits of recovery: fractions of the parameter, and degrees of atan(mu)."""
PARAMETERS = tuple(LIMITS)


# --- recovery


def hidden(random: np.random.Generator) -> tuple[Material, tuple[float, float], float]:
    """A fabric of the measured range, the size of a towel, and the free length that a person tries."""
    density = float(np.exp(random.uniform(np.log(0.15), np.log(0.6))))
    length, tall = random.uniform(0.015, 0.035), round(random.uniform(0.6, 1.4), 2)
    softest = max(17.0, density * GRAVITY * tall / 0.2)  # no towel hangs over a tenth longer than it lies
    material = Material(
        areal_density=density,
        stretch_stiffness=float(np.exp(random.uniform(np.log(softest), np.log(1060.0)))),
        poisson_ratio=random.uniform(0.15, 0.35),
        bending_rigidity=density * GRAVITY * length**3,
        thickness=0.002,
        friction_table=random.uniform(0.3, 1.0),
    )
    tried = max(0.025, 0.005 * round(1.8 * length * random.uniform(0.8, 1.25) / 0.005))
    return material, (0.2, tall), tried


def compared(found: Calibration, true: Material) -> dict[str, Any]:
    """Error, stated uncertainty and whether the interval covers, for each parameter."""
    row: dict[str, Any] = {}
    for name in PARAMETERS:
        got, wanted = (float(getattr(material, name)) for material in (found.material, true))
        off, stated = np.log(got / wanted), found.relative(name)
        if name == "friction_table":
            degrees = np.degrees(np.arctan([got, wanted]))
            scale = np.degrees(wanted / (1.0 + wanted**2))  # d atan(mu) / d ln mu
            row[name] = {"error": float(degrees[0] - degrees[1]), "stated": float(stated * scale)}
        else:
            row[name] = {"error": float(np.exp(off) - 1.0), "stated": stated}
        row[name] |= {"known": name in found.known, "covers": bool(abs(got / wanted - 1.0) <= stated * got / wanted)}
    return row


def recovery(out: Path, draws: int, repeats: int) -> list[dict[str, Any]]:
    """Calibrate to the readings of hidden materials: once rounded only, and `repeats` times with reading errors."""
    rows = []
    for draw in range(draws):
        rows.append(kept(out / f"recovery-{draw}.json", partial(recovered, draw, repeats)))
        print(f"draw {draw}: {rows[-1]['seconds']:.1f} s a calibration", flush=True)
    return rows


def recovered(draw: int, repeats: int) -> dict[str, Any]:
    """Calibrate to the readings of one hidden material."""
    exact = {name: MARK / float(np.sqrt(12.0)) for name in ("length", "mass", "H_s")}
    random = np.random.default_rng([6, draw])
    material, size, free = hidden(random)
    true = measured(material, "native", size, free)
    started = time.process_time()
    rounded = compared(calibrate(readings(true, size, exact)), material)
    seconds = time.process_time() - started
    noisy = [compared(calibrate(readings(true, size, HUMAN, random)), material) for _ in range(repeats)]
    row = {"material": material.model_dump(), "size": size, "true": true, "seconds": seconds}
    return {**row, "rounded": rounded, "noisy": noisy}


def recovery_table(rows: list[dict[str, Any]]) -> str:
    """Both questions as Markdown: how near, and how honest."""
    lines = [
        "| parameter | limit | readings tell in | of these within | worst of these | of all within | 1 σ covers |",
        "|---|---|---|---|---|---|---|",
    ]
    covers: list[bool] = []
    for name, limit in LIMITS.items():
        rounded = [row["rounded"][name] for row in rows]
        told = [each for each in rounded if each["known"] and each["stated"] <= limit / 2]
        good, near = ([each for each in some if abs(each["error"]) <= limit] for some in (told, rounded))
        noisy = [each[name] for row in rows for each in row["noisy"] if each[name]["known"]]
        covered = [each["covers"] for each in noisy]
        covers += covered
        worst = max((abs(each["error"]) for each in told), default=float("nan"))
        unit = (lambda v: f"{v:.2f}°") if name == "friction_table" else (lambda v: f"{100 * v:.1f} %")
        lines.append(
            f"| {name} | {unit(limit)} | {len(told)} of {len(rows)} | {len(good)} | {unit(worst)} | {len(near)} "
            f"| {100 * np.mean(covered):.0f} % of {len(covered)} |"
        )
    share, count = float(np.mean(covers)), len(covers)
    low, high = binom.interval(0.95, count, 0.6827)
    verdict = "within" if low <= share * count <= high else "outside"
    seconds = [row["seconds"] for row in rows]
    lines += [
        "",
        f"All together, the intervals of one standard uncertainty cover the truth {100 * share:.0f} % of {count} "
        f"times; honest intervals would do so {100 * low / count:.0f} to {100 * high / count:.0f} % of the "
        f"times (the middle 95 % of a binomial distribution): {verdict}. A calibration took {np.median(seconds):.1f} s "
        f"of processor time in the median, {max(seconds):.1f} s at most.",
    ]
    return "\n".join(lines)


# --- why a straight grip

PINCH, INSET, LIFT = 0.03, 0.06, 0.15
"""Width of a pinch of two fingers, its distance from the edge, and how high it is lifted [m]."""


def pinched(material: Material, spacing: float) -> float:
    """Lowest point near a pinch beside the edge of a towel that is lifted off the table, below the pinch [m]."""
    towel = make_garment("towel", (0.34, 0.50), material, spacing)
    x, y = towel.vertices[:, 0] - towel.vertices[:, 0].min(), towel.vertices[:, 1]
    fingers = np.flatnonzero((x > INSET - 0.6 * spacing) & (x < INSET + 0.02) & (np.abs(y) < PINCH / 2 + 1e-3))
    hand = Gripper(vertices=fingers.tolist(), times=[0.0, 1.0], displacements=[[0, 0, 0], [0.1, 0, LIFT]])
    still = material.model_copy(update={"air_drag": 3.0})
    scene = Scene(cloth=towel.cloth(), material=still, table=Table(), grippers=[hand], duration=4.0, frame_rate=20.0)
    end = simulate(scene).positions[-1]
    near = (x < INSET) & (np.hypot(x - INSET, y) < 1.05 * INSET)
    return float(end[fingers, 2].mean() - end[near, 2].min())


def pinch_table(out: Path) -> str:
    """Sag by a pinch against sag by a straight grip, on two meshes."""
    terry = load_material(Path("terry"))
    lines = ["| B [µN m] | pinch, 15 mm mesh | pinch, 10.5 mm mesh | straight grip, 8 rows | straight grip, 16 rows |"]
    lines.append("|---" * 5 + "|")
    for rigidity in (1.5e-5, 3e-5, 6e-5, 1.2e-4):
        material = terry.model_copy(update={"bending_rigidity": rigidity})
        strips = [Sag(INSET, INSET / rows) for rows in (8, 16)]
        sags = [pinched(material, spacing) for spacing in (0.015, 0.0105)]
        sags += [strip.reading(simulate(strip.scene(material))) for strip in strips]
        lines.append(f"| {1e6 * rigidity:.0f} | " + " | ".join(f"{1e3 * sag:.1f} mm" for sag in sags) + " |")
    hung = [
        1e3 * test.reading(simulate(test.scene(terry)))
        for grasp in (Grasp(edge="bottom"), Grasp(edge="bottom", at=0.0, width=PINCH))
        for spacing in (0.02, 0.015)
        for test in [Elongation(make_garment("towel", (0.34, 0.80), terry, spacing), [grasp])]
    ]
    lines += [
        "",
        f"A towel of 0.34 x 0.80 m, hung by its edge, is {hung[0]:.2f} mm longer on a 20 mm mesh and {hung[1]:.2f} mm "
        f"on 15 mm; by one corner {hung[2]:.1f} and {hung[3]:.1f} mm.",
    ]
    write_text(out / "pinch.md", "\n".join(lines) + "\n")
    return "\n".join(lines)


# --- drawings


def drawings() -> None:
    """Write the drawings of docs/guide/calibration.md, from simulated shapes."""
    terry = load_material(Path("terry"))
    for name, edges in (("towel", ["bottom"]), ("tshirt", ["left_shoulder", "right_shoulder"])):
        test = Elongation(make_garment(name, spacing=0.04), [Grasp(edge=edge) for edge in edges])
        draw(f"hang-{name}", test, test.garment.material)
    draw("sag", Sag(0.05), terry)
    draw("loop", Loop(0.034, 0.002), terry)
    rough = terry.model_copy(update={"bending_hysteresis": 50.0 * terry.bending_rigidity})
    draw("crease", PressedCrease(0.01, 0.007, terry.bending_length), rough)
    draw("push", Push(0.4, 0.06, 0.01), terry.model_copy(update={"compression": 0.12, "stretch_stiffness": 60.0}))
    draw("plate", Plate(0.15, 0.09, 0.6), terry)
    draw("bias", Bias(0.6, 0.08), terry.model_copy(update={"shear_stiffness": 20.0}))
    write_text(
        IMAGES / "measure-swing.svg", TenSwings(make_garment("towel"), "bottom", 0.2, None).drawing(np.empty((0, 3)))
    )
    write_text(IMAGES / "measure-slide.svg", Slope(float(np.arctan(terry.friction_table))).drawing(np.empty((0, 3))))


def draw(name: str, test: CalibrationTest, material: Material) -> None:
    """Write the drawing of a test with the shape of a material at rest."""
    write_text(IMAGES / f"measure-{name}.svg", test.drawing(simulate(test.scene(material)).positions[-1]))


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("what", choices=("recovery", "pinch", "drawings"))
    parser.add_argument("--out", type=Path, default=Path("runs/calibration"))
    parser.add_argument("--draws", type=int, default=20)
    parser.add_argument("--repeats", type=int, default=4)
    options = parser.parse_args()
    if options.what == "drawings":
        drawings()
    elif options.what == "pinch":
        show({"calibration: pinch": pinch_table(options.out)}, options.write_docs)
    else:
        rows = recovery(options.out, options.draws, options.repeats)
        show({"calibration: recovery": recovery_table(rows)}, options.write_docs)


if __name__ == "__main__":
    main()
