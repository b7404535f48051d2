"""The page and the picture of a second opinion."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from tatamu.crosscheck.check import Opinion
from tatamu.files import replacing, write_json, write_text
from tatamu.report import png
from tatamu.report.chart import Figure, axis, layout
from tatamu.report.errormap import maps
from tatamu.report.headline import title
from tatamu.report.markup import text
from tatamu.report.shading import shrink, to_pixels
from tatamu.report.sheet import Sheet, card
from tatamu.report.still import FINER, render
from tatamu.report.tables import compared
from tatamu.report.topview import draw, extent, figure, outlined
from tatamu.results import LearnedFold, Scores
from tatamu.rollout import Rollout


def save(opinion: Opinion, folder: Path) -> Path:
    """Write `check.json`, `check.html` and, where the simulation ended well, `rollout.npz` and `check.png`.

    Returns:
        The page.
    """
    if opinion.rollout is not None:
        second = seen(opinion)
        second.rollout.save(folder / "rollout.npz")
        both = np.hstack([to_pixels(shrink(render(fold), FINER)) for fold in (opinion.learned.fold, second)])
        with replacing(folder / "check.png") as temporary:
            temporary.write_bytes(png.encode(both))
    write_json(folder / "check.json", opinion.to_json())
    write_text(folder / "check.html", page(opinion))
    return folder / "check.html"


def seen(opinion: Opinion) -> LearnedFold:
    """The learned fold as the other simulator has it."""
    told = opinion.rollout
    assert told is not None
    fold = opinion.learned.fold
    return replace(fold, rollout=Rollout(told.times, told.positions, told.faces, told.info, {"target": fold.target}))


def page(opinion: Opinion) -> str:
    """The whole page."""
    fold, there = opinion.learned.fold, opinion.simulator
    verdict = f"holds in {there}" if opinion.holds else f"does not hold in {there}"
    sheet = Sheet("a second opinion", title(fold), _lead(opinion), verdict, opinion.holds)
    if opinion.rollout is not None:
        _pictures(sheet, opinion)
    about = (
        "The same manipulation where it was learned and where it was checked, with the thresholds of the literature."
    )
    sheet.section("Measures", about, card("", _measures(opinion)), _warnings(opinion))
    return sheet.html()


def _lead(opinion: Opinion) -> str:
    if opinion.score is None:
        return f"The simulation in {text(opinion.simulator)} failed: {text(opinion.error or '')}."
    there = 1e3 * opinion.score.mean_vertex_distance
    here = 1e3 * opinion.learned.score.mean_vertex_distance
    return (
        f"Learned in {text(opinion.learned.simulator)}, where the cloth ends {here:.1f}&nbsp;mm from its target on "
        f"average. In {text(opinion.simulator)} the same hands leave it <strong>{there:.1f}&nbsp;mm</strong> from the "
        f"target, and <strong>{1e3 * opinion.apart.mean():.1f}&nbsp;mm</strong> from where it was when learned."
    )


def _pictures(sheet: Sheet, opinion: Opinion) -> None:
    fold, second = opinion.learned.fold, seen(opinion)
    sheet.section(
        "Side by side",
        "The final state from above. The outlines are the target’s.",
        card("three", _views(fold, second, opinion)),
    )
    apart = replace(
        second,
        rollout=Rollout(
            second.rollout.times, second.rollout.positions, fold.faces, second.rollout.info, {"target": fold.final}
        ),
    )
    sheet.section(
        "Where they differ",
        "Left, a section across the fold line through the middle of the cloth. Right, the distance between the two "
        "final places of each vertex, on the cloth before the fold.",
        card(
            "two",
            [
                sheet.chart("From the side", _section(opinion, second)),
                *(sheet.chart(f"Distance between the two: {name.lower()}", chart) for name, chart in maps(apart)),
            ],
        ),
    )


def _views(first: LearnedFold, second: LearnedFold, opinion: Opinion) -> str:
    area = extent(first.target, first.final, second.final)
    ways = {arm.name: first.hand(arm) for arm in first.manipulation.arms}
    target, wanted = draw(first, first.target, area)
    pictures = [("Target", "the wanted shape", target)]
    for fold, name, word in (
        (first, opinion.learned.simulator, "where it was learned"),
        (second, opinion.simulator, "the second opinion"),
    ):
        pictures.append((name.capitalize(), word, outlined(draw(fold, fold.final, area)[0], wanted)))
    return "".join(
        figure(name, note, image, area, ways if number else {}) for number, (name, note, image) in enumerate(pictures)
    )


def _section(opinion: Opinion, second: LearnedFold) -> Figure:
    fold = opinion.learned.task.fold
    across, along = fold.crease.split(fold.start)
    strip = np.abs(along - np.median(along)) < 0.6 * fold.garment.spacing
    strip = np.flatnonzero(strip)[np.argsort(across[strip])]
    shapes = [
        ("target", fold.target, "@target"),
        (opinion.learned.simulator, opinion.learned.fold.final, "@plot"),
        (opinion.simulator, second.final, "@warm"),
    ]
    return {
        "data": [
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
        "layout": layout(
            showlegend=True,
            legend={"orientation": "h", "y": 1.12},
            xaxis=axis("across the fold line [mm]"),
            yaxis=axis("height [mm]", rangemode="tozero"),
        ),
    }


def _measures(opinion: Opinion) -> str:
    columns = [opinion.learned.score, opinion.score]
    scores = [Scores.model_validate(score.as_dict()) if score else Scores() for score in columns]
    names = (opinion.learned.simulator, opinion.simulator)
    return compared(list(zip(names, scores, strict=True)))


def _warnings(opinion: Opinion) -> str:
    said = opinion.rollout.info.get("warnings", []) if opinion.rollout else []
    items = "".join(f"<li>{text(str(warning))}</li>" for warning in said)
    return f'<ul class="warnings">{items}</ul>' if items else ""
