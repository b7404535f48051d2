"""The report as one page that opens offline: verdicts, plots of got against reference, all rows."""

from __future__ import annotations

from html import escape

import numpy as np
import plotly.graph_objects as go
from plotly.offline import get_plotlyjs

from tatamu import __version__
from tatamu.validation.findings import Curve, Figure, Row
from tatamu.validation.report import CheckResult, Report
from tatamu.validation.terminal import cells

INK, GRID = "#1f2933", "#e4e7eb"
COLOURS = ("#d9480f", "#1971c2", "#2f9e44", "#ae3ec9", "#f08c00", "#0c8599", "#c2255c", "#5c940d")
SYMBOLS = ("circle", "square", "diamond", "triangle-up", "x", "cross")
LONG = 16
"""Tables with more rows than this are folded away behind their failures."""

FIT = "addEventListener('load', () => document.querySelectorAll('.js-plotly-plot').forEach(Plotly.Plots.resize))"
"""A plot is drawn before its neighbour takes half of the row: fit all once they are there."""

STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #1f2933; background: #f5f7fa; margin: 0 }
main { max-width: 1080px; margin: 0 auto; padding: 32px 20px 80px }
h1 { font-size: 26px; margin: 0 } h2 { font-size: 19px; margin: 0 }
.lead { color: #52606d; margin: 4px 0 20px }
section { background: #fff; border: 1px solid #e4e7eb; border-radius: 10px;
  padding: 18px 22px; margin: 18px 0 }
.head { display: flex; gap: 12px; align-items: baseline; justify-content: space-between }
.reference { color: #52606d; margin: 2px 0 10px }
.badge { font-size: 13px; font-weight: 600; border-radius: 20px; padding: 2px 11px; white-space: nowrap }
.pass { color: #2b8a3e; background: #ebfbee } .fail { color: #c92a2a; background: #fff0f0 }
.stated { color: #52606d; background: #f1f3f5 }
.overview { display: grid; grid-template-columns: repeat(auto-fill, minmax(240px, 1fr)); gap: 8px }
.overview a { display: flex; align-items: center; justify-content: space-between; gap: 8px;
  text-decoration: none; color: inherit;
  background: #fff; border: 1px solid #e4e7eb; border-radius: 8px; padding: 7px 12px }
.overview a:hover { border-color: #9aa5b1 }
.plots > div { min-width: 0; overflow: hidden }
.plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(440px, 1fr)); gap: 14px }
table { border-collapse: collapse; width: 100%; font-size: 13.5px; margin-top: 10px }
th { text-align: left; font-weight: 600; color: #52606d; border-bottom: 2px solid #e4e7eb; padding: 4px 8px }
td { border-bottom: 1px solid #eef1f4; padding: 4px 8px; vertical-align: top }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap }
td small { color: #7b8794; display: block } tr.fail-row td { background: #fff5f5 }
summary { cursor: pointer; color: #52606d; margin-top: 10px }
"""


def page(report: Report) -> str:
    """The whole page as HTML."""
    verdict = "all pass" if report.failures == 0 else f"{report.failures} of {report.judged} judged quantities fail"
    stated = len(report.rows) - report.judged
    lead = f"{report.judged} judged, {stated} stated without a limit · tatamu {__version__}"
    body = "".join(_section(result) for result in report.results)
    return (
        "<!doctype html><html lang='en'><head><meta charset='utf-8'>"
        f"<title>Validation of {escape(report.simulator)}</title><style>{STYLE}</style>"
        f"<script>{get_plotlyjs()}</script></head><body><main>"
        f"<div class='head'><h1>Validation of the simulator {escape(report.simulator)}</h1>"
        f"<span class='badge {'fail' if report.failures else 'pass'}'>{verdict}</span></div>"
        f"<p class='lead'>{lead}</p><nav class='overview'>{''.join(_link(r) for r in report.results)}</nav>"
        f"{body}</main><script>{FIT}</script></body></html>\n"
    )


def _rows(result: CheckResult) -> list[tuple[str, Row]]:
    return [(case.label, row) for case in result.cases for row in case.rows]


def _badge(result: CheckResult) -> str:
    verdicts = [row.passed for _, row in _rows(result)]
    failed, judged = sum(v is False for v in verdicts), sum(v is not None for v in verdicts)
    if failed:
        return f"<span class='badge fail'>{failed} of {judged} fail</span>"
    return f"<span class='badge pass'>{judged} pass</span>" if judged else "<span class='badge stated'>stated</span>"


def _link(result: CheckResult) -> str:
    return f"<a href='#{result.check.name}'><span>{escape(result.check.title)}</span>{_badge(result)}</a>"


def _section(result: CheckResult) -> str:
    check, rows = result.check, _rows(result)
    seconds = sum(case.seconds for case in result.cases)
    plots = "".join(_plot(result, key, figure) for key, figure in check.figures.items())
    failed = [(label, row) for label, row in rows if row.passed is False]
    table = _table(rows)
    if len(rows) > LONG:
        table = (
            _table(failed) if failed else ""
        ) + f"<details><summary>All {len(rows)} rows</summary>{table}</details>"
    return (
        f"<section id='{check.name}'><div class='head'><h2>{escape(check.title)}</h2>{_badge(result)}</div>"
        f"<p class='reference'>Reference: {escape(check.reference)} · <code>--only {check.name}</code>"
        f" · {seconds:.1f} s</p>"
        f"<div class='plots'>{plots}</div>{table}</section>"
    )


def _table(rows: list[tuple[str, Row]]) -> str:
    head = "<th>case</th><th>quantity</th>" + "".join(
        f"<th class='n'>{name}</th>" for name in ("reference", "got", "error", "limit")
    )
    lines, before = [], ""
    for label, row in rows:
        quantity, *numbers, unit = cells(row)
        note = f"<small>{escape(row.note)}</small>" if row.note else ""
        verdict = {True: "pass", False: "fail", None: "stated"}[row.passed]
        numbers[2:] = [f"{text} {unit}" if text != "–" and unit != "-" else text for text in numbers[2:]]
        columns = "".join(f"<td class='n'>{escape(text)}</td>" for text in numbers)
        lines.append(
            f"<tr class='{verdict}-row'><td>{'' if label == before else escape(label)}</td>"
            f"<td>{escape(quantity)}{note}</td>"
            f"{columns}<td><span class='badge {verdict}'>{verdict}</span></td></tr>"
        )
        before = label
    return f"<table><thead><tr>{head}<th></th></tr></thead><tbody>{''.join(lines)}</tbody></table>"


def _plot(result: CheckResult, key: str, figure: Figure) -> str:
    curves = result.curves(key)
    if not curves:
        return ""
    chart = go.Figure(layout=_layout(figure))
    names = list(dict.fromkeys(curve.name for curve in curves if not curve.reference))
    seen: set[str] = set()
    for curve in sorted(curves, key=lambda curve: not curve.reference):
        place = names.index(curve.name) if not curve.reference else 0
        chart.add_trace(_trace(curve, figure, place, curve.name not in seen))
        seen.add(curve.name)
    return chart_html(chart, f"{result.check.name}-{key}")


def chart_html(chart: go.Figure, name: str) -> str:
    """A chart as a part of a page. Its name, the only such one there, keeps plotly from making up a random one."""
    config = {"displayModeBar": False, "responsive": True}
    return chart.to_html(full_html=False, include_plotlyjs=False, config=config, div_id=name.replace(" ", "-"))


def _trace(curve: Curve, figure: Figure, place: int, first: bool) -> go.Scatter:
    colour = COLOURS[place % len(COLOURS)]
    style = (
        {"mode": "lines", "line": {"color": INK, "width": 1.6}}
        if curve.reference
        else {
            "mode": "lines+markers" if figure.joined else "markers",
            "line": {"color": colour, "width": 1},
            "marker": {"color": colour, "size": 6, "symbol": SYMBOLS[place % len(SYMBOLS)], "opacity": 0.8},
        }
    )
    return go.Scatter(
        x=np.asarray(curve.x),
        y=np.asarray(curve.y),
        name=curve.name,
        legendgroup=curve.name,
        showlegend=first,
        **style,
    )


def _layout(figure: Figure) -> go.Layout:
    kind = "log" if figure.log else "linear"
    axis = {
        "gridcolor": GRID,
        "zerolinecolor": GRID,
        "linecolor": "#9aa5b1",
        "type": kind,
        "ticks": "outside",
    }
    tall = {"scaleanchor": "x", "scaleratio": 1} if figure.equal else {}
    return go.Layout(
        title={"text": figure.title, "font": {"size": 15}, "x": 0.02},
        xaxis={"title": figure.x, **axis},
        yaxis={"title": figure.y, **axis, **tall},
        font={"family": "system-ui, sans-serif", "color": INK, "size": 12},
        margin={"l": 60, "r": 10, "t": 42, "b": 46},
        height=400,
        plot_bgcolor="white",
        paper_bgcolor="white",
        legend={"font": {"size": 11}, "orientation": "h", "y": -0.2},
        autosize=True,
    )
