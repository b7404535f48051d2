"""Draws the hands' paths in the vertical plane of the fold, relative to the grasp.

The chart shows the learned path and, for comparison, fixed trajectories that are not learned.
"""

from __future__ import annotations

import html
from itertools import cycle
from typing import Any

import numpy as np

from tatamu.show.chart import LEGEND, Plot, axis, traces
from tatamu.study.result import Result


def plot(fold: Result) -> Plot:
    """Return a chart of the hands' paths relative to the grasp, in millimetres, at the same scale on both axes."""
    dashes = cycle(("dash", "dot", "dashdot", "longdash", "longdashdot"))
    lines = [
        _line(_in_plane(baseline.path), baseline.label, color="@muted", width=1.8, dash=dash)
        for dash, baseline in zip(dashes, fold.record.baselines, strict=False)
    ]
    for name, colour, control, path in _learned(fold):
        lines += [_handles(control, colour), _line(path, name, color=colour, width=3)]
    return traces(
        lines,
        xaxis=axis("from the grasp towards its release [mm]", constrain="domain"),
        yaxis=axis("height above the grasp [mm]", scaleanchor="x", scaleratio=1, rangemode="tozero"),
        showlegend=True,
        legend={**LEGEND, "traceorder": "reversed"},
        hovermode="closest",
    )


def _learned(fold: Result) -> list[tuple[str, str, np.ndarray, np.ndarray]]:
    """Return name, colour, control points (4, 2) and path (f, 2) of each hand in the plane of the fold.

    The path has f points. If both hands move equally, to within 10 mm, the result has a single entry.
    """
    arms = fold.arms
    paths = [_in_plane(fold.hand(arm) - np.array(arm.grasp.position)) for arm in arms]
    controls = [_in_plane(arm.control_points - arm.control_points[0]) for arm in arms]
    if len(arms) == 2 and np.abs(paths[1] - paths[0]).max() < 0.01:
        return [("learned, both hands", "@accent", controls[0], paths[0])]
    names = [f"learned, {arm.name} hand" for arm in arms]
    return list(zip(names, ("@left", "@right"), controls, paths, strict=False))


def _in_plane(path: np.ndarray) -> np.ndarray:
    """Project a hand's path, shape (k, 3), onto the vertical plane through both ends of the path, shape (k, 2).

    The path has k points, relative to the grasp. In the result, the first column is the horizontal distance from the
    grasp, towards the end of the path. The second column is the height.
    """
    along = path[-1, :2] / max(float(np.linalg.norm(path[-1, :2])), 1e-9)
    return np.column_stack([path[:, :2] @ along, path[:, 2]])


def _line(path: np.ndarray, name: str, **style: Any) -> dict[str, Any]:
    label = html.escape(name)
    hover = "along %{x:.0f} mm, up %{y:.0f} mm<extra>" + label + "</extra>"
    return {**_points(path), "name": label, "mode": "lines", "line": style, "hovertemplate": hover}


def _handles(control: np.ndarray, colour: str) -> dict[str, Any]:
    """Return the line through the four control points P0 to P3 of a path, as a trace of the chart."""
    return {
        **_points(control),
        "mode": "lines+markers",
        "line": {"color": colour, "width": 1},
        "marker": {"color": colour, "size": 7, "symbol": "circle-open"},
        "opacity": 0.55,
        "showlegend": False,
        "text": [f"P{number}" for number in range(len(control))],
        "hovertemplate": "%{text}: along %{x:.0f} mm, up %{y:.0f} mm<extra>control point</extra>",
    }


def _points(path: np.ndarray) -> dict[str, Any]:
    x, y = (1e3 * path.T).round(2).tolist()
    return {"x": x, "y": y}
