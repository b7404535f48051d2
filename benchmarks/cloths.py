"""Another simulator as the real cloth: the table "cloths" of docs/notes/calibration.md.

    python benchmarks/cloths.py [--only towel ..] [--manipulations 30] [--trials 15] [--out DIR] [--write-docs]

A sheet is measured in one simulator as if it lay on the table, another one is calibrated to the readings, by the
paper's three tests, with the loop, and with the push, and both fold it by the same random manipulations. Beside it the
preset of that kind of cloth, and where the real cloth is a fabric that both simulators know by the same numbers, that
fabric itself: as near as the two come. Where `native` is the one calibrated, a fold is learned in it and replayed on
the real cloth. What is in the folder is not run again.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.ruler import measured, readings, settling
from benchmarks.tables import arguments, kept, markdown, show
from tatamu.after.second_opinion.check import check
from tatamu.api import learn
from tatamu.calibration import calibrate
from tatamu.calibration.laboratory import Laboratory
from tatamu.calibration.sag import Sag
from tatamu.evaluation.nominal import Nominal
from tatamu.folding.parameters import search_space
from tatamu.folding.task import Task, make_task
from tatamu.simulation.material import Material, load_material
from tatamu.simulation.presets import load_preset
from tatamu.simulation.simulators import capabilities
from tatamu.study.options import LearnOptions
from tatamu.study.result import Result

SPACING, FINE = 0.02, 0.012
"""Spacings of the sheets' meshes [m]: for cloth in numbers per spring, and for fabrics, which are limper."""
SHEET, LONG_SHEET = (0.24, 0.38), (0.24, 0.69)
"""Sizes of sheets [m]: whole cells, as numbers of springs mean another cloth on other cells."""
ROW = float(np.sqrt(0.75)) * SPACING
FREE_LENGTHS = [round((rows + 0.5) * ROW, 3) for rows in range(3, 8)]
"""Free lengths that a person tries for the sag of such cloth [m]: of whole cells too."""
SHORTER = [0.02, 0.025, 0.03, 0.035, 0.04, 0.05, 0.06]
"""Free lengths that a person tries for the sag of a fabric [m]."""
CONTACT_ROUNDS = 12
"""Rounds of contact in Blender; with 2, the table does not support cloth under other cloth. See
docs/notes/second-opinion.md."""
READINGS = {"three": (), "four": ("loop",), "five": ("loop", "push")}
"""Readings in addition to the paper's three."""
TITLES = {
    "preset": "with the preset",
    "three": "three readings",
    "four": "and the loop",
    "five": "and the push",
    "hidden": "the cloth's own numbers",
}
DRAWN = ("areal_density", "stretch_stiffness", "bending_rigidity", "friction_table", "friction_cloth")
"""Fields that differ from the preset in a cloth of its kind, within the preset's spread."""


@dataclass(frozen=True)
class Case:
    """A cloth, the simulator in which it is real, and the simulator that is calibrated to it."""

    name: str
    real: Material
    of: str
    learner: str
    preset: str
    """Preset of that kind of cloth: calibration starts from it and is compared with it."""
    size: tuple[float, float] = SHEET

    @property
    def title(self) -> str:
        """Name in file names."""
        return f"{self.name}-{self.of}-{self.learner}"

    @property
    def spacing(self) -> float:
        """Spacing of the sheet's mesh [m]."""
        return FINE if self.real.blender is None else SPACING

    @property
    def cells(self) -> float | None:
        """Of the tests' meshes [m]: the sheet's for numbers per spring; None: as fine as each test wants."""
        return None if self.real.blender is None else SPACING


def paper_cloth(garment: str) -> Material:
    """Blender's cloth under the paper's Tables I and II, but with contact that holds."""
    preset = load_material(Path(f"paper-{garment}"))
    return preset.model_copy(update={"blender": {**(preset.blender or {}), "collision_quality": CONTACT_ROUNDS}})


def another(name: str, seed: int) -> Material:
    """A cloth of the kind of a preset: each figure drawn from the spread in its source."""
    preset, random = load_preset(name), np.random.default_rng([60, seed])
    spreads = {field: np.log(preset.spread[field]) for field in DRAWN if field in preset.spread}
    drawn = {field: float(np.exp(random.uniform(low, high))) for field, (low, high) in spreads.items()}
    return preset.material.model_copy(update=drawn)


def cases() -> list[Case]:
    """Blender's cloth for native, native's for Blender, and both with MuJoCo."""
    knit, denim = another("interlock", 1), another("denim", 2)
    return [
        Case("towel", paper_cloth("towel"), "blender", "native", "terry", LONG_SHEET),
        Case("tshirt", paper_cloth("tshirt"), "blender", "native", "interlock", LONG_SHEET),
        Case("trousers", paper_cloth("trousers"), "blender", "native", "denim", LONG_SHEET),
        Case("interlock", knit, "native", "blender", "interlock"),
        Case("denim", denim, "native", "blender", "denim"),
        Case("interlock", knit, "mujoco", "native", "interlock"),
        Case("denim", denim, "native", "mujoco", "denim"),
    ]


def sag_length(case: Case) -> float:
    """The free length at which the edge hangs down about half of it, as a person would find by trying [m]."""
    material = settling(case.real)
    lengths = SHORTER if case.cells is None else FREE_LENGTHS
    share = [Laboratory(case.of).reading(Sag(d, case.cells), material) / d for d in lengths]
    return lengths[int(np.argmin(np.abs(np.array(share) - 0.5)))]


def task_of(case: Case, material: Material, simulator: str) -> Task:
    """Return the half fold of the sheet."""
    return make_task("towel", size=case.size, material=material, spacing=case.spacing, simulator=simulator)


def final_shapes(task: Task, count: int) -> list[np.ndarray | None]:
    """Where the sheet ends after `count` manipulations drawn evenly from what the search may choose; None: failed."""
    random, space = np.random.default_rng(60), search_space(task.fold, "continuous").bounds
    low, high = (np.array([getattr(among, end) for among in space.values()]) for end in ("low", "high"))
    drawn = [dict(zip(space, random.uniform(low, high), strict=True)) for _ in range(count)]
    rollouts = [Nominal(task)(each).rollout for each in drawn]
    return [None if rollout is None else rollout.positions[-1] for rollout in rollouts]


def apart(first: list[np.ndarray | None], second: list[np.ndarray | None]) -> list[float | None]:
    """Return the mean vertex distances [m] between two outcomes of each manipulation."""
    return [
        None if a is None or b is None else float(np.linalg.norm(a - b, axis=1).mean())
        for a, b in zip(first, second, strict=True)
    ]


def replayed(case: Case, task: Task, folder: Path, trials: int) -> dict[str, float | None]:
    """A fold learned in the learner and replayed on the real cloth: mean vertex distances [m].

    From its target as learned, from the same target on the real cloth, and between the two shapes.
    """
    options = LearnOptions(trials=trials, disturbances="none", baselines=False)
    learned = learn(task, options, out=folder)
    assert isinstance(learned, Result)
    opinion = check(learned, case.of, case.real)
    return {
        "learned": opinion.learned.score.mean_vertex_distance,
        "replayed": opinion.score.mean_vertex_distance if opinion.score else None,
        "between": float(opinion.apart.mean()) if opinion.rollout else None,
    }


def compare(case: Case, count: int, trials: int, folder: Path) -> dict[str, Any]:
    """Measure the real cloth, calibrate the learner to it, and compare folds with the preset's."""
    true = measured(case.real, case.of, case.size, sag_length(case), case.cells, READINGS["five"])
    row: dict[str, Any] = {"readings": true, "preset": {"material": load_material(Path(case.preset)).model_dump()}}
    for name, more in READINGS.items():
        if "push" in more and not capabilities(case.learner).compression:
            continue
        told = readings(true, case.size, more=more, material=case.preset, thickness=case.real.thickness)
        started = time.perf_counter()
        found = calibrate(told, case.learner, case.cells)
        row[name] = {"material": found.material.model_dump(), "seconds": time.perf_counter() - started}
    if case.real.blender is None:
        row["hidden"] = {"material": case.real.model_dump()}
    truth = final_shapes(task_of(case, case.real, case.of), count)
    for name in columns(row):
        task = task_of(case, Material.model_validate(row[name]["material"]), case.learner)
        row[name]["apart"] = apart(truth, final_shapes(task, count))
        if case.learner == "native":
            row[name]["fold"] = replayed(case, task, folder / f"{case.title}-{name}", trials)
    return row


def columns(row: dict[str, Any]) -> list[str]:
    """Return the materials of `TITLES` that a row has."""
    return [name for name in TITLES if name in row]


def measured_line(case: Case, row: dict[str, Any]) -> dict[str, str]:
    """Return the readings of a cloth, and the calibration from them."""
    true, three, four = row["readings"], row["three"]["material"], row["four"]["material"]
    five = row.get("five", {}).get("material", {})
    return {
        "cloth": f"{case.name} in {case.of}",
        "calibrated": case.learner,
        "L1 - L2 [mm]": f"{1e3 * (true['L1'] - true['L2']):.1f}",
        "slides at [°]": f"{np.degrees(true['angle']):.1f}",
        "sag [mm]": f"{1e3 * true['sag']:.0f} of {1e3 * true['free_length']:.0f}",
        "loop [mm]": f"{1e3 * true['loop']:.0f}",
        "moved [mm]": f"{1e3 * max(true['moved'], 0.0):.0f}" if "moved" in true else "-",
        "Y [N/m]": f"{three['stretch_stiffness']:.0f}",
        "μ": f"{three['friction_table']:.2f}",
        "B by sag [µN m]": f"{1e6 * three['bending_rigidity']:.0f}",
        "B by sag and loop [µN m]": f"{1e6 * four['bending_rigidity']:.0f}",
        "c": f"{five.get('compression', 1.0):.2g}" if five else "-",
        "seconds": ", ".join(f"{row[name]['seconds']:.0f}" for name in READINGS if name in row),
    }


def compared_line(case: Case, row: dict[str, Any]) -> dict[str, str]:
    """Return the distances of preset and calibrations from the real cloth after the random manipulations."""
    told = {"cloth": f"{case.name} in {case.of}", "calibrated": case.learner, "preset": case.preset}
    names, middles = columns(row), {}
    folds = zip(*(row[name]["apart"] for name in names), strict=True)
    finished = [k for k, each in enumerate(folds) if None not in each]
    told["folds"] = str(len(finished))
    for name in names:
        lengths = 1e3 * np.array([row[name]["apart"][k] for k in finished])
        middles[name] = float(np.mean(lengths)), float(np.median(lengths))
    for name, title in TITLES.items():
        told[f"{title}: mean, median [mm]"] = "{:.1f}, {:.1f}".format(*middles[name]) if name in row else "-"
        if name != "preset":
            ratios = [a / b for a, b in zip(middles.get(name, ()), middles["preset"], strict=False)]
            told[f"{title}: ratios"] = "{:.2f}, {:.2f}".format(*ratios) if ratios else "-"
    return told


def replayed_line(case: Case, row: dict[str, Any]) -> dict[str, str]:
    """Return the results of learned folds on the real cloth."""

    def words(fold: dict[str, float | None]) -> str:
        lengths = ["failed" if fold[key] is None else f"{1e3 * (fold[key] or 0.0):.1f}" for key in fold]
        return "{} → {}; {}".format(*lengths)

    told = {"cloth": f"{case.name} in {case.of}"}
    return told | {f"{title} [mm]": words(row[name]["fold"]) if name in row else "-" for name, title in TITLES.items()}


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--only", nargs="+", help="cloths, such as towel or denim; default: all")
    parser.add_argument("--manipulations", type=int, default=30)
    parser.add_argument("--trials", type=int, default=15)
    parser.add_argument("--out", type=Path, default=Path("runs/calibration"))
    options = parser.parse_args()
    rows = []
    for case in cases():
        path = options.out / f"cloth-{case.title}.json"
        if path.exists() or not options.only or case.name in options.only:
            find = partial(compare, case, options.manipulations, options.trials, options.out)
            rows.append((case, kept(path, find)))
    learned = [(case, row) for case, row in rows if case.learner == "native"]
    tables = [
        markdown([line(*row) for row in some])
        for line, some in ((measured_line, rows), (compared_line, rows), (replayed_line, learned))
        if some
    ]
    show({"calibration: cloths": "\n\n".join(tables)}, options.write_docs)


if __name__ == "__main__":
    main()
