"""The hands' paths in the x-z plane, from the grasp on: the learned one beside fixed ones."""

from __future__ import annotations

import html
from typing import Any

import numpy as np

from tatamu.folding.path import bezier
from tatamu.report.chart import Figure, axis, layout
from tatamu.report.fold import LearnedFold
from tatamu.report.records import Baseline

DASHES = ("dash", "dot", "dashdot", "longdash", "longdashdot")
ALIKE = 0.01
"""Paths nearer to one another than this [m] are drawn once."""


def curve(control: np.ndarray, count: int = 81) -> np.ndarray:
    """Places on the Bezier curve of control points (k, 3), Eq. 1; shape (count, 3)."""
    return bezier(control, np.linspace(0.0, 1.0, count))


def figure(fold: LearnedFold) -> Figure:
    """The paths relative to the grasp, in millimetres, both axes alike."""
    traces = [
        trace
        for number, baseline in enumerate(fold.result.baselines)
        for trace in _fixed(baseline, fold, DASHES[number % len(DASHES)])
    ]
    for name, colour, control, way in _learned(fold):
        traces += [_handles(control, colour), _line(way, name, color=colour, width=3)]
    return {
        "data": traces,
        "layout": layout(
            xaxis=axis("along the fold from the grasp, x [mm]", constrain="domain"),
            yaxis=axis("height above the grasp, z [mm]", scaleanchor="x", scaleratio=1, rangemode="tozero"),
            showlegend=True,
            legend={
                "orientation": "h",
                "y": 1.02,
                "yanchor": "bottom",
                "x": 0,
                "traceorder": "reversed",
                "font": {"color": "@ink"},
            },
            hovermode="closest",
        ),
    }


def _learned(fold: LearnedFold) -> list[tuple[str, str, np.ndarray, np.ndarray]]:
    """Name, colour, control points (4, 3) and path (f, 3) from the grasp; once for hands that move alike."""
    arms = fold.manipulation.arms
    ways = [fold.hand(arm) - np.array(arm.grasp.position) for arm in arms]
    controls = [arm.control_points - arm.control_points[0] for arm in arms]
    if len(arms) == 2 and np.abs((ways[1] - ways[0])[:, [0, 2]]).max() < ALIKE:
        return [("learned, both hands", "@accent", controls[0], ways[0])]
    names = [f"learned, {arm.name} hand" for arm in arms]
    return list(zip(names, ("@left", "@right"), controls, ways, strict=False))


def _fixed(baseline: Baseline, fold: LearnedFold, dash: str) -> list[dict[str, Any]]:
    if baseline.path is not None:
        ways = [np.array(baseline.path)]
    else:
        ways = [curve(c - c[0]) for c in baseline.control_points or _from_parameters(baseline, fold)]
    return [_line(way, baseline.label, color="@muted", width=1.8, dash=dash) for way in ways[:1]]


def _from_parameters(baseline: Baseline, fold: LearnedFold) -> list[np.ndarray]:
    """P0 to P3 relative to the grasp, where the file gives x1, z1, x2, z2 and the way to the release."""
    given, way = baseline.parameters or {}, fold.result.task.translation
    if way is None or not {"x1", "z1", "x2", "z2"} <= given.keys():
        return []
    inner = [[given["x1"], 0.0, given["z1"]], [given["x2"], 0.0, given["z2"]]]
    return [np.array([[0.0, 0.0, 0.0], *inner, way])]


def _line(way: np.ndarray, name: str, **style: Any) -> dict[str, Any]:
    label = html.escape(name)
    return {
        "x": (1e3 * way[:, 0]).round(2).tolist(),
        "y": (1e3 * way[:, 2]).round(2).tolist(),
        "name": label,
        "mode": "lines",
        "line": style,
        "hovertemplate": "x %{x:.0f} mm, z %{y:.0f} mm<extra>" + label + "</extra>",
    }


def _handles(control: np.ndarray, colour: str) -> dict[str, Any]:
    """The control polygon P0 P1 P2 P3."""
    return {
        "x": (1e3 * control[:, 0]).round(2).tolist(),
        "y": (1e3 * control[:, 2]).round(2).tolist(),
        "mode": "lines+markers",
        "line": {"color": colour, "width": 1},
        "marker": {"color": colour, "size": 7, "symbol": "circle-open"},
        "opacity": 0.55,
        "showlegend": False,
        "text": [f"P{number}" for number in range(len(control))],
        "hovertemplate": "%{text}: x %{x:.0f} mm, z %{y:.0f} mm<extra>control point</extra>",
    }
