"""What docs/notes/validation.md shows of a report: a row for each check, and a picture."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from benchmarks.tables import IMAGES, markdown, publish
from matplotlib.axes import Axes

from tatamu.show.palette import COLOURS, SERIES
from tests.physics.findings import Curve, Figure, Row, in_order
from tests.physics.report import Report

SHOWN = ("hang", "shear", "catenary", "cantilever", "order", "crease", "threshold", "stack", "refinement")
"""Figures of the picture, by key."""
COLUMNS = 3
MARKS = "osD^x+"
INK = COLOURS["ink"][0]
GRID = COLOURS["line"][0]


def write(report: Report) -> None:
    """Write the table and the picture of a report into the docs."""
    judged = f"{report.judged - report.failures} of {report.judged} judged quantities are within their limits."
    publish("results", f"{judged}\n\n{markdown(rows(report))}")
    draw(report, IMAGES / "validation.png")


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
    for curve, place, first in in_order(curves):
        label = curve.name if first else None
        if curve.reference:
            axis.plot(curve.x, curve.y, color=INK, linewidth=1.2, label=label)
            continue
        width = 0.8 if asked.joined else 0.0
        (line,) = axis.plot(curve.x, curve.y, linewidth=width, alpha=0.8, label=label)
        line.set(color=COLOURS[f"series-{place % SERIES}"][0], marker=MARKS[place % len(MARKS)], markersize=3.5)
    axis.set(title=asked.title, xlabel=asked.x, ylabel=asked.y)
    if asked.log:
        axis.set(xscale="log", yscale="log")
    if asked.equal:
        axis.set_aspect("equal", adjustable="datalim")
    axis.grid(color=GRID, linewidth=0.6)
    axis.legend(fontsize=6, frameon=False, ncols=1 + (len({curve.name for curve in curves}) > 6))
