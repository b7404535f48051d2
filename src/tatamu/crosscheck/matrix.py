"""The page and the terminal's table of how far simulators agree."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from rich.table import Table

from tatamu.crosscheck.agreement import LEARNED, Agreement, Entry, Pair
from tatamu.files import write_json, write_text
from tatamu.folding.baselines import BASELINES
from tatamu.report.chart import Figure, axis, layout
from tatamu.report.headline import title
from tatamu.report.markup import table, text
from tatamu.report.sheet import Sheet, card

ABOUT_RANKS = (
    "Spearman’s rank correlation over the manipulations, of the objective C and of the mean vertex distance alone; "
    "then the distance between the final shapes, mean over vertices, as mean and median over the manipulations, and "
    "of the learned one."
)


def save(agreement: Agreement, folder: Path) -> Path:
    """Write `agreement.json` and `agreement.html`; returns the page."""
    write_json(folder / "agreement.json", agreement.to_json())
    write_text(folder / "agreement.html", page(agreement))
    return folder / "agreement.html"


def pair_cells(pair: Pair) -> list[str]:
    """A pair of simulators as text."""
    learned = pair.between.get(LEARNED)
    return [
        f"{pair.first}, {pair.second}",
        f"{pair.objective_rank:.2f}",
        f"{pair.distance_rank:.2f}",
        *(_millimetres(value) for value in (pair.mean_between, pair.median_between, learned)),
    ]


HEAD = ("simulators", "rank of C", "rank of mean distance", "mean [mm]", "median [mm]", "learned [mm]")


def terminal(agreement: Agreement) -> Table:
    """The matrix for the terminal."""
    out = Table(title=f"{len(agreement.manipulations)} manipulations of {agreement.learned.name}", title_justify="left")
    for number, name in enumerate(HEAD):
        out.add_column(name, justify="left" if number == 0 else "right")
    for pair in agreement.pairs:
        out.add_row(*pair_cells(pair))
    return out


def page(agreement: Agreement) -> str:
    """The whole page."""
    count = len(agreement.manipulations)
    lead = (
        f"{count} manipulations of the same cloth in {text(', '.join(agreement.simulators))}: "
        f"the learned one, {len(BASELINES)} fixed trajectories and {count - 1 - len(BASELINES)} random ones."
    )
    verdict = "the learned fold holds in all" if agreement.holds else "the learned fold does not hold in all"
    sheet = Sheet("simulators compared", title(agreement.learned.fold), lead, verdict, agreement.holds)
    sheet.section("Agreement", ABOUT_RANKS, card("", _matrix(agreement)))
    plots = [sheet.chart(f"{pair.first} and {pair.second}", _scatter(agreement, pair)) for pair in agreement.pairs]
    about = "Mean vertex distance from the target in one simulator and in the other; on the line they say the same."
    sheet.section("Each manipulation twice", about, card("multiples", plots))
    about = "C, and in brackets the mean vertex distance from the target [mm]."
    sheet.section("All scores", about, card("", _scores(agreement)))
    return sheet.html()


def _matrix(agreement: Agreement) -> str:
    body = []
    for pair in agreement.pairs:
        first, *others = pair_cells(pair)
        cells = "".join(f'<td class="number">{cell}</td>' for cell in others)
        body.append(f'<tr><th scope="row">{text(first)}</th>{cells}</tr>')
    return table(HEAD, body)


def _millimetres(value: float | None) -> str:
    return "–" if value is None else f"{1e3 * value:.1f}"


def _scatter(agreement: Agreement, pair: Pair) -> Figure:
    columns = zip(agreement.column(pair.first), agreement.column(pair.second), strict=True)
    both = [(a.manipulation, a.score, b.score) for a, b in columns if a.score and b.score]
    x = [1e3 * first.mean_vertex_distance for _, first, _ in both]
    y = [1e3 * second.mean_vertex_distance for _, _, second in both]
    ends = [0.8 * min([*x, *y], default=0.1), 1.25 * max([*x, *y], default=1.0)]
    names = [name for name, _, _ in both]
    return {
        "data": [
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
        "layout": layout(xaxis=axis(f"{pair.first} [mm]", type="log"), yaxis=axis(f"{pair.second} [mm]", type="log")),
    }


def _scores(agreement: Agreement) -> str:
    return table(["manipulation", *(text(name) for name in agreement.simulators)], _rows(agreement))


def _rows(agreement: Agreement) -> Iterator[str]:
    for name in agreement.manipulations:
        shown = BASELINES[name][0] if name in BASELINES else name
        cells = "".join(_cell(agreement.entries[name, simulator]) for simulator in agreement.simulators)
        yield f'<tr><th scope="row">{text(shown)}</th>{cells}</tr>'


def _cell(entry: Entry) -> str:
    if entry.score is None:
        return f"<td>failed: {text(entry.error or '')}</td>"
    distance = 1e3 * entry.score.mean_vertex_distance
    return f'<td class="number">{entry.objective:.3f} ({distance:.1f})</td>'
