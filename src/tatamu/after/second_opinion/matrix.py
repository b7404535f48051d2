"""Writes the page and the terminal's table that compare simulators."""

from __future__ import annotations

from pathlib import Path

from rich.table import Table

from tatamu.after.second_opinion.agreement import LEARNED, Agreement, Pair
from tatamu.base.files import write_json, write_text
from tatamu.folding.baselines import BASELINES
from tatamu.report.headline import title
from tatamu.show.chart import Chart, Plot, log_axis, traces
from tatamu.show.page import render


def save(agreement: Agreement, folder: Path) -> Path:
    """Write `agreement.json` and the page `agreement.html`, and return the path of the page."""
    write_json(folder / "agreement.json", agreement.to_json())
    write_text(folder / "agreement.html", page(agreement))
    return folder / "agreement.html"


def pair_cells(pair: Pair) -> list[str]:
    """Return the table cells that compare two simulators."""
    learned = pair.between.get(LEARNED)
    return [
        f"{pair.first}, {pair.second}",
        f"{pair.objective_rank:.2f}",
        f"{pair.distance_rank:.2f}",
        *(_millimetres(value) for value in (pair.mean_between, pair.median_between, learned)),
    ]


HEAD = ("simulators", "rank of C", "rank of mean distance", "mean [mm]", "median [mm]", "learned [mm]")


def terminal(agreement: Agreement) -> Table:
    """Return the table that compares simulators, for the terminal."""
    out = Table(title=f"{len(agreement.manipulations)} manipulations of {agreement.learned.name}", title_justify="left")
    for number, name in enumerate(HEAD):
        out.add_column(name, justify="left" if number == 0 else "right")
    for pair in agreement.pairs:
        out.add_row(*pair_cells(pair))
    return out


def page(agreement: Agreement) -> str:
    """Return the page that compares simulators as HTML."""
    pairs = [Chart(f"{pair.first} and {pair.second}", _scatter(agreement, pair)) for pair in agreement.pairs]
    return render(
        "after/second_opinion/matrix.html",
        charts={"pair": pairs},
        title=title(agreement.learned),
        agreement=agreement,
        fixed=len(BASELINES),
        head=HEAD,
        rows=[pair_cells(pair) for pair in agreement.pairs],
        scores=[
            (_spelled(name), [agreement.entries[name, simulator] for simulator in agreement.simulators])
            for name in agreement.manipulations
        ],
    )


def _spelled(name: str) -> str:
    """Return the name of a manipulation as the page and the terminal show it."""
    return BASELINES[name][0] if name in BASELINES else name


def _millimetres(value: float | None) -> str:
    return "–" if value is None else f"{1e3 * value:.1f}"


def _scatter(agreement: Agreement, pair: Pair) -> Plot:
    columns = zip(agreement.column(pair.first), agreement.column(pair.second), strict=True)
    both = [(a.manipulation, a.score, b.score) for a, b in columns if a.score and b.score]
    x = [1e3 * first.mean_vertex_distance for _, first, _ in both]
    y = [1e3 * second.mean_vertex_distance for _, _, second in both]
    ends = [0.8 * min([*x, *y], default=0.1), 1.25 * max([*x, *y], default=1.0)]
    names = [name for name, _, _ in both]
    return traces(
        [
            {"x": ends, "y": ends, "mode": "lines", "line": {"color": "@muted", "width": 1}, "hoverinfo": "skip"},
            {
                "x": [round(value, 4) for value in x],
                "y": [round(value, 4) for value in y],
                "text": names,
                "mode": "markers",
                "marker": {"size": 9, "color": ["@warm" if name == LEARNED else "@plot" for name in names]},
                "hovertemplate": "%{text}<br>%{x:.2f} mm, %{y:.2f} mm<extra></extra>",
            },
        ],
        xaxis=log_axis(f"{pair.first} [mm]", *ends),
        yaxis=log_axis(f"{pair.second} [mm]", *ends),
    )
