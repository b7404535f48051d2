"""Where each simulator falls short: the textbook checks in all, and a towel fold, for docs/notes/simulators.md.

    python benchmarks/simulators.py --out runs/simulators [--simulators native blender mujoco] [--long] [--write-docs]

Runs the quick cases of every check, and all of `incline` and `layers`; with --long all cases, hours in Blender and in
MuJoCo. What is there already is not run again: remove --out after a change.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

from tests.physics import Subject, validate
from tests.physics.checks import CHECKS

from benchmarks.tables import arguments, kept, show
from benchmarks.timed_folds import towel
from tatamu.base.errors import TatamuError
from tatamu.base.files import read_json, write_json
from tatamu.simulation.blender.process import WORKERS
from tatamu.simulation.simulators import SIMULATORS, simulate

WHOLE = ("incline", "layers")
"""Checks of which every case is run, and has rows of its own."""
Found = dict[str, dict[str, Any]]
"""Results of each check."""


def checked(name: str, folder: Path, long: bool) -> Found:
    """Return every check of a simulator, from its file if there is one."""
    subject, found = Subject.named(name), {}
    for check in CHECKS:
        path = folder / name / f"{check}.json"
        if not path.exists():
            print(f"{name}: {check}", flush=True)
            report = validate(subject, [check], quick=not (long or check in WHOLE))
            if report.results:
                write_json(path, report.to_json())
        if path.exists():
            found[check] = read_json(path)["checks"][0]
    return found


def worst(check: dict[str, Any], apart: bool = False) -> dict[str, dict[str, Any]]:
    """By quantity, the row that is furthest off of all cases, or of each; one without an error is the furthest."""
    rows: dict[str, dict[str, Any]] = {}
    for case in check["cases"]:
        for row in case["rows"]:
            name = f"{case['case']}: {row['quantity']}" if apart else row["quantity"]
            before = rows.get(name)
            if before is None or _further(row["error"], before["error"]):
                rows[name] = row
    return rows


def _further(error: float | None, before: float | None) -> bool:
    return error is None or (before is not None and error > before)


def shortfalls(found: dict[str, Found]) -> Iterator[dict[str, object]]:
    """One row for each quantity that a simulator misses: the largest error of each, bold where beyond the limit."""
    for check in CHECKS:
        columns = {name: worst(own[check], check in WHOLE) for name, own in found.items() if check in own}
        for quantity in dict.fromkeys(quantity for rows in columns.values() for quantity in rows):
            rows = {name: own[quantity] for name, own in columns.items() if quantity in own}
            limit = next((row["limit"] for row in rows.values() if row["limit"] is not None), None)
            unit = next(iter(rows.values()))["unit"].replace("-", "")
            cells = {name: _cell(rows.get(name), limit) for name in found}
            shown = "" if limit is None else f"{limit:g}"
            if not any(cell.startswith("**") for cell in cells.values()):
                continue
            yield {"check": check, "error of": quantity, **cells, "limit": shown, "unit": unit}


def _cell(row: dict[str, Any] | None, limit: float | None) -> str:
    if row is None:
        return "-"
    if row["error"] is None:
        return "**failed**"
    error = f"{row['error']:.2g}"
    return f"**{error}**" if limit is not None and row["error"] > limit else error


def folded(name: str) -> dict[str, str]:
    """A towel fold on a 2 cm mesh: height of the loop, distance from the ideal fold, processor seconds."""
    fold, row = towel(0.02), {"simulator": name}
    before = spent()
    try:
        rollout = simulate(fold.scene, name)
    except TatamuError as error:
        return {**row, "loop [mm]": str(error), "from the ideal fold [mm]": "-", "processor, start included [s]": "-"}
    return {
        **row,
        "loop [mm]": f"{1e3 * rollout.positions[-1][:, 2].max():.0f}",
        "from the ideal fold [mm]": f"{1e3 * fold.distance(rollout):.1f}",
        "processor, start included [s]": f"{spent() - before:.1f}",
    }


def spent() -> float:
    """Processor time of this process and of those that it has ended, among them every Blender [s]."""
    WORKERS.close()
    return sum(os.times()[:4])


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--out", type=Path, default=Path("runs/simulators"))
    parser.add_argument("--simulators", nargs="+", default=list(SIMULATORS), choices=list(SIMULATORS))
    parser.add_argument("--long", action="store_true", help="all cases of every check")
    options = parser.parse_args()
    found = {name: checked(name, options.out, options.long) for name in options.simulators}
    folds = [kept(options.out / name / "fold.json", partial(folded, name)) for name in options.simulators]
    show({"checks": list(shortfalls(found)), "fold": folds}, options.write_docs)


if __name__ == "__main__":
    main()
