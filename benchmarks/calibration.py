"""Proofs and drawings of docs/calibration.md.

    python benchmarks/calibration.py recovery [--draws 20] [--repeats 4]      hidden materials come back
    python benchmarks/calibration.py cloths [--manipulations 10]              another simulator as the real cloth
    python benchmarks/calibration.py pinch                                    why the sag is read at a straight grip
    python benchmarks/calibration.py drawings                                 docs/measure-*.svg

All but the last write under --out and, with --write-docs, their tables into docs/calibration.md. What is there is
not run again.
"""

from __future__ import annotations

import argparse
import json
import re
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import binom

from tatamu.calibration import Calibration, Measurements, calibrate
from tatamu.calibration.drawing import hanging, sagging, sliding
from tatamu.calibration.elongation import Elongation
from tatamu.calibration.friction import SLIDING, Slope
from tatamu.calibration.laboratory import Laboratory
from tatamu.calibration.measurements import Grasp
from tatamu.calibration.sag import Sag
from tatamu.files import validated, write_json, write_text
from tatamu.folding.task import make_task
from tatamu.garments import make_garment
from tatamu.material import GRAVITY, Material, load_material
from tatamu.scene import Gripper, Scene, Table
from tatamu.simulators import simulate

DOCS = Path("docs/calibration.md")
BOARD = 0.8
"""Length of the board [m]."""
MARK = 1e-3
"""Marks of the ruler [m] and of the scale [kg]."""
LIMITS = {"stretch_stiffness": 0.05, "bending_rigidity": 0.10, "friction_table": 0.5}
"""What recovery is held to: parts of the parameter, and degrees of atan(mu)."""
PARAMETERS = tuple(LIMITS)
FINE_HANG, FINE_SAG = 0.014, 18
"""Hidden cloth is simulated on finer meshes than calibration's: edge length [m], rows."""


# --- measuring simulated cloth as a person would


def measured(
    material: Material,
    simulator: str,
    size: tuple[float, float],
    free_length: float,
    spacing: float | None = None,
) -> dict[str, float]:
    """True lengths, angle and mass of a simulated cloth."""
    lab = Laboratory(simulator)
    hung = Elongation(make_garment("towel", size, material, spacing or FINE_HANG), [Grasp(edge="bottom")])
    strip = Sag(free_length, spacing or free_length / FINE_SAG)
    angle = slipping_angle(lambda at: Slope(at).speed(lab.run(Slope(at).scene(material), "friction")), material)
    longer = lab.reading(hung, material)
    return {
        "mass": material.areal_density * size[0] * size[1],
        "L1": size[1] + longer,
        "L2": size[1],
        "H_s": BOARD * float(np.sin(angle)),
        "sag": lab.reading(strip, material),
        "free_length": free_length,
        "angle": angle,
    }


def slipping_angle(speed: Callable[[float], float], material: Material) -> float:
    """Slope at which the cloth starts to slide as the board is lifted [rad], to 0.02 degrees."""
    low, high = 0.0, np.radians(60.0)
    while high - low > np.radians(0.02):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if speed(middle) > SLIDING else (middle, high)
    return 0.5 * (low + high)


def readings(
    true: dict[str, float], size: tuple[float, float], errors: dict[str, float], random: np.random.Generator | None
) -> Measurements:
    """What a person reads: with the stated errors if there is a generator, and rounded to the marks."""

    def read(value: float, kind: str) -> float:
        noisy = value + (random.normal(0.0, errors[kind]) if random else 0.0)
        return max(MARK, round(noisy / MARK) * MARK)

    lengths = {name: read(true[name], "length") for name in ("L1", "L2", "sag", "free_length")}
    lengths["L1"] = max(lengths["L1"], lengths["L2"])
    lengths["sag"] = min(lengths["sag"], lengths["free_length"] - MARK)
    told = [read(side, "length") if random else side for side in size]
    return validated(
        Measurements,
        {
            "garment": {"name": "towel", "size": told, "mass": read(true["mass"], "mass")},
            "elongation": {"grasps": [{"edge": "bottom"}], "L1": lengths["L1"], "L2": lengths["L2"]},
            "friction": {"L_t": read(BOARD, "length"), "H_s": read(true["H_s"], "H_s")},
            "sag": {"edge": "bottom", "free_length": lengths["free_length"], "sag": lengths["sag"]},
            "errors": errors,
        },
        "readings",
    )


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
    exact = {name: MARK / float(np.sqrt(12.0)) for name in ("length", "mass", "H_s")}
    human = {"length": 1e-3, "mass": 1e-3, "H_s": 5e-3}
    for draw in range(draws):
        path = out / f"recovery-{draw}.json"
        if not path.exists():
            random = np.random.default_rng([6, draw])
            material, size, free = hidden(random)
            true = measured(material, "native", size, free)
            started = time.process_time()
            rounded = compared(calibrate(readings(true, size, exact, None)), material)
            seconds = time.process_time() - started
            noisy = [compared(calibrate(readings(true, size, human, random)), material) for _ in range(repeats)]
            row = {"material": material.model_dump(), "size": size, "true": true, "seconds": seconds}
            write_json(path, {**row, "rounded": rounded, "noisy": noisy})
        rows.append(json.loads(path.read_text()))
        print(f"draw {draw}: {rows[-1]['seconds']:.1f} s a calibration", flush=True)
    return rows


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


# --- another simulator as the real cloth

TABLES = {
    "T-shirt": {"mass": 0.3, "stiffness": 15.0, "damping": 5.0, "bending": 6.0, "friction": 80.0},
    "towel": {"mass": 0.3, "stiffness": 1.5, "damping": 5.0, "bending": 20.0, "friction": 55.0},
    "pants": {"mass": 3.0, "stiffness": 10.0, "damping": 5.0, "bending": 10.0, "friction": 80.0},
}
"""Tables I and II of the paper: weight, structure, spring, bending of fabric, friction."""
GENERIC = {"T-shirt": "interlock", "towel": "terry", "pants": "denim"}
SHEET, SPACING = (0.24, 0.40), 0.02
"""Size and mesh spacing of the sheet that is measured and folded [m]."""


def paper_cloth(name: str) -> Material:
    """Blender's cloth under the paper's tables: its numbers as they are.

    Blender had only the bending model LINEAR then. On a mesh of triangles LINEAR crumples a sheet that lies flat, by a
    centimetre; ANGULAR with the same number has about the bending length that LINEAR has on squares.
    """
    table, base = TABLES[name], load_material(Path(GENERIC[name]))
    springs = {
        f"{kind}_{what}": table[value]
        for kind in ("tension", "compression", "shear")
        for what, value in (("stiffness", "stiffness"), ("damping", "damping"))
    }
    raw: dict[str, float | str | bool] = {
        "mass": table["mass"],
        **springs,
        "bending_model": "ANGULAR",
        "bending_stiffness": table["bending"],
        "cloth_friction": table["friction"],
        "quality": 10.0,
    }
    return base.model_copy(update={"blender": raw})


def final_shapes(material: Material, simulator: str, count: int) -> list[np.ndarray | None]:
    """Where the sheet ends after `count` random manipulations."""
    task = make_task("towel", size=SHEET, material=material, spacing=SPACING, simulator=simulator)
    random = np.random.default_rng(60)
    shapes = []
    for _ in range(count):
        span, most = task.fold.span, task.fold.candidates
        drawn = {"x1": random.uniform(0, span), "z1": random.uniform(0, 0.75 * span)}
        drawn |= {"x2": random.uniform(0, span), "z2": random.uniform(0, 0.75 * span)}
        drawn |= {"g1": float(random.integers(most)), "g2": float(random.integers(most))}
        rollout = task.evaluate(task.manipulation(drawn)).rollout
        shapes.append(None if rollout is None else rollout.positions[-1])
    return shapes


def apart(first: list[np.ndarray | None], second: list[np.ndarray | None]) -> list[float]:
    """Mean vertex distances [m] of the manipulations that both finished."""
    pairs = [(a, b) for a, b in zip(first, second, strict=True) if a is not None and b is not None]
    return [float(np.linalg.norm(a - b, axis=1).mean()) for a, b in pairs]


def sag_length(material: Material, simulator: str) -> float:
    """A free length at which the sheet's edge hangs down about half of it, as a person would find by trying [m]."""
    lab, tried = Laboratory(simulator), np.arange(0.05, 0.111, 0.02)
    share = [lab.reading(Sag(float(d), SPACING, name=f"{d:.2f}"), material) / d for d in tried]
    return float(tried[int(np.argmin(np.abs(np.array(share) - 0.5)))])


def cloth_case(name: str, real: Material, of: str, learner: str, generic: Material, count: int) -> dict[str, Any]:
    """Measure `real` in the simulator `of`, calibrate `learner` to it, and compare folds."""
    free = sag_length(real, of)
    true = measured(real, of, SHEET, free, SPACING)
    errors = {"length": 1e-3, "mass": 1e-3, "H_s": 5e-3}
    started = time.perf_counter()
    found = calibrate(readings(true, SHEET, errors, None), learner, SPACING)
    seconds = time.perf_counter() - started
    truth = final_shapes(real, of, count)
    before = apart(truth, final_shapes(generic, learner, count))
    after = apart(truth, final_shapes(found.material, learner, count))
    return {
        "case": f"{name} in {of}",
        "learner": learner,
        "readings": true,
        "material": found.material.model_dump(),
        "generic": before,
        "calibrated": after,
        "seconds": seconds,
    }


def cloths(out: Path, count: int) -> list[dict[str, Any]]:
    """Blender's cloth for native, native's for Blender, and both with MuJoCo."""
    terry, denim, knit = (load_material(Path(name)) for name in ("terry", "denim", "interlock"))
    paper = [(name, paper_cloth(name), "blender", "native", load_material(Path(GENERIC[name]))) for name in TABLES]
    cases: list[tuple[str, Material, str, str, Material]] = [
        paper[1],
        ("interlock", knit, "native", "blender", terry),
        paper[0],
        paper[2],
        ("denim", denim, "native", "blender", terry),
        ("interlock", knit, "mujoco", "native", terry),
        ("denim", denim, "native", "mujoco", terry),
    ]
    rows = []
    for name, real, of, learner, generic in cases:
        path = out / f"cloth-{name}-{of}-{learner}.json"
        if not path.exists():
            write_json(path, cloth_case(name, real, of, learner, generic, count))
        rows.append(json.loads(path.read_text()))
        print(cloth_line(rows[-1]), flush=True)
    return rows


def cloth_line(row: dict[str, Any]) -> str:
    """One row of the table of cloths."""
    before, after = 1e3 * np.mean(row["generic"]), 1e3 * np.mean(row["calibrated"])
    told, m = row["readings"], row["material"]
    return (
        f"| {row['case']} | {row['learner']} | {1e3 * (told['L1'] - told['L2']):.1f} | {1e3 * told['sag']:.0f} of "
        f"{1e3 * told['free_length']:.0f} | {np.degrees(told['angle']):.1f} | {m['stretch_stiffness']:.0f} "
        f"| {1e6 * m['bending_rigidity']:.0f} | {m['friction_table']:.2f} | {before:.1f} | {after:.1f} "
        f"| {after / before:.2f} | {row['seconds']:.0f} |"
    )


def cloth_table(rows: list[dict[str, Any]]) -> str:
    """The table of cloths as Markdown."""
    head = (
        "| cloth | calibrated | L1 - L2 [mm] | sag [mm] | slides at [°] | Y [N/m] | B [µN m] | μ "
        "| generic preset [mm] | calibrated [mm] | ratio | seconds |\n" + "|---" * 12 + "|"
    )
    return "\n".join([head, *map(cloth_line, rows)])


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
    """The drawings of docs/calibration.md, from simulated shapes."""
    for name, edges in (("towel", ["bottom"]), ("tshirt", ["left_shoulder", "right_shoulder"])):
        test = Elongation(make_garment(name, spacing=0.04), [Grasp(edge=edge) for edge in edges])
        shape = simulate(test.scene(test.garment.material)).positions[-1]
        write_text(DOCS.parent / f"measure-hang-{name}.svg", hanging(test, shape))
    strip, terry = Sag(0.05), load_material(Path("terry"))
    write_text(DOCS.parent / "measure-sag.svg", sagging(strip, simulate(strip.scene(terry)).positions[-1]))
    write_text(DOCS.parent / "measure-slide.svg", sliding(Slope(float(np.arctan(terry.friction_table)))))


def insert(mark: str, table: str) -> None:
    """Put a table between its marks in docs/calibration.md."""
    pattern = rf"(<!-- calibration: {mark} -->\n).*?(<!-- end -->)"
    write_text(DOCS, re.sub(pattern, lambda found: f"{found[1]}{table}\n{found[2]}", DOCS.read_text(), flags=re.S))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("recovery", "cloths", "pinch", "drawings"))
    parser.add_argument("--out", type=Path, default=Path("runs/calibration"))
    parser.add_argument("--draws", type=int, default=20)
    parser.add_argument("--repeats", type=int, default=4)
    parser.add_argument("--manipulations", type=int, default=10)
    parser.add_argument("--write-docs", action="store_true")
    options = parser.parse_args()
    if options.what == "drawings":
        drawings()
        return
    if options.what == "pinch":
        table = pinch_table(options.out)
    elif options.what == "recovery":
        table = recovery_table(recovery(options.out, options.draws, options.repeats))
    else:
        table = cloth_table(cloths(options.out, options.manipulations))
    print(table)
    if options.write_docs:
        insert(options.what, table)


if __name__ == "__main__":
    main()
