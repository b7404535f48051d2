"""How fast folds are, side by side: `native`, Blender, MuJoCo, Newton. The tables of docs/benchmarks.md.

    python benchmarks/speed.py [--only towel ..] [--simulators native ..] [--runs 3] [--out FILE] [--write-docs]

Parts: towel (two meshes), shirt (the T-shirt), growth (native, from 850 to 13,000 vertices, time and memory),
answer (seconds until a finer mesh changes nothing), throughput (`simulate_many`), startup (import). Parts that run
replace theirs in the JSON file, the others stay. Simulators run in turn, `--runs` times each on one core (but for
throughput); medians are given, and only of rollouts that ended folded.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import resource
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import Any

import numpy as np
from engines import ENGINES, run
from scipy.interpolate import LinearNDInterpolator
from tables import insert, markdown
from timed_folds import CLOTH, FABRICS, FOLDED, SIZE, Fold, shirt, towel

from tatamu import __version__, simulate_many
from tatamu.errors import InputError, TatamuError
from tatamu.files import read_json, write_json
from tatamu.rollout import Rollout

Row = dict[str, Any]
SPACINGS = (0.02, 0.01)
GROWTH = (0.02, 0.01414, 0.01, 0.00707, 0.005)
ANSWER = (0.02, 0.014, 0.01, 0.007)
RIGHT = 0.003
"""A shape within this of the finest mesh's is a right answer, root mean square [m]."""
BATCH = {"native": 16, "blender": 4, "mujoco": 2}
"""Scenes that `simulate_many` is given."""
SLOW = {"newton": 1}
"""Simulators whose rollouts take minutes are run this often at most."""


def compared(folds: Sequence[Fold], options: argparse.Namespace) -> list[Row]:
    """Each fold in each simulator, in turn."""
    rows = []
    for fold in folds:
        seconds: dict[str, list[float]] = {engine: [] for engine in options.simulators}
        notes: dict[str, str] = {}
        for turn in range(options.runs):
            for engine in options.simulators:
                if engine in notes or turn >= SLOW.get(engine, options.runs):
                    continue
                try:
                    seconds[engine].append(_timed(engine, fold))
                except TatamuError as error:
                    notes[engine] = str(error)
        rows += [_row(fold, engine, seconds, notes.get(engine, "")) for engine in options.simulators]
    return rows


def _timed(engine: str, fold: Fold) -> float:
    """Seconds of the simulation alone.

    Raises:
        TatamuError: It did not run, or did not fold.
    """
    rollout = run(engine, fold.scene)
    _check_folded(fold, rollout)
    return float(rollout.info["wall_seconds"])


def _check_folded(fold: Fold, rollout: Rollout) -> None:
    distance = fold.distance(rollout)
    if not distance <= FOLDED:
        raise TatamuError(f"did not fold: {1e3 * distance:.0f} mm from the target, {1e3 * FOLDED:g} mm are allowed")


def _row(fold: Fold, engine: str, seconds: dict[str, list[float]], note: str) -> Row:
    own, base = seconds[engine], seconds.get("native")
    timed = bool(own) and not note
    ratio = f"{median(own) / median(base):.1f}" if timed and base else "-"
    return {
        "fold": fold.name,
        "vertices": len(fold.target),
        "simulator": engine,
        "seconds": _short(median(own)) if timed else "-",
        "over native": ratio,
        "runs": len(own) if timed else 0,
        "note": note or "-",
    }


def growth(options: argparse.Namespace) -> list[Row]:
    """Time and peak memory of native by vertices, each run in a process of its own; the exponent in the last row."""
    rows = []
    for spacing in GROWTH:
        found = [_alone(spacing) for _ in range(options.runs)]
        seconds, peak = median(f["seconds"] for f in found), max(f["peak"] for f in found)
        rows.append({"vertices": found[0]["vertices"], "seconds": _short(seconds), "peak memory [MB]": round(peak)})
    slope = np.polyfit(*(np.log([float(row[key]) for row in rows]) for key in ("vertices", "seconds")), 1)[0]
    return [*rows, {"vertices": "exponent", "seconds": f"{slope:.2f}", "peak memory [MB]": "-"}]


def _alone(spacing: float) -> Row:
    command = [sys.executable, __file__, "--alone", str(spacing)]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)
    return dict(json.loads(done.stdout))


def alone(spacing: float) -> None:
    """What the process of one `growth` run prints."""
    fold = towel(spacing)
    seconds = _timed("native", fold)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(json.dumps({"vertices": len(fold.target), "seconds": seconds, "peak": peak}))


def answer(options: argparse.Namespace) -> list[Row]:
    """Distance to the finest mesh's shape and seconds, by fabric, simulator and mesh; what is right and fastest."""
    rows = []
    for fabric, material in FABRICS.items():
        for engine in options.simulators:
            rows += _answers(fabric, engine, [towel(spacing, material) for spacing in ANSWER])
    return rows


def _answers(fabric: str, engine: str, folds: Sequence[Fold]) -> list[Row]:
    rows: list[Row] = []
    finest = None
    for fold, spacing in reversed(list(zip(folds, ANSWER, strict=True))):
        row = {"fabric": fabric, "simulator": engine, "spacing [mm]": 1e3 * spacing, "vertices": len(fold.target)}
        try:
            rollout = run(engine, fold.scene)
            _check_folded(fold, rollout)
        except TatamuError as error:
            rows.append({**row, "seconds": "-", "rms to finest [mm]": "-", "within 3 mm": str(error)})
            if finest is None:
                break  # without its own converged shape nothing can be said of coarser meshes
            continue
        shape = _shape(fold, rollout)
        finest = shape if finest is None else finest
        away = float(np.sqrt(((shape - finest) ** 2).sum(axis=1).mean()))
        right = "finest" if finest is shape else "yes" if away <= RIGHT else "no"
        seconds = _short(rollout.info["wall_seconds"])
        rows.append({**row, "seconds": seconds, "rms to finest [mm]": f"{1e3 * away:.1f}", "within 3 mm": right})
    return rows[::-1]


def _shape(fold: Fold, rollout: Rollout) -> np.ndarray:
    """Where the material points of one fixed grid end [m], so that meshes can be compared, shape (k, 3)."""
    width, length = SIZE
    x, y = np.meshgrid(np.linspace(-0.499, 0.499, 81) * length, np.linspace(-0.499, 0.499, 35) * width)
    flat = fold.scene.cloth.rest[:, :2]
    return np.asarray(LinearNDInterpolator(flat, rollout.positions[-1])(x.ravel(), y.ravel()))


def throughput(options: argparse.Namespace) -> list[Row]:
    """Rollouts per second of `simulate_many` on all cores, each scene with hands that rise a little higher."""
    rows: list[Row] = []
    os.sched_setaffinity(0, range(os.cpu_count() or 1))
    for engine in (name for name in options.simulators if name in BATCH):
        folds = [towel(SPACINGS[0], height=height) for height in np.linspace(0.45, 0.55, BATCH[engine])]
        try:
            simulate_many([fold.scene for fold in folds[:2]], simulator=engine)  # starts processes
            begin = perf_counter()
            rollouts = simulate_many([fold.scene for fold in folds], simulator=engine)
            rate = len(folds) / (perf_counter() - begin)
            for fold, rollout in zip(folds, rollouts, strict=True):
                _check_folded(fold, rollout)
        except TatamuError as error:
            rows.append({"simulator": engine, "scenes": len(folds), "rollouts/s": "-", "note": str(error)})
            continue
        rows.append({"simulator": engine, "scenes": len(folds), "rollouts/s": _short(rate), "note": "-"})
    return rows


def startup(options: argparse.Namespace) -> list[Row]:
    """Seconds to import, each time in a new process."""
    statements = ("import tatamu", "from tatamu import Scene, simulate", "import tatamu.simulators.native")
    return [{"statement": f"`{s}`", "seconds": _short(_import(s, max(options.runs, 5)))} for s in statements]


def _import(statement: str, runs: int) -> float:
    code = f"import time; t = time.perf_counter(); {statement}; print(time.perf_counter() - t)"
    command = [sys.executable, "-c", code]
    return median(float(subprocess.check_output(command, text=True)) for _ in range(runs))


def _short(seconds: float) -> str:
    return f"{seconds:.3g}"


PARTS: dict[str, Callable[[argparse.Namespace], list[Row]]] = {
    "towel": lambda options: compared([towel(spacing) for spacing in SPACINGS], options),
    "shirt": lambda options: compared([shirt(0.02)], options),
    "growth": growth,
    "answer": answer,
    "throughput": throughput,
    "startup": startup,
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", choices=PARTS, default=list(PARTS), help="these parts")
    parser.add_argument("--simulators", nargs="+", choices=ENGINES, default=list(ENGINES))
    parser.add_argument("--runs", type=int, default=3, help="rollouts of each kind, at most")
    parser.add_argument("--out", type=Path, default=Path("runs/speed.json"))
    parser.add_argument("--write-docs", action="store_true", help="write the tables into docs/benchmarks.md")
    parser.add_argument("--alone", type=float, help=argparse.SUPPRESS)
    options = parser.parse_args()
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    if options.alone:
        return alone(options.alone)
    _warm(options.simulators)
    for part in sorted(options.only, key=lambda name: name == "throughput"):  # the one that takes all cores is last
        rows = PARTS[part](options)
        before = read_json(options.out) if options.out.exists() else {}
        machine = {"machine": platform.processor() or platform.machine(), "cores": os.cpu_count()}
        write_json(options.out, {**before, part: {**machine, "version": __version__, "rows": rows}})
        print(f"\n{part}\n\n{markdown(rows)}", flush=True)
        if options.write_docs:
            insert(part, markdown(rows))


def _warm(engines: Sequence[str]) -> None:
    """Compile what is compiled, start what is started: a moment of a fold in each."""
    for engine in engines:
        try:
            run(engine, towel(0.02, CLOTH).scene.model_copy(update={"duration": 0.1}))
        except InputError as error:
            print(error, file=sys.stderr)


if __name__ == "__main__":
    main()
