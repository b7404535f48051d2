"""Writes the page and the picture of a learned fold that was simulated in another simulator."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from tatamu.after.second_opinion.check import Opinion
from tatamu.base.files import write_json, write_text
from tatamu.report.errormap import maps
from tatamu.report.headline import title
from tatamu.report.measures import MEASURES
from tatamu.report.still import FINER
from tatamu.report.still import render as still
from tatamu.report.tables import Column
from tatamu.report.topview import TopView, draw, extent, outlined, painted, paths, view
from tatamu.show.chart import Chart, Plot, axis, traces
from tatamu.show.image import save_png
from tatamu.show.page import render
from tatamu.show.shading import shrink, to_pixels
from tatamu.study.result import Result


def save(opinion: Opinion, folder: Path) -> Path:
    """Write `check.json` and the page `check.html`.

    If the simulation succeeded, `rollout.npz` and `check.png` are written as well.

    Returns:
        Path of the page.
    """
    if opinion.rollout is not None:
        second = seen(opinion)
        second.rollout.save(folder / "rollout.npz")
        both = np.hstack([to_pixels(shrink(still(fold), FINER)) for fold in (opinion.learned, second)])
        save_png(both, folder / "check.png")
    write_json(folder / "check.json", opinion.to_json())
    write_text(folder / "check.html", page(opinion))
    return folder / "check.html"


def seen(opinion: Opinion) -> Result:
    """Return the learned fold with the score and the rollout of the other simulator."""
    rollout = opinion.rollout
    assert rollout is not None
    fold = opinion.learned
    return replace(fold, rollout=replace(rollout, extra={"target": fold.target}))


def page(opinion: Opinion) -> str:
    """Return the page of a result from another simulator as HTML."""
    shown: dict[str, Any] = {"charts": {}, "views": []}
    if opinion.rollout is not None:
        second = seen(opinion)
        shown = {"charts": _charts(opinion, second), "views": _views(opinion.learned, second, opinion)}
    return render(
        "after/second_opinion/page.html",
        title=title(opinion.learned),
        opinion=opinion,
        apart=None if opinion.score is None else float(opinion.apart.mean()),
        columns=[Column(opinion.learned.simulator, opinion.learned.score), Column(opinion.simulator, opinion.score)],
        measures=MEASURES,
        warnings=[str(warning) for warning in opinion.rollout.info.get("warnings", [])] if opinion.rollout else [],
        **shown,
    )


def _charts(opinion: Opinion, second: Result) -> dict[str, list[Chart]]:
    there = replace(second.rollout, extra={"target": opinion.learned.final})
    apart = [
        replace(chart, title=f"Distance between the two: {chart.title.lower()}")
        for chart in maps(replace(second, rollout=there))
    ]
    return {"apart": [Chart("From the side", _section(opinion, second)), *apart]}


def _views(first: Result, second: Result, opinion: Opinion) -> list[TopView]:
    area = extent(first.target, first.final, second.final)
    hands = paths(first)
    target, wanted = draw(painted(first, first.target), area)
    views = [view("Target", "the target shape", target, area)]
    for fold, name, word in (
        (first, opinion.learned.simulator, "learned here"),
        (second, opinion.simulator, "the second opinion"),
    ):
        final, _ = draw(painted(fold, fold.final), area)
        views.append(view(name.capitalize(), word, outlined(final, wanted), area, hands))
    return views


def _section(opinion: Opinion, second: Result) -> Plot:
    fold = opinion.learned.task.fold
    across, along = fold.crease.split(fold.start)
    strip = np.abs(along - np.median(along)) < 0.6 * fold.garment.spacing
    strip = np.flatnonzero(strip)[np.argsort(across[strip])]
    shapes = [
        ("target", fold.target, "@target"),
        (opinion.learned.simulator, opinion.learned.final, "@plot"),
        (opinion.simulator, second.final, "@warm"),
    ]
    return traces(
        [
            {
                "name": name,
                "x": (1e3 * fold.crease.split(shape)[0][strip]).round(2).tolist(),
                "y": (1e3 * shape[strip, 2]).round(2).tolist(),
                "mode": "lines+markers",
                "line": {"color": colour, "width": 1.2},
                "marker": {"size": 4, "color": colour},
                "hovertemplate": f"{name}<br>%{{x:.1f}} mm from the fold line, %{{y:.1f}} mm high<extra></extra>",
            }
            for name, shape, colour in shapes
        ],
        showlegend=True,
        xaxis=axis("across the fold line [mm]"),
        yaxis=axis("height [mm]", rangemode="tozero"),
    )
