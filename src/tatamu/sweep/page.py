"""Writes the HTML page and the table that compare the tasks of a sweep."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import Any

from tatamu.base.files import write_text
from tatamu.report.measures import SUCCESS, grade
from tatamu.show.chart import Chart, axis, dots, line, log_axis, rows, traces
from tatamu.show.page import render
from tatamu.show.palette import SERIES
from tatamu.show.quantity import Table, number
from tatamu.sweep.records import SweepFolder, TaskRecord
from tatamu.sweep.table import counts, varied, write_parquet

MAX_POINTS = 5000
"""Largest number of tasks in a chart. The table contains all tasks."""


def write_results(folder: SweepFolder, records: Sequence[TaskRecord]) -> Path:
    """Write `sweep.parquet` and the page of a sweep.

    Returns:
        Path of the page.
    """
    write_parquet(records, folder.table_file)
    write_text(folder.page_file, page(records))
    return folder.page_file


def page(records: Sequence[TaskRecord]) -> str:
    """Return the page of a sweep as HTML."""
    names = varied(records)
    apart = [name for name in names if name != "seed"]
    complete = [record for record in records if record.state == "complete"]
    groups = grouped(complete, apart)
    head = ("task", "studies", "median [mm]", "worst [mm]", "median C", "median IoU", "succeed")
    return render(
        "sweep/page.html",
        charts={"distance": [_distances(groups)], "pair": _pairs(complete)} if complete else None,
        title="Sweep",
        counted=counts(records),
        succeeded=sum((record.mean_vertex_distance or 1.0) < SUCCESS for record in complete),
        complete=len(complete),
        success=f"{1e3 * SUCCESS:g} mm",
        failed=Table(("task", "error"), [(each.name, each.error or "") for each in records if each.state == "failed"]),
        groups=Table(head, [(name or "all", *_summary(group)) for name, group in groups.items()]),
        names=names,
        rows=[(record, [_shown(record.options.get(name)) for name in names], _cells(record)) for record in records],
    )


def grouped(records: Sequence[TaskRecord], names: Sequence[str]) -> dict[str, list[TaskRecord]]:
    """Return the tasks in groups, so that the options `names` have equal values in a group.

    Each group's key is a text with these values.
    """
    groups: dict[str, list[TaskRecord]] = {}
    for record in records:
        words = ", ".join(_shown(record.options[name]) for name in names if name in record.options)
        groups.setdefault(words, []).append(record)
    return groups


def _summary(group: Sequence[TaskRecord]) -> list[str]:
    distances = [record.mean_vertex_distance for record in group if record.mean_vertex_distance is not None]
    objectives = [record.objective for record in group if record.objective is not None]
    overlaps = [record.mask_iou for record in group if record.mask_iou is not None]
    return [
        str(len(group)),
        number(median(distances) if distances else None, "mm", ".1f"),
        number(max(distances, default=None), "mm", ".1f"),
        number(median(objectives) if objectives else None, form=".4f"),
        number(median(overlaps) if overlaps else None, form=".3f"),
        f"{sum(distance < SUCCESS for distance in distances)} of {len(group)}",
    ]


def _distances(groups: dict[str, list[TaskRecord]]) -> Chart:
    """Return a chart of the mean vertex distances, with a row for each group and a dot for each task."""
    shown = [(name, record) for name, group in groups.items() for record in group][:MAX_POINTS][::-1]
    values = [_distance(record) for _, record in shown]
    drawn = dots(
        [round(value, 4) for value in values],
        [_short(name) for name, _ in shown],
        "%{text}<br>%{x:.2f} mm",
        text=[record.name for _, record in shown],
        size=9,
        color="@plot",
        opacity=0.7,
    )
    low, high = 0.8 * min([*values, 1e3 * SUCCESS]), 1.25 * max([*values, 1e3 * SUCCESS])
    plot = traces(
        [drawn],
        xaxis=log_axis("mean vertex distance [mm]", low, high),
        **rows(groups),
        shapes=[line("x", 1e3 * SUCCESS)],
    )
    caption = f"each dot a task; success left of the line, {1e3 * SUCCESS:g} mm"
    return Chart("Mean vertex distance", plot, caption, kind="rows")


def _pairs(records: Sequence[TaskRecord]) -> list[Chart]:
    """Return charts with a dot for each task, whose coordinates are the two terms of the objective, Eq. (10)."""
    both = [record for record in records if record.trajectory_length is not None][:MAX_POINTS]
    if not both:
        return []
    garments = list(dict.fromkeys(str(record.options.get("garment")) for record in both))
    data = []
    for place, garment in enumerate(garments):
        own = [record for record in both if str(record.options.get("garment")) == garment]
        lengths, heights = [each.trajectory_length for each in own], [round(_distance(each), 4) for each in own]
        named, colour = [record.name for record in own], f"@series-{place % SERIES}"
        hover = "%{text}<br>%{x:.3f} m, %{y:.2f} mm"
        data.append(dots(lengths, heights, hover, name=garment, text=named, size=8, color=colour))
    distances = [_distance(record) for record in both]
    plot = traces(
        data,
        xaxis=axis("l_x: length of a hand's path [m]"),
        yaxis=log_axis("mean vertex distance [mm]", 0.8 * min(distances), 1.25 * max(distances)),
        showlegend=len(garments) > 1,
    )
    return [Chart("Path against distance", plot, "what the objective weighs against each other")]


def _distance(record: TaskRecord) -> float:
    """Return the distance of a task on a logarithmic axis [mm]; smaller ones appear at 0.01 mm."""
    return 1e3 * max(record.mean_vertex_distance or 0.0, 1e-5)


def _cells(record: TaskRecord) -> list[tuple[str, str]]:
    """Return the table cells with the results of a task.

    Each cell has a text and a grade. The grade gives the colour of the cell.
    """
    if record.mean_vertex_distance is None:
        return []
    return [
        (number(record.mean_vertex_distance, "mm", ".1f"), grade(record.mean_vertex_distance)),
        (number(record.objective, form=".4f"), ""),
        (number(record.mask_iou, form=".3f"), ""),
        (number(record.crossings), ""),
        (str(record.trials), ""),
    ]


def _shown(value: Any) -> str:
    return "" if value is None else value if isinstance(value, str) else json.dumps(value)


def _short(words: str) -> str:
    """Return the name of a row of the chart, shortened if it is long."""
    return (words if len(words) <= 44 else words[:42] + "..") or "all"
