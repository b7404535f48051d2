"""A calibration as one page that opens offline: what came out, the three fits, what to read again."""

from __future__ import annotations

from html import escape

import numpy as np
import plotly.graph_objects as go
from plotly.offline import get_plotlyjs

from tatamu import __version__
from tatamu.calibration import drawing
from tatamu.calibration.advice import NAMES, advice_on
from tatamu.calibration.fit import Fit
from tatamu.calibration.friction import SLIDING
from tatamu.calibration.parameters import KNOWN, PARAMETERS, PLACE, SYMBOLS, UNITS
from tatamu.calibration.readings import Reading
from tatamu.calibration.result import Calibration, rounded
from tatamu.calibration.test import CalibrationTest
from tatamu.validation.page import FIT, GRID, INK, STYLE, chart_html

ROOM = 1.6
"""Beside the points of a chart, as a factor: a logarithmic axis then always has a number on it."""
TICKS = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0)
"""Numbers on it, times powers of ten."""
OWN_STYLE = """
.fit { display: grid; grid-template-columns: minmax(280px, 1fr) minmax(380px, 1.3fr); gap: 18px; align-items: center }
@media (max-width: 760px) { .fit { grid-template-columns: 1fr } }
.fit svg { max-width: 100%; height: auto }
.fit > div { min-width: 0 }
.advice li { margin: 5px 0 }
.bar { display: inline-block; height: 9px; border-radius: 3px; background: #3f66b0; vertical-align: middle }
"""


def page(calibration: Calibration) -> str:
    """The whole page as HTML."""
    title = f"{calibration.setup.garment.name}, calibrated for {calibration.simulator}"
    fits = "".join(_fit(calibration, fit) for fit in calibration.fits)
    advice = "".join(f"<li>{escape(text)}</li>" for text in advice_on(calibration))
    lead = (
        f"{calibration.simulations} simulations, {calibration.passes} passes · tatamu {__version__} · readings at rest "
        f"to {1e3 * calibration.unsettled:.2g} mm"
    )
    return (
        f"<!doctype html><html lang='en'><head><meta charset='utf-8'><title>{escape(title)}</title>"
        f"<style>{STYLE}{OWN_STYLE}</style><script>{get_plotlyjs()}</script></head><body><main>"
        f"<h1>{escape(title)}</h1><p class='lead'>{lead}</p>"
        f"<section><h2>What came out</h2>{_parameters(calibration)}</section>"
        f"<section class='advice'><h2>What to do next</h2><ul>{advice}</ul></section>{fits}"
        f"<section><h2>Where the uncertainty comes from</h2>{_budget(calibration)}</section>"
        f"</main><script>{FIT}</script></body></html>\n"
    )


def shown(calibration: Calibration, parameter: str) -> tuple[str, str]:
    """A parameter's value and its uncertainty as text, with the unit of the first."""
    factor, unit = KNOWN[parameter].shown_factor, KNOWN[parameter].shown_unit or UNITS[parameter]

    def words(value: float) -> str:
        return f"{factor * value:.4g} {unit if unit != '-' else ''}".strip()

    text = words(getattr(calibration.material, parameter))
    fit = calibration.bounding(parameter)
    if fit is not None:
        least = text if fit.alone is None else words(fit.alone)
        return f"{fit.bound} {least}", "the reading cannot tell" + (f"; {text} is taken" if least != text else "")
    if parameter in calibration.assumed:
        return text, "not measured"
    relative = calibration.relative(parameter)
    return text, f"± {rounded(factor * calibration.uncertainty(parameter), 2):g} ({100 * relative:.1f} %)"


def _parameters(calibration: Calibration) -> str:
    lines = "".join(
        f"<tr><td>{KNOWN[name].words}, {SYMBOLS[name]}</td><td class='n'>{escape(value)}</td>"
        f"<td>{escape(spread)}</td></tr>"
        for name in PARAMETERS
        for value, spread in [shown(calibration, name)]
    )
    note = "Standard uncertainty, from the errors of the readings; the correlations are in the file."
    return (
        f"<table><thead><tr><th>parameter</th><th class='n'>value</th><th>uncertainty</th></tr></thead>"
        f"<tbody>{lines}</tbody></table><p class='reference'>{note}</p>"
    )


def _fit(calibration: Calibration, fit: Fit) -> str:
    test = calibration.setup.tests[fit.test]
    chart = _speed_chart(fit, test) if test.samples == "speed" else _chart(calibration, fit, test)
    plot = chart_html(chart, f"fit-{fit.test}")
    value, spread = shown(calibration, fit.parameter)
    return (
        f"<section><h2>{test.title}</h2><p class='reference'>{escape(_sentence(fit, test))} "
        f"<b>{SYMBOLS[fit.parameter]} {'is' if fit.bound else '='} {escape(value)}</b>, {escape(spread)}.</p>"
        f"<div class='fit'><div>{test.drawing(calibration.shapes[fit.test])}</div><div>{plot}</div></div></section>"
    )


def _sentence(fit: Fit, test: CalibrationTest) -> str:
    beside = fit.alone if fit.parameter == "bending_rigidity" else None
    alone = f" Alone it says {f'{fit.bound} ' if fit.bound else ''}{1e6 * beside:.4g} µN m." if beside else ""
    return test.sentence(fit) + alone


def _chart(calibration: Calibration, fit: Fit, test: CalibrationTest) -> go.Figure:
    """Simulated readings over the parameter, and the measured one as a band."""
    factor = KNOWN[fit.parameter].shown_factor
    x, y = factor * np.array([s[0] for s in fit.samples]), 1e3 * np.array([s[1] for s in fit.samples])
    chart = go.Figure(layout=_layout(KNOWN[fit.parameter].label, f"{test.read} [mm]", "log"))
    low, high = 1e3 * (fit.measured - fit.uncertainty), 1e3 * (fit.measured + fit.uncertainty)
    chart.add_hrect(low, high, fillcolor=drawing.READ, opacity=0.15, line_width=0)
    chart.add_hline(1e3 * fit.measured, line={"color": drawing.READ, "width": 1.4}, annotation_text="measured")
    chart.add_trace(
        go.Scatter(x=x, y=y, mode="lines+markers", line={"color": drawing.CLOTH, "width": 1.3}, name="simulated")
    )
    found = factor * getattr(calibration.material, fit.parameter)
    lowest, highest = min(low, y.min()), max(high, y.max())
    chart.update_yaxes(range=[lowest - 0.08 * (highest - lowest), highest + 0.08 * (highest - lowest)])
    left, right = min(x.min(), found) / ROOM, max(x.max(), found) * ROOM
    chart.update_xaxes(range=np.log10([left, right]))
    if right < 10.0 * left:  # too narrow for whole powers of ten
        values = np.outer(10.0 ** np.arange(np.floor(np.log10(left)), np.log10(right)), TICKS).ravel()
        chart.update_xaxes(tickvals=values, ticktext=[f"{value:g}" for value in values])
    chart.add_vline(found, line={"color": INK, "width": 1, "dash": "dot"})
    return chart


def _speed_chart(fit: Fit, test: CalibrationTest) -> go.Figure:
    """Speed over the coefficient: zero where it sticks."""
    chart = go.Figure(layout=_layout(KNOWN[fit.parameter].label, "speed at the end [mm/s]", "linear"))
    for slides, name, symbol in ((True, "slides", "circle"), (False, "sticks", "square")):
        points = [sample for sample in fit.samples if (sample[1] > SLIDING) == slides]
        chart.add_trace(
            go.Scatter(
                x=[point[0] for point in points],
                y=[1e3 * point[1] for point in points],
                mode="markers",
                marker={"symbol": symbol, "size": 8, "color": drawing.CLOTH if slides else drawing.READ},
                name=name,
            )
        )
    chart.update_layout(showlegend=True)
    chart.add_vline(test.textbook, line={"color": INK, "dash": "dot"}, annotation_text="tan θ")
    return chart


def _layout(x: str, y: str, kind: str) -> go.Layout:
    axis = {"gridcolor": GRID, "zerolinecolor": GRID, "linecolor": "#9aa5b1", "ticks": "outside"}
    return go.Layout(
        xaxis={"title": x, "type": kind, **axis},
        yaxis={"title": y, **axis},
        font={"family": "system-ui, sans-serif", "color": INK, "size": 12},
        margin={"l": 60, "r": 16, "t": 16, "b": 46},
        height=300,
        plot_bgcolor="white",
        paper_bgcolor="white",
        showlegend=False,
        legend={"orientation": "h", "y": 1.1},
    )


def _budget(calibration: Calibration) -> str:
    """What part of each parameter's variance each reading brings, as bars."""
    known = calibration.known
    if not known:
        return "<p>Nothing is known but bounds.</p>"
    rows = [PLACE[name] for name in known]
    variance = np.diag(calibration.covariance)[rows]
    head = "<th>reading</th><th class='n'>value</th><th class='n'>±</th>" + "".join(
        f"<th>{SYMBOLS[name]}</th>" for name in known
    )
    lines = []
    for name, contribution in calibration.contributions.items():
        shares = contribution[rows] ** 2 / np.where(variance > 0, variance, 1.0)
        cells = "".join(
            f"<td><span class='bar' style='width:{70 * share:.0f}px'></span> {100 * share:.0f} %</td>"
            for share in shares
        )
        lines.append(f"<tr><td>{escape(NAMES[name])}</td>{_read(name, calibration.readings.get(name))}{cells}</tr>")
    return f"<table><thead><tr>{head}</tr></thead><tbody>{''.join(lines)}</tbody></table>"


def _read(name: str, reading: Reading | None) -> str:
    """The cells of a reading and its uncertainty; of what was not read, empty ones."""
    if reading is None:
        return "<td></td><td></td>"
    unit = "g" if name == "mass" else "mm"
    return (
        f"<td class='n'>{1e3 * reading.value:.4g} {unit}</td><td class='n'>{1e3 * reading.uncertainty:.2g} {unit}</td>"
    )
