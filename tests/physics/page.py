"""The report of all checks as one page that opens offline, with results, charts and all rows."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tatamu.show.chart import Chart, Plot, axis, traces
from tatamu.show.page import render
from tatamu.show.palette import SERIES
from tests.physics.findings import Curve, Figure, in_order
from tests.physics.report import CheckResult, Report
from tests.physics.terminal import cells

SYMBOLS = ("circle", "square", "diamond", "triangle-up", "x", "cross")
LONG = 16
"""Largest number of rows with which a table is not collapsed. A collapsed table shows only the rows that failed."""


def page(report: Report) -> str:
    """Return the page with the results of all checks as HTML."""
    return render(
        Path(__file__).with_name("page.html"),
        charts={result.check.name: _charts(result) for result in report.results},
        title=f"Validation of the simulator {report.simulator}",
        report=report,
        stated=len(report.rows) - report.judged,
        checks=[(result, *_verdict(result)) for result in report.results],
        cells=cells,
        long=LONG,
    )


def _verdict(result: CheckResult) -> tuple[str, str]:
    """Return the result of a check in a few words, and the name of its colour: pass, fail or stated."""
    passed = [row.passed for case in result.cases for row in case.rows if row.passed is not None]
    failed = passed.count(False)
    if failed:
        return f"{failed} of {len(passed)} fail", "fail"
    return (f"{len(passed)} pass", "pass") if passed else ("stated", "stated")


def _charts(result: CheckResult) -> list[Chart]:
    return [
        Chart(figure.title, _plot(result.curves(key), figure), kind="tall")
        for key, figure in result.check.figures.items()
        if result.curves(key)
    ]


def _plot(curves: list[Curve], figure: Figure) -> Plot:
    lines = [_trace(curve, figure, place, first) for curve, place, first in in_order(curves)]
    kind = "log" if figure.log else "linear"
    alike = {"scaleanchor": "x", "scaleratio": 1} if figure.equal else {}
    return traces(lines, xaxis=axis(figure.x, type=kind), yaxis=axis(figure.y, type=kind, **alike), showlegend=True)


def _trace(curve: Curve, figure: Figure, place: int, first: bool) -> dict[str, Any]:
    colour = f"@series-{place % SERIES}"
    style = (
        {"mode": "lines", "line": {"color": "@ink", "width": 1.6}}
        if curve.reference
        else {
            "mode": "lines+markers" if figure.joined else "markers",
            "line": {"color": colour, "width": 1},
            "marker": {"color": colour, "size": 6, "symbol": SYMBOLS[place % len(SYMBOLS)], "opacity": 0.8},
        }
    )
    return {
        "name": curve.name,
        "x": list(map(float, curve.x)),
        "y": list(map(float, curve.y)),
        "legendgroup": curve.name,
        "showlegend": first,
        **style,
    }
