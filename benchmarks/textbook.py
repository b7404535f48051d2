"""Results of docs/notes/validation.md: every textbook check on a simulator, as a table and a picture.

    python benchmarks/textbook.py --out runs/validation [--simulator native] [--only hang] [--write-docs]

Writes what `tatamu validate --out` writes, and `validation.png`.
"""

from __future__ import annotations

import argparse
import shutil
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from benchmarks.tables import IMAGES, markdown, publish
from tatamu.base.files import write_json, write_text
from tatamu.show.palette import COLOURS, SERIES
from tatamu.validation import Subject, validate
from tatamu.validation.findings import Curve, Figure, Row
from tatamu.validation.page import page
from tatamu.validation.report import Report

SHOWN = ("hang", "shear", "catenary", "cantilever", "order", "crease", "threshold", "stack", "refinement")
"""Figures of the picture, by key."""
COLUMNS = 3
MARKS = "osD^x+"
INK = COLOURS["ink"][0]
GRID = COLOURS["line"][0]


def rows(report: Report) -> list[dict[str, str]]:
    """Each check: how many quantities are judged, how many pass, and what comes nearest to its limit or beyond."""
    lines = []
    for result in report.results:
        judged = [(case.label, row) for case in result.cases for row in case.rows if row.passed is not None]
        label, worst = max(judged, key=lambda pair: _part(pair[1]))
        lines.append(
            {
                "check": f"`{result.check.name}`",
                "pass": f"{sum(bool(row.passed) for _, row in judged)} of {len(judged)}",
                "nearest to its limit, or farthest beyond": f"{label}: {worst.quantity}",
                "error": _number(worst.error, worst.unit),
                "limit": _number(worst.limit or 0.0, worst.unit),
            }
        )
    return lines


def _part(row: Row) -> float:
    """Return the error as a fraction of its limit; one that is not a number comes first."""
    if not np.isfinite(row.error):
        return np.inf
    return row.error / row.limit if row.limit else np.inf * np.sign(row.error) if row.error else 0.0


def _number(value: float, unit: str) -> str:
    return f"{value:.2g}" + ("" if unit == "-" else f" {unit}")


def draw(report: Report, out: Path) -> None:
    """Plot the simulator's values (points) against the references (lines), one panel for each figure."""
    panels = [
        (result, key, result.check.figures[key])
        for key in SHOWN
        for result in report.results
        if key in result.check.figures and result.curves(key)
    ]
    count = -(-len(panels) // COLUMNS)
    with plt.rc_context({"font.size": 8, "axes.edgecolor": "#9aa5b1", "text.color": INK, "axes.labelcolor": INK}):
        figure, axes = plt.subplots(count, COLUMNS, figsize=(12, 3.7 * count), layout="constrained", squeeze=False)
        for axis in axes.flat[len(panels) :]:
            axis.set_axis_off()
        for axis, (result, key, asked) in zip(axes.flat, panels, strict=False):
            _panel(axis, result.curves(key), asked)
        figure.savefig(out, dpi=110)


def _panel(axis: Axes, curves: list[Curve], asked: Figure) -> None:
    names = list(dict.fromkeys(curve.name for curve in curves if not curve.reference))
    seen: set[str] = set()
    for curve in sorted(curves, key=lambda curve: not curve.reference):
        label = None if curve.name in seen else curve.name
        seen.add(curve.name)
        if curve.reference:
            axis.plot(curve.x, curve.y, color=INK, linewidth=1.2, label=label)
            continue
        place = names.index(curve.name)
        width = 0.8 if asked.joined else 0.0
        (line,) = axis.plot(curve.x, curve.y, linewidth=width, alpha=0.8, label=label)
        line.set(color=COLOURS[f"series-{place % SERIES}"][0], marker=MARKS[place % len(MARKS)], markersize=3.5)
    axis.set(title=asked.title, xlabel=asked.x, ylabel=asked.y)
    if asked.log:
        axis.set(xscale="log", yscale="log")
    if asked.equal:
        axis.set_aspect("equal", adjustable="datalim")
    axis.grid(color=GRID, linewidth=0.6)
    axis.legend(fontsize=6, frameon=False, ncols=1 + (len(seen) > 6))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--simulator", default="native")
    parser.add_argument("--only", action="append", default=[], metavar="CHECK")
    parser.add_argument(
        "--write-docs", action="store_true", help="write table and picture into docs/notes/validation.md"
    )
    options = parser.parse_args()
    report = validate(
        Subject.named(options.simulator), options.only, after=lambda result: print(result.check.name, flush=True)
    )
    write_json(options.out / "validation.json", report.to_json())
    write_text(options.out / "validation.html", page(report))
    draw(report, options.out / "validation.png")
    table = markdown(rows(report))
    print(table)
    if options.write_docs:
        summary = f"{report.judged - report.failures} of {report.judged} judged quantities are within their limits.\n\n"
        publish("results", summary + table)
        shutil.copy(options.out / "validation.png", IMAGES / "validation.png")


if __name__ == "__main__":
    main()
