"""The page of a calibration."""

from __future__ import annotations

import numpy as np
from markupsafe import Markup

from tatamu.calibration.advice import NAMES, advice_on
from tatamu.calibration.estimate import Fit
from tatamu.calibration.friction import SLIDING, Slope
from tatamu.calibration.parameters import KNOWN, PLACE, SYMBOLS
from tatamu.calibration.readings import Reading
from tatamu.calibration.result import Calibration, rounded
from tatamu.calibration.test import RestTest
from tatamu.show import quantity
from tatamu.show.chart import Chart, Plot, axis, band, dots, line, log_axis, note, traces
from tatamu.show.page import render

ROOM = 1.6
"""Factor by which a logarithmic axis extends beyond the points, so that at least one value is labelled."""


def page(calibration: Calibration) -> str:
    """Return the page of a calibration as HTML."""
    charts = {fit.test: [Chart("", _chart(calibration, fit))] for fit in calibration.fits}
    return render(
        "calibration/page.html",
        charts=charts,
        title=f"{calibration.setup.garment.name}, calibrated for {calibration.simulator}",
        calibration=calibration,
        parameters=[
            (f"{KNOWN[name].words}, {SYMBOLS[name]}", *shown(calibration, name)) for name in calibration.listed
        ],
        advice=advice_on(calibration),
        fits=[_shown_fit(calibration, fit) for fit in calibration.fits],
        symbols=[SYMBOLS[name] for name in calibration.known],
        budget=_budget(calibration),
    )


def _shown_fit(calibration: Calibration, fit: Fit) -> dict[str, str]:
    """Return the result of one test, as the page shows it next to its chart."""
    test = calibration.setup.tests[fit.test]
    value, spread = shown(calibration, fit.parameter)
    shape = calibration.shapes[fit.test]
    picture = ""
    if shape is not None:
        picture = test.drawing(shape)
    elif not isinstance(test, RestTest):  # its drawing needs no shape
        picture = test.drawing(np.empty((0, 3)))
    beside = fit.alone if fit.parameter == "bending_rigidity" else None
    alone = f" Alone it says {f'{fit.bound} ' if fit.bound else ''}{1e6 * beside:.4g} µN m." if beside else ""
    return {
        "name": fit.test,
        "title": test.texts["title"],
        "sentence": test.sentence(fit) + alone,
        "symbol": SYMBOLS[fit.parameter],
        "relation": "is" if fit.bound else "=",
        "value": value,
        "spread": spread,
        "picture": Markup(picture),
    }


def shown(calibration: Calibration, parameter: str) -> tuple[str, str]:
    """Return two texts: a parameter's value with its unit, and the uncertainty of this value."""
    unit = KNOWN[parameter].unit
    text = quantity.shown(getattr(calibration.material, parameter), unit)
    fit = calibration.bounding(parameter)
    if fit is not None:
        least = text if fit.alone is None else quantity.shown(fit.alone, unit)
        return f"{fit.bound} {least}", "the reading cannot tell" + (f"; {text} is taken" if least != text else "")
    if parameter in calibration.assumed:
        return text, "not measured"
    relative = calibration.relative(parameter)
    return (
        text,
        f"± {rounded(quantity.factor(unit) * calibration.uncertainty(parameter), 2):g} ({100 * relative:.1f} %)",
    )


def _chart(calibration: Calibration, fit: Fit) -> Plot:
    """Return a chart of the simulated readings over the parameter. The measured reading is a horizontal band."""
    test = calibration.setup.tests[fit.test]
    if isinstance(test, Slope):
        return _speed_chart(fit, test.textbook)
    factor = quantity.factor(KNOWN[fit.parameter].unit)
    label = KNOWN[fit.parameter].label
    x = factor * np.array([sample[0] for sample in fit.samples])
    read, unit = test.texts["read"], quantity.usual(fit.unit)
    scale = quantity.factor(unit)
    y = scale * np.array([sample[1] for sample in fit.samples])
    low = scale * (fit.measured - fit.uncertainty)
    high = scale * (fit.measured + fit.uncertainty)
    found = factor * getattr(calibration.material, fit.parameter)
    lowest = min(low, y.min())
    highest = max(high, y.max())
    room = 0.08 * (highest - lowest)
    return traces(
        [
            {
                "name": "simulated",
                "x": x.tolist(),
                "y": y.tolist(),
                "mode": "lines+markers",
                "line": {"color": "@plot", "width": 1.3},
                "hovertemplate": f"{label} %{{x:.4g}}<br>%{{y:.2f}} {unit}<extra></extra>",
            }
        ],
        xaxis=log_axis(label, min(x.min(), found) / ROOM, max(x.max(), found) * ROOM),
        yaxis=axis(f"{read} [{unit}]" if unit else read, range=[lowest - room, highest + room]),
        shapes=[
            band(low, high, "@reading"),
            line("y", scale * fit.measured, dash="solid", colour="@reading"),
            line("x", found, colour="@ink"),
        ],
        annotations=[note(1, scale * fit.measured, "measured", xref="paper", xanchor="right", yanchor="bottom")],
    )


def _speed_chart(fit: Fit, textbook: float) -> Plot:
    """Return a chart of the simulated sheet's speed over the coefficient of friction. The speed is zero if it stays."""
    clouds = []
    for slides, name, symbol in ((True, "slides", "circle"), (False, "sticks", "square")):
        points = [sample for sample in fit.samples if (sample[1] > SLIDING) == slides]
        hover = f"μ %{{x:.4g}}: {name}, %{{y:.2f}} mm/s"
        x, y = [float(point[0]) for point in points], [1e3 * float(point[1]) for point in points]
        clouds.append(dots(x, y, hover, name=name, symbol=symbol, size=8, color="@plot" if slides else "@reading"))
    return traces(
        clouds,
        xaxis=axis(KNOWN[fit.parameter].label),
        yaxis=axis("speed at the end [mm/s]"),
        showlegend=True,
        shapes=[line("x", textbook, colour="@ink")],
        annotations=[note(textbook, 1, "tan θ", yref="paper", xanchor="left", yanchor="top", xshift=4)],
    )


def _budget(calibration: Calibration) -> list[tuple[str, str, str, list[float]]]:
    """Return each reading, its value, its uncertainty, and its fraction of each known parameter's variance."""
    known = [PLACE[name] for name in calibration.known]
    if not known:
        return []
    variance = np.diag(calibration.covariance)[known]
    rows = []
    for name, contribution in calibration.contributions.items():
        shares = contribution[known] ** 2 / np.where(variance > 0, variance, 1.0)
        rows.append((NAMES[name], *_read(calibration.readings.get(name)), shares.tolist()))
    return rows


def _read(reading: Reading | None) -> tuple[str, str]:
    """Return two texts: a reading, and its uncertainty. Both are empty if there is no reading."""
    if reading is None:
        return "", ""
    unit = quantity.usual(reading.unit)
    return quantity.shown(reading.value, unit), quantity.shown(reading.uncertainty, unit, ".2g")
