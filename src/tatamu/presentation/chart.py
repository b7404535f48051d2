"""2-D charts as plain Plotly data.

A colour "@name" is the one that `palette` has under that name; scripts/charts.js fills it in, by day and by night.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np

Plot = dict[str, Any]
"""A Plotly figure as plain data: "data" and "layout"."""

FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif"
LEGEND = {"orientation": "h", "x": 0, "y": 1.02, "yanchor": "bottom", "font": {"color": "@ink"}}
"""The legend is above the plot; next to it, a phone would have no space for the plot."""
TICKS = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0)
"""Numbers on a logarithmic axis of less than a power of ten, times powers of ten."""
FEW_TICKS = (1.0, 2.0, 5.0)
"""Numbers on a longer logarithmic axis, times powers of ten."""


@dataclass(frozen=True)
class Chart:
    """A plot in its place on a page."""

    title: str
    """Plain text above it."""
    plot: Plot
    caption: str = ""
    """Plain text after the title."""
    kind: str = ""
    """A class of the style sheet that sets its height."""


def traces(data: Sequence[dict[str, Any]], **more: Any) -> Plot:
    """A plot of traces with the layout of `layout`; points that are no numbers are gaps."""
    return {"data": [_with_gaps(trace) for trace in data], "layout": layout(**more)}


def _with_gaps(trace: dict[str, Any]) -> dict[str, Any]:
    """A trace without the values that JSON does not have."""
    shown = {name: [_finite(value) for value in trace[name]] for name in trace if name in {"x", "y"}}
    return {**trace, **shown}


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not isfinite(value) else value


def axis(title: str, **more: Any) -> dict[str, Any]:
    """Return an axis with its title and unit."""
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


def log_axis(title: str, low: float, high: float) -> dict[str, Any]:
    """Return a logarithmic axis between two values, with plain numbers if it spans less than two powers of ten."""
    ticks: dict[str, Any] = {}
    if high < 100.0 * low:
        powers = 10.0 ** np.arange(np.floor(np.log10(low)), np.log10(high))
        values = np.outer(powers, TICKS if high < 10.0 * low else FEW_TICKS).ravel().tolist()
        ticks = {"tickvals": values, "ticktext": [f"{value:g}" for value in values]}
    return axis(title, type="log", range=np.log10([low, high]).tolist(), **ticks)


def layout(**more: Any) -> dict[str, Any]:
    """A transparent figure without a title, in the page's type."""
    return {
        "paper_bgcolor": "rgba(0,0,0,0)",
        "plot_bgcolor": "rgba(0,0,0,0)",
        "font": {"family": FONT, "size": 12.5, "color": "@muted"},
        "margin": {"l": 52, "r": 14, "t": 16, "b": 44},
        "hoverlabel": {"font": {"family": FONT}},
        "showlegend": False,
        "legend": LEGEND,
        "dragmode": False,
        "modebar": {"bgcolor": "rgba(0,0,0,0)", "color": "@muted", "activecolor": "@ink"},
        **more,
    }


def note(x: float, y: float, text: str, **more: Any) -> dict[str, Any]:
    """Return a text in a chart, at data coordinates or those of `xref` and `yref`."""
    font = {"size": 11.5, "color": "@muted"}
    return {"x": x, "y": y, "text": text, "showarrow": False, "font": font, **more}


def line(axis_name: str, at: float, *, dash: str = "dot", colour: str = "@muted", **more: Any) -> dict[str, Any]:
    """A line across the chart at a value of "x" or "y"."""
    other = "y" if axis_name == "x" else "x"
    span = {f"{axis_name}0": at, f"{axis_name}1": at, f"{other}0": 0, f"{other}1": 1, f"{other}ref": "paper"}
    return {"type": "line", **span, "line": {"color": colour, "width": 1, "dash": dash}, **more}


def band(low: float, high: float, colour: str) -> dict[str, Any]:
    """A pale band across the chart between two values of y."""
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
