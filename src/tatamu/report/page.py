"""Put the page together: one HTML file with its style, its scripts and its data inside."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path
from typing import Any

from tatamu import __version__
from tatamu.files import write_text
from tatamu.report import command, errormap, headline, histogram, search, tables, topview, ways
from tatamu.report.chart import Figure
from tatamu.report.markup import filled, inline, text
from tatamu.report.packing import packed
from tatamu.report.palette import css
from tatamu.report.replay import replay
from tatamu.results import LearnedFold, read_fold

SCRIPTS = (
    "packing",
    "matrix",
    "motion",
    "shapes",
    "shaders",
    "stage",
    "camera",
    "viewer",
    "player",
    "charts",
    "main",
)
"""In the order in which they need one another."""


def write_report(folder: Path) -> Path:
    """Write `report.html` into a result folder and return its path.

    Raises:
        InputError: A file is missing, broken, of another version or does not fit the others.
    """
    out = Path(folder) / "report.html"
    write_text(out, page(read_fold(Path(folder))))
    return out


def page(fold: LearnedFold) -> str:
    """The whole page; the same fold gives the same bytes."""
    from plotly.offline import get_plotlyjs

    charts: dict[str, Figure] = {}
    parts = {**_head(fold), **_body(fold, charts), **_tables(fold)}
    data = {
        **frame(headline.events(fold)),
        "plotly": packed(get_plotlyjs().encode()),
        "chart_data": inline(charts),
        "replay_data": inline(replay(fold, errormap.largest(fold.errors))),
    }
    return filled(resource("template.html"), {**parts, **data})


def frame(events: str, robot: bool = False) -> dict[str, str]:
    """What every page has: its style, its scripts, the card of the replay with marks under the slider (HTML)."""
    switch = '<label><input type="checkbox" data-show="robot" checked> robot</label>' if robot else ""
    return {
        "style": resource("style.css"),
        "palette": css(),
        "scripts": "\n".join(resource(f"{name}.js") for name in SCRIPTS),
        "replay": filled(resource("replay.html"), {"events": events, "robot": switch}),
    }


def resource(name: str) -> str:
    """A file of the page's."""
    return files("tatamu.report").joinpath(name).read_text(encoding="utf-8")


def _head(fold: LearnedFold) -> dict[str, str]:
    verdict = headline.word(fold)
    return {
        "title": text(headline.title(fold)),
        "verdict": verdict,
        "verdict_class": verdict.replace(" ", "-"),
        "sentence": headline.sentence(fold),
        "gauge": headline.gauge(fold),
        "tiles": headline.tiles(fold),
        "learn_command": text(command.learn(fold)),
        "simulate_command": text(command.simulate(fold)),
        "version": text(fold.result.tatamu or __version__),
    }


def _body(fold: LearnedFold, charts: dict[str, Figure]) -> dict[str, str]:
    """The figures' places; what fills them is added to `charts`."""
    moments = histogram.along(fold.moments)
    maps = [(name, "", figure) for name, figure in errormap.maps(fold)]
    own = histogram.histogram(fold.errors, histogram.bin_width(float(fold.errors.max())))
    return {
        "topviews": topview.figures(fold),
        "maps": _multiples(charts, "map", maps),
        "map_count": str(len(maps)),
        "own": _multiples(charts, "own", [("Errors at their own scale", "", own)]),
        "histograms": _multiples(charts, "moment", moments),
        "objective": _multiples(charts, "objective", [("Best so far", "", search.objective(fold.result))]),
        "distance": _multiples(charts, "distance", [("Each trial’s error", "", search.distance(fold.result))]),
        "ways": _multiples(charts, "ways", [("Hands in the plane of the fold", "", ways.figure(fold))]),
    }


def _multiples(charts: dict[str, Figure], name: str, figures: list[tuple[str, str, Any]]) -> str:
    places = []
    for number, (title, caption, figure) in enumerate(figures):
        key = f"{name}-{number}"
        charts[key] = figure
        says = f"<b>{text(title)}</b> {text(caption)}"
        places.append(f'<figure><figcaption>{says}</figcaption><div class="chart {name}" id="{key}"></div></figure>')
    return "".join(places)


def _tables(fold: LearnedFold) -> dict[str, str]:
    return {
        "measures": tables.measures(fold),
        "parameters": tables.parameters(fold),
        "control_points": tables.control_points(fold),
        "timing": tables.timing(fold),
        "material": tables.material(fold),
        "task": tables.task(fold),
        "warnings": tables.warnings(fold),
    }
