"""How fast folds are, side by side: `native`, Blender, MuJoCo, Newton. The tables of docs/notes/benchmarks.md.

    python benchmarks/speed.py [--only towel ..] [--simulators native ..] [--runs 3] [--out FOLDER] [--write-docs]

Parts: towel (two meshes), shirt (the T-shirt), growth (native, from 850 to 13,000 vertices, time and memory),
answer (seconds until a finer mesh changes nothing), stepping (native, the towel led by a controller, over the same in
one go), throughput (`simulate_many`, and one after another on all cores), startup (import).

Simulators run in turn, `--runs` times each on one core (but for throughput), each rollout in a
process of its own; medians are given, and only of rollouts that ended folded. Rollouts are kept in the folder, and one
that is there is not run again, so a killed run goes on; to measure again, remove them.
"""

from __future__ import annotations

import argparse
import os
import platform
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from statistics import median
from time import perf_counter, process_time
from typing import Any

import numpy as np

from benchmarks.engines import ENGINES
from benchmarks.tables import arguments, show
from benchmarks.timed_folds import FABRICS, FOLDED, Fold, towel
from benchmarks.timed_rollouts import Case, Timing, check_folded, timed
from tatamu import HandTarget, Simulation, __version__, simulate, simulate_many
from tatamu.base.errors import TatamuError
from tatamu.base.files import read_json, write_json

Row = dict[str, Any]
TOWEL = (0.026, 0.01)
"""Spacings of the towel's meshes, of which the first is the default [m]."""
SPACING = 0.02
"""Spacing of the meshes of other parts [m]."""
GROWTH = (0.02, 0.01414, 0.01, 0.00707, 0.005)
ANSWER = (0.02, 0.014, 0.01, 0.007)
HELD_OPEN, *ANSWER_FABRICS = FABRICS
"""All simulators hold the loop of the first open on a 2 cm mesh, or nearly; `answer` takes the others."""
RIGHT = 0.003
"""Largest distance of a correct shape from that of the finest mesh, root mean square [m]."""
CONTROL = (10, 60, 200)
"""Rates at which a controller gives targets [Hz]."""
PIECE = 0.1
"""Length of a piece of a rollout that is timed by itself [s]."""
TURNS = 8
"""Smallest number of rollouts at each rate; differences are a few per cent."""
BATCH = {"native": 16, "blender": 4, "mujoco": 2}
"""Number of scenes given to `simulate_many`."""


def compared(cases: Sequence[Case], options: argparse.Namespace) -> list[Row]:
    """Each fold in each simulator, in turn; one whose runs took `--limit` seconds is run no more."""
    found: dict[Case, list[Timing]] = {case: [] for case in cases}
    for turn in range(options.runs):
        for case, timings in found.items():
            if turn == 0 or (timings[-1].note == "" and sum(t.seconds for t in timings) < options.limit / 2):
                timings.append(timed(case, turn, options.out, options.limit))
    return [_row(case, timings, _base(case, found)) for case, timings in found.items()]


def _base(case: Case, found: Mapping[Case, Sequence[Timing]]) -> Sequence[Timing]:
    return found.get(replace(case, engine="native"), ())


def _row(case: Case, own: Sequence[Timing], base: Sequence[Timing]) -> Row:
    ended = [t.seconds for t in own if not t.note]
    native = [t.seconds for t in base if not t.note]
    return {
        "fold": case.kind,
        "spacing [mm]": f"{1e3 * case.spacing:g}",
        "vertices": len(case.fold.target),
        "simulator": case.engine,
        "seconds": _short(median(ended)) if ended else "-",
        "over native": f"{median(ended) / median(native):.1f}" if ended and native else "-",
        "runs": len(ended),
        "note": own[-1].note or "-",
    }


def _sentence(rows: Sequence[Row]) -> str:
    """The README's figure: seconds of one rollout of the towel on the coarsest mesh of the table, by simulator."""
    few = min(row["vertices"] for row in rows)
    seconds = {row["simulator"]: row["seconds"] for row in rows if row["vertices"] == few}
    own = seconds.pop("native")
    others = ", ".join(f"{name} {'does not fold it' if time == '-' else f'{time} s'}" for name, time in seconds.items())
    fold = f"On the default mesh of {few} vertices, a simulated fold of that towel (5 s)"
    return f"{fold} takes {own} s on one core ({others}; `make bench`)."


def _cases(kind: str, spacings: Sequence[float], options: argparse.Namespace) -> list[Case]:
    return [Case(engine, kind, HELD_OPEN, spacing) for spacing in spacings for engine in options.simulators]


def growth(options: argparse.Namespace) -> list[Row]:
    """Time and peak memory of native by vertices; the exponent in the last row."""
    rows = []
    for spacing in GROWTH:
        case = Case("native", "towel", HELD_OPEN, spacing)
        found = [timed(case, turn, options.out, options.limit) for turn in range(options.runs)]
        seconds, peak = median(t.seconds for t in found), max(t.peak for t in found)
        rows.append({"vertices": found[0].vertices, "seconds": _short(seconds), "peak memory [MB]": round(peak)})
    sizes, times = (np.log([float(str(row[key])) for row in rows]) for key in ("vertices", "seconds"))
    slope = np.polyfit(sizes, times, 1)[0]
    return [*rows, {"vertices": "exponent", "seconds": f"{slope:.2f}", "peak memory [MB]": "-"}]


def answer(options: argparse.Namespace) -> list[Row]:
    """Distance to the finest mesh's shape and seconds, by fabric, simulator and mesh; what is right and fastest."""
    rows = []
    for fabric in ANSWER_FABRICS:
        for engine in options.simulators:
            cases = [Case(engine, "towel", fabric, spacing) for spacing in ANSWER]
            rows += _answers([c for c in cases if not options.kept or (options.out / c.file(0)).exists()], options)
    return rows


def _answers(cases: Sequence[Case], options: argparse.Namespace) -> list[Row]:
    """From the coarsest mesh to the finest that ends in time; that one is the reference."""
    found: dict[Case, Timing] = {}
    for case in cases:
        found[case] = timed(case, 0, options.out, options.limit)
        if found[case].note.startswith("given up"):
            break  # a finer mesh would take longer
    finest = next((t.shape for t in reversed(found.values()) if not t.note), None)
    return [_answer_row(case, timing, finest) for case, timing in found.items()]


def _answer_row(case: Case, timing: Timing, finest: np.ndarray | None) -> Row:
    row = {
        "fabric": case.fabric,
        "simulator": case.engine,
        "spacing [mm]": f"{1e3 * case.spacing:g}",
        "vertices": len(case.fold.target),
    }
    if timing.note or finest is None:
        return {**row, "seconds": "-", "rms to finest [mm]": "-", "within 3 mm": timing.note}
    away = float(np.sqrt(((timing.shape - finest) ** 2).sum(axis=1).mean()))
    right = "finest" if timing.shape is finest else "yes" if away <= RIGHT else "no"
    return {**row, "seconds": _short(timing.seconds), "rms to finest [mm]": f"{1e3 * away:.1f}", "within 3 mm": right}


def stepping(options: argparse.Namespace) -> list[Row]:
    """A towel that a controller leads, over the same scene in one go.

    They run in turn, in pieces of `PIECE`; of each piece the fewest seconds of the processor count, because other work
    on the machine can only add to them.
    """
    fold = towel(SPACING)
    simulate(fold.scene.model_copy(update={"duration": 0.1}))  # load what is compiled
    seconds: dict[int, list[np.ndarray]] = {rate: [] for rate in (0, *CONTROL)}
    for _ in range(max(options.runs, TURNS)):
        for rate, found in seconds.items():
            found.append(_controlled(fold, rate) if rate else _in_one_go(fold))
    fewest = {rate: np.min(found, axis=0) for rate, found in seconds.items()}
    whole = fewest.pop(0)
    rows: list[Row] = [{"control": "none, in one go", "steps/s": "-", "over one go": "1.000"}]
    for rate, found in fewest.items():
        steps = round(rate * fold.scene.duration) / found.sum()
        ratio = found.sum() / whole[: len(found)].sum()
        rows.append({"control": f"{rate} Hz", "steps/s": round(steps), "over one go": f"{ratio:.3f}"})
    return rows


def _in_one_go(fold: Fold) -> np.ndarray:
    """Return the processor time of each piece of a rollout [s]."""
    simulation = Simulation(fold.scene)
    marks = [process_time()]
    while not simulation.done:
        simulation.advance(PIECE)
        marks.append(process_time())
    return np.diff(marks)


def _controlled(fold: Fold, rate: int) -> np.ndarray:
    """The same for a rollout whose hands are given their places as targets, at that rate [Hz]."""
    scene = fold.scene
    simulation = Simulation(scene)
    instants = np.arange(1, round(rate * scene.duration) + 1) / rate
    paths = np.stack([gripper.path(instants) for gripper in scene.grippers], axis=1)
    opens = [gripper.opens for gripper in scene.grippers]
    marks = [process_time()]
    for number, (time, places) in enumerate(zip(instants, paths, strict=True), start=1):
        held = [end is None or time <= end for end in opens]
        simulation.advance(
            time - simulation.time,
            [
                HandTarget(place, True) if closed else HandTarget(closed=False)
                for place, closed in zip(places, held, strict=True)
            ],
        )
        simulation.positions.sum()  # a controller looks
        if number % round(rate * PIECE) == 0 or number == len(instants):
            marks.append(process_time())
    if not np.linalg.norm(simulation.positions - fold.target, axis=1).mean() < FOLDED:
        raise SystemExit("the towel that was led did not fold: its time counts for nothing")
    return np.diff(marks)


def throughput(options: argparse.Namespace) -> list[Row]:
    """Rollouts per second on all cores, of `simulate_many` and one after another; each with hands a little higher."""
    rows: list[Row] = []
    os.sched_setaffinity(0, range(os.cpu_count() or 1))
    for engine in (name for name in options.simulators if name in BATCH):
        folds = [towel(SPACING, height=height) for height in np.linspace(0.45, 0.55, BATCH[engine])]
        for together in (True, False):
            how = "side by side" if together else "one after another"
            row = {"simulator": engine, "scenes": len(folds), "how": how}
            try:
                rows.append({**row, "rollouts/s": _short(_rate(engine, folds, together)), "note": "-"})
            except TatamuError as error:
                rows.append({**row, "rollouts/s": "-", "note": str(error)})
    return rows


def _rate(engine: str, folds: Sequence[Fold], together: bool) -> float:
    """Return rollouts per second; each is checked to have folded."""
    scenes = [fold.scene for fold in folds]
    simulate_many(scenes[:2], simulator=engine)  # starts processes
    begin = perf_counter()
    rollouts = simulate_many(scenes, engine) if together else [simulate(scene, engine) for scene in scenes]
    rate = len(folds) / (perf_counter() - begin)
    for fold, rollout in zip(folds, rollouts, strict=True):
        check_folded(fold, rollout)
    return rate


def startup(options: argparse.Namespace) -> list[Row]:
    """Return the time of an import in a new process [s]."""
    statements = ("import tatamu", "from tatamu import Scene, simulate", "import tatamu.simulation.native")
    return [{"statement": f"`{s}`", "seconds": _short(_import(s, max(options.runs, 5)))} for s in statements]


def _import(statement: str, runs: int) -> float:
    code = f"import time; t = time.perf_counter(); {statement}; print(time.perf_counter() - t)"
    command = [sys.executable, "-c", code]
    return median(float(subprocess.check_output(command, text=True)) for _ in range(runs))


def _short(seconds: float) -> str:
    return f"{seconds:.3g}" if seconds < 999.5 else f"{seconds:.0f}"


PARTS: dict[str, Callable[[argparse.Namespace], list[Row]]] = {
    "towel": lambda options: compared(_cases("towel", TOWEL, options), options),
    "shirt": lambda options: compared(_cases("T-shirt", (SPACING,), options), options),
    "growth": growth,
    "answer": answer,
    "stepping": stepping,
    "throughput": throughput,
    "startup": startup,
}


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--only", nargs="+", choices=PARTS, default=list(PARTS), help="these parts")
    parser.add_argument("--simulators", nargs="+", choices=ENGINES, default=list(ENGINES))
    parser.add_argument("--runs", type=int, default=3, help="rollouts of each kind, at most")
    parser.add_argument("--out", type=Path, default=Path("runs/speed"), help="folder of the rollouts and results.json")
    parser.add_argument("--limit", type=float, default=1800.0, help="a rollout that takes longer is given up [s]")
    parser.add_argument("--kept", action="store_true", help="answer: only what was run before")
    options = parser.parse_args()
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    for part in sorted(options.only, key=lambda name: name == "throughput"):  # the one that takes all cores is last
        rows = PARTS[part](options)
        _record(options.out / "results.json", part, rows)
        short = {"speed: short": _sentence(rows)} if part == "towel" and options.write_docs else {}
        show({part: rows, **short}, options.write_docs)


def _record(out: Path, part: str, rows: list[Row]) -> None:
    before = read_json(out) if out.exists() else {}
    machine = {"machine": platform.processor() or platform.machine(), "cores": os.cpu_count()}
    write_json(out, {**before, part: {**machine, "version": __version__, "rows": rows}})


if __name__ == "__main__":
    main()
