"""Makes 2-D charts as plain Plotly data.

A colour "@name" stands for the colour of that name in `palette`. In the browser, scripts/charts.js replaces it by the
colour for light or dark mode.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np

Plot = dict[str, Any]
"""A Plotly figure as a dictionary with the keys "data" and "layout"."""

FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif"
LEGEND = {"orientation": "h", "x": 0, "y": 1.02, "yanchor": "bottom", "font": {"color": "@ink"}}
"""Layout of a chart's legend: above the plot, because beside it a phone has no space."""
FOREIGN_TAG = re.compile(r"<(?!/?(?:b|br|extra|i|sub|sup)>)")
"""Start of a tag that the charts of tatamu do not use, such as a link in a name from a file."""


@dataclass(frozen=True)
class Chart:
    """A plot on a page, with its title."""

    title: str
    """Title above the plot, as plain text."""
    plot: Plot
    caption: str = ""
    """Caption after the title, as plain text."""
    kind: str = ""
    """Class in the style sheet of the page that sets the height of the plot."""


def traces(data: Sequence[dict[str, Any]], **more: Any) -> Plot:
    """Return a plot of Plotly traces with the standard layout: transparent, without a title.

    Values that are not finite become gaps.
    """
    layout = {
        "paper_bgcolor": "rgba(0,0,0,0)",
        "plot_bgcolor": "rgba(0,0,0,0)",
        "font": {"family": FONT, "size": 12.5, "color": "@muted"},
        "margin": {"l": 52, "r": 14, "t": 16, "b": 44},
        "hoverlabel": {"font": {"family": FONT}},
        "showlegend": False,
        "legend": LEGEND,
        "dragmode": False,
        "modebar": {"bgcolor": "rgba(0,0,0,0)", "color": "@muted", "activecolor": "@ink"},
    }
    return {"data": [_with_gaps(trace) for trace in data], "layout": {**layout, **more}}


def _with_gaps(trace: dict[str, Any]) -> dict[str, Any]:
    """Return a trace with None for values that are not finite, which JSON cannot store."""

    def finite(value: Any) -> Any:
        return None if isinstance(value, float) and not isfinite(value) else value

    return {**trace, **{name: [finite(value) for value in trace[name]] for name in ("x", "y") if name in trace}}


def harmless(value: Any) -> Any:
    """Return a copy of a plot in which names from files cannot add links or styles, although Plotly reads HTML."""
    if isinstance(value, str):
        return FOREIGN_TAG.sub("&lt;", value)
    if isinstance(value, dict):
        return {name: harmless(each) for name, each in value.items()}
    return [harmless(each) for each in value] if isinstance(value, list | tuple) else value


def axis(title: str, **more: Any) -> dict[str, Any]:
    """Return an axis of a chart with a title, which includes the unit."""
    return {
        "title": {"text": title, "standoff": 8, "font": {"size": 12.5}},
        "zeroline": False,
        "gridcolor": "@line",
        "linecolor": "@line",
        "automargin": True,
        "ticks": "outside",
        "ticklen": 4,
        "tickcolor": "@line",
        **more,
    }


def rows(names: Iterable[str]) -> dict[str, Any]:
    """Return the layout of a chart of kind "rows", which has a row for each name, the first at the bottom.

    A phone shows the names above their rows. An x axis with a fixed range keeps them apart from the curves.
    """
    return {"height": 90 + 26 * len(set(names)), "yaxis": axis("", type="category", ticks="", showgrid=False)}


def log_axis(title: str, low: float, high: float) -> dict[str, Any]:
    """Return a logarithmic axis, with plain numbers as labels below two powers of ten."""
    ticks: dict[str, Any] = {}
    if high < 100.0 * low:
        powers = 10.0 ** np.arange(np.floor(np.log10(low)), np.log10(high))
        digits = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0) if high < 10.0 * low else (1.0, 2.0, 5.0)
        values = np.outer(powers, digits).ravel().tolist()
        ticks = {"tickvals": values, "ticktext": [f"{value:g}" for value in values]}
    return axis(title, type="log", range=np.log10([low, high]).tolist(), **ticks)


def dots(
    x: Iterable[Any],
    y: Iterable[Any],
    hover: str,
    *,
    name: str | None = None,
    text: Iterable[str] | None = None,
    **marker: Any,
) -> dict[str, Any]:
    """Return dots as a trace. `hover` may contain %{x}, %{y} and %{text}; the other arguments are of the marker."""
    named = {} if name is None else {"name": name}
    said = {} if text is None else {"text": list(text)}
    shown = {"mode": "markers", "marker": marker, "hovertemplate": f"{hover}<extra></extra>"}
    return {**named, "x": list(x), "y": list(y), **said, **shown}


def note(x: float, y: float, text: str, **more: Any) -> dict[str, Any]:
    """Return a text in a chart, at a position in the units of the axes unless `xref` and `yref` are given."""
    font = {"size": 11.5, "color": "@muted"}
    return {"x": x, "y": y, "text": text, "showarrow": False, "font": font, **more}


def line(axis_name: str, at: float, *, dash: str = "dot", colour: str = "@muted", **more: Any) -> dict[str, Any]:
    """Return a line across the chart at a given value on one of its axes, "x" or "y"."""
    other = "y" if axis_name == "x" else "x"
    span = {f"{axis_name}0": at, f"{axis_name}1": at, f"{other}0": 0, f"{other}1": 1, f"{other}ref": "paper"}
    return {"type": "line", **span, "line": {"color": colour, "width": 1, "dash": dash}, **more}


def band(low: float, high: float, colour: str) -> dict[str, Any]:
    """Return a pale strip across the chart, between two values on the y axis."""
    return {
        "type": "rect",
        "y0": low,
        "y1": high,
        "x0": 0,
        "x1": 1,
        "xref": "paper",
        "fillcolor": colour,
        "opacity": 0.15,
        "line": {"width": 0},
        "layer": "below",
    }
