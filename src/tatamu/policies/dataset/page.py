"""The page of a dataset: successes by garment and fold, and pictures of episodes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from markupsafe import Markup

from tatamu.evaluation.success import interval_of
from tatamu.folding.score import Limits, judged_distance
from tatamu.policies.dataset.folder import DatasetRecord
from tatamu.policies.dataset.record import EpisodeRecord
from tatamu.report.measures import MEASURES, Measure
from tatamu.show.chart import Chart, axis, dots, line, log_axis, traces
from tatamu.show.image import data_uri
from tatamu.show.page import render
from tatamu.show.quantity import NOTHING, Table

MIN_DISTANCE = 1e-4
"""Smallest distance on a logarithmic axis [m]; smaller ones are shown at it."""


def page(dataset: DatasetRecord, records: Sequence[EpisodeRecord], pictures: Sequence[np.ndarray]) -> str:
    """Return the whole page as HTML.

    Args:
        dataset: Description of the dataset.
        records: Records of all episodes.
        pictures: Outcomes of the first episodes: RGB, uint8, shape (h, w, 3).
    """
    shown = [each for each in records if each.score is not None]
    charts = {"outcome": [_distances(shown), _paths(shown)] if shown else []}
    return render(
        "policies/dataset/page.html",
        charts=charts if shown else None,
        title=f"{dataset.episodes} episodes",
        succeeded=dataset.successes,
        episodes=dataset.episodes,
        frames=dataset.frames,
        fps=dataset.specification.record.fps,
        seconds=f"{dataset.frames / dataset.specification.record.fps:.0f}",
        facts=_facts(dataset),
        groups=_groups(records),
        measures=Table(
            ("measure", "minimum", "median", "90 %", "maximum"),
            [(Markup(measure.heading), *_spread(measure, shown)) for measure in MEASURES],
        ),
        errors=Table(("episode", "error"), [(str(each.episode), each.error) for each in records if each.error]),
        thumbnails=[(data_uri(picture), _words(record)) for picture, record in zip(pictures, records, strict=False)],
    )


def _facts(dataset: DatasetRecord) -> list[tuple[str, str]]:
    specification = dataset.specification
    cameras = ", ".join(specification.cameras) or "none"
    robot = "floating hands" if dataset.stand is None else dataset.stand.robot
    return [
        ("folds", specification.fold.source),
        ("episodes per fold", str(specification.per_fold)),
        ("disturbances", specification.disturbances),
        ("robot", robot),
        ("cameras", f"{cameras}, {specification.record.pixels} pixels" if specification.cameras else cameras),
        ("formats", ", ".join(specification.formats)),
        ("seed", str(specification.seed)),
    ]


def _groups(records: Sequence[EpisodeRecord]) -> Table:
    """Return a table of the success rates and the mean vertex distances of each garment and fold plan."""
    groups: dict[str, list[EpisodeRecord]] = {}
    for record in records:
        groups.setdefault(f"{Path(record.garment).stem}, {Path(record.plan).stem}", []).append(record)
    head = ("garment, plan", "episodes", "succeed", "interval", "median [mm]", "90 % [mm]")
    return Table(head, [(name, *_summary(group)) for name, group in groups.items()])


def _summary(group: Sequence[EpisodeRecord]) -> list[str]:
    held = sum(record.success for record in group)
    low, high = interval_of(held, len(group))
    distances = [1e3 * each.score.mean_vertex_distance for each in group if each.score is not None]
    middle = [f"{np.quantile(distances, part):.1f}" for part in (0.5, 0.9)] if distances else ["–", "–"]
    return [str(len(group)), f"{100 * held / len(group):.0f} %", f"{100 * low:.0f} to {100 * high:.0f} %", *middle]


def _spread(measure: Measure, records: Sequence[EpisodeRecord]) -> list[str]:
    values = [value for record in records if (value := measure.value(record.score)) is not None]
    return [measure.number(float(np.quantile(values, part))) if values else NOTHING for part in (0.0, 0.5, 0.9, 1.0)]


def _words(record: EpisodeRecord) -> str:
    distance = "stopped" if record.score is None else f"{1e3 * _distance(record):.1f} mm"
    return f"{record.episode}: {distance}" + ("" if record.success else ", fails")


def _distances(records: Sequence[EpisodeRecord]) -> Chart:
    values = np.array([max(_distance(record), MIN_DISTANCE) for record in records]) * 1e3
    edges = np.geomspace(0.9 * values.min(), 1.1 * values.max(), 31)
    counts, _ = np.histogram(values, edges)
    limit = 1e3 * Limits().mean_vertex_distance
    middles = np.sqrt(edges[1:] * edges[:-1])
    bars = {
        "type": "bar",
        "x": middles.round(4).tolist(),
        "y": counts.tolist(),
        "width": np.diff(edges).round(4).tolist(),
        "marker": {"color": ["@plot" if middle <= limit else "@warm" for middle in middles], "line": {"width": 0}},
        "hovertemplate": "%{y} episodes<br>%{x:.3~g} mm<extra></extra>",
    }
    whole = {"dtick": 1} if counts.max() < 6 else {}
    plot = traces(
        [bars],
        bargap=0,
        xaxis=log_axis("distance from the target [mm]", min(edges[0], 0.8 * limit), max(edges[-1], 1.25 * limit)),
        yaxis=axis("episodes", **whole),
        shapes=[line("x", limit)],
    )
    return Chart(
        "Distance from the target", plot, f"success needs {limit:g} mm, the dotted line, and the view from above"
    )


def _paths(records: Sequence[EpisodeRecord]) -> Chart:
    shown = [(record, 1e3 * max(_distance(record), MIN_DISTANCE)) for record in records]
    clouds = []
    for succeeds, colour, name in ((True, "@plot", "succeeds"), (False, "@warm", "fails")):
        own = [(record, height) for record, height in shown[:5000] if record.success == succeeds]
        lengths = [0.0 if record.score is None else round(record.score.trajectory_length, 4) for record, _ in own]
        drawn = dots(
            lengths,
            [round(height, 4) for _, height in own],
            "%{text}<br>%{x:.3f} m, %{y:.2f} mm",
            name=name,
            text=[f"episode {record.episode}" for record, _ in own],
            size=6,
            color=colour,
            opacity=0.7,
        )
        clouds.append(drawn)
    values = [height for _, height in shown]
    plot = traces(
        clouds,
        xaxis=axis("l_x: length of a hand's path [m]"),
        yaxis=log_axis("distance from the target [mm]", 0.8 * min(values), 1.25 * max(values)),
        showlegend=True,
    )
    return Chart("Path against distance", plot, "each dot an episode")


def _distance(record: EpisodeRecord) -> float:
    """Return the distance that decides about success [m]; infinite if the simulation failed."""
    found = None if record.score is None else judged_distance(record.score)
    return np.inf if found is None else found
