"""What all 2-D figures share.

A colour "@name" is the page's custom property --name; charts.js fills it in.
"""

from __future__ import annotations

from typing import Any

Figure = dict[str, Any]
"""A Plotly figure as plain data: "data" and "layout"."""

FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif"


def axis(title: str, **more: Any) -> dict[str, Any]:
    """A quiet axis with its title and unit."""
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


def layout(**more: Any) -> dict[str, Any]:
    """A transparent figure without a title, in the page's type."""
    return {
        "paper_bgcolor": "rgba(0,0,0,0)",
        "plot_bgcolor": "rgba(0,0,0,0)",
        "font": {"family": FONT, "size": 12.5, "color": "@muted"},
        "margin": {"l": 52, "r": 14, "t": 16, "b": 44},
        "hoverlabel": {"font": {"family": FONT}},
        "showlegend": False,
        "dragmode": False,
        "modebar": {"bgcolor": "rgba(0,0,0,0)", "color": "@muted", "activecolor": "@ink"},
        **more,
    }


def note(x: float, y: float, text: str, **more: Any) -> dict[str, Any]:
    """A word in a figure, at data coordinates unless told otherwise."""
    font = {"size": 11.5, "color": "@muted"}
    return {"x": x, "y": y, "text": text, "showarrow": False, "font": font, **more}


def line(axis_name: str, at: float, *, dash: str = "dot", **more: Any) -> dict[str, Any]:
    """A line across the figure at a value of "x" or "y"."""
    other = "y" if axis_name == "x" else "x"
    span = {f"{axis_name}0": at, f"{axis_name}1": at, f"{other}0": 0, f"{other}1": 1, f"{other}ref": "paper"}
    return {"type": "line", **span, "line": {"color": "@muted", "width": 1, "dash": dash}, **more}
