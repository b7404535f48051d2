"""Draws a map of errors on the flat cloth, which shows the parts of the garment that miss their target.

The error e_i is the distance between vertex i of the mesh and its target.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tatamu.report.topview import Extent, extent
from tatamu.show.chart import Chart, Plot, axis, traces
from tatamu.show.palette import SCALE
from tatamu.show.raster import rasterise
from tatamu.study.result import Result


def largest(errors: np.ndarray) -> float:
    """Return the largest value on the colour scale for the errors e_i [m]: their 99th percentile, rounded up.

    The largest error is not used, because a single vertex would then make the rest of the map pale.
    """
    goal = max(float(np.quantile(errors, 0.99)), 5e-4)
    power = 10.0 ** np.floor(np.log10(goal))
    rounds = (step * power for step in (1, 1.5, 2, 3, 4, 5, 6, 8, 10))
    return float(next(end for end in rounds if end >= goal * (1 - 1e-9)))


def maps(fold: Result) -> list[Chart]:
    """Return a map of the errors on the flat cloth.

    If more than 2 % of the cells hide the lower layer, return a map of each layer instead.
    """
    area = extent(fold.start, margin=0.012)
    upper, lower = (_seen(fold, area, sign) for sign in (1.0, -1.0))
    both = (upper[0] >= 0) & (lower[0] >= 0)
    apart = float((upper[0] != lower[0])[both].mean()) > 0.02
    layers = [("Upper layer", upper[1]), ("Lower layer, seen through the upper", lower[1])]
    chosen = layers if apart else [("The flat cloth", upper[1])]
    return [Chart(name, _plot(fold, area, values)) for name, values in chosen]


def _seen(fold: Result, area: Extent, sign: float) -> tuple[np.ndarray, np.ndarray]:
    """Return two arrays for the cells of a map, shape (h, w): the visible triangle, and the error [mm].

    The cloth is seen from above if `sign` is 1, and from below if `sign` is -1. The error in a cell is interpolated
    from the errors e_i of the triangle's corners. The error e_i is the distance between vertex i and its target.
    """
    cells = 45_000  # about
    view = area.view(round(np.sqrt(cells * area.size[0] / area.size[1])))
    projected = view.project(fold.start) * [1.0, 1.0, sign]
    visible = rasterise(projected, fold.faces, view.shape)
    values = np.full(view.shape, np.nan)
    values[visible.mask] = 1e3 * visible.sample(fold.errors, fold.faces)
    return visible.face, values


def _plot(fold: Result, area: Extent, values: np.ndarray) -> Plot:
    height, width = values.shape
    step = 1e3 * area.size / [width, height]
    heat = {
        "type": "heatmap",
        "z": [[None if value != value else value for value in row] for row in values[::-1].round(2).tolist()],
        "x0": round(float(1e3 * area.low[0] + step[0] / 2), 3),
        "dx": round(float(step[0]), 4),
        "y0": round(float(1e3 * area.low[1] + step[1] / 2), 3),
        "dy": round(float(step[1]), 4),
        "zmin": 0,
        "zmax": round(1e3 * largest(fold.errors), 6),
        "colorscale": [[k / 4, stop] for k, stop in enumerate(SCALE)],
        "colorbar": {
            "title": {"text": "e<sub>i</sub> [mm]", "side": "top"},
            "thickness": 10,
            "outlinewidth": 0,
            "len": 0.9,
        },
        "hoverongaps": False,
        "hovertemplate": "x %{x:.0f} mm, y %{y:.0f} mm<br>e<sub>i</sub> = %{z:.2f} mm<extra></extra>",
    }
    return traces(
        [heat, *_grasps(fold)],
        xaxis=axis("x [mm]", showgrid=False, constrain="domain"),
        yaxis=axis("y [mm]", showgrid=False, scaleanchor="x", scaleratio=1, constrain="domain"),
        shapes=_crease(fold),
    )


def _grasps(fold: Result) -> list[dict[str, Any]]:
    return [
        {
            "x": [1e3 * arm.grasp.position[0]],
            "y": [1e3 * arm.grasp.position[1]],
            "mode": "markers",
            "cliponaxis": False,
            "marker": {"size": 12, "color": colour, "line": {"color": "@card", "width": 2}},
            "hovertemplate": f"grasp, vertex {arm.grasp.vertex}<extra></extra>",
        }
        for colour, arm in zip(("@left", "@right"), fold.arms, strict=False)
    ]


def _crease(fold: Result) -> list[dict[str, Any]]:
    ends = fold.record.task.fold_line
    if not ends or any(len(end) < 2 for end in ends) or len(ends) != 2:
        return []
    (x0, y0), (x1, y1) = ((1e3 * end[0], 1e3 * end[1]) for end in ends)
    style = {"color": "@ink", "width": 1.2, "dash": "dash"}
    return [{"type": "line", "x0": x0, "y0": y0, "x1": x1, "y1": y1, "line": style}]
