"""A page of figures and tables in the house's style, with a replay where one is given; opens offline."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from tatamu import __version__
from tatamu.report.chart import Figure
from tatamu.report.markup import filled, inline, text
from tatamu.report.packing import packed
from tatamu.report.page import frame, resource
from tatamu.report.palette import css

SCRIPTS = ("packing", "charts", "sheet")
GRADES = {True: "near-perfect", False: "failed"}


class Sheet:
    """A page under way: sections of HTML, and the figures that its places are filled with."""

    def __init__(self, kind: str, title: str, lead: str, verdict: str = "", good: bool = True) -> None:
        """Begin a page.

        Args:
            kind: What sort of page it is, in a few words.
            title: Plain text.
            lead: The result in a sentence, HTML.
            verdict: A word beside the title; none: no word.
            good: Whether that word is good news.
        """
        self.kind, self.title, self.lead = kind, title, lead
        self.pill = f'<span class="pill large {GRADES[good]}">{text(verdict)}</span>' if verdict else ""
        self._sections: list[str] = []
        self._charts: dict[str, Figure] = {}
        self._replay: tuple[dict[str, Any], str] | None = None

    def replay(self, data: dict[str, Any], events: str = "") -> None:
        """Show a replay above all sections: its data, and marks under the time slider (HTML)."""
        self._replay = data, events

    def section(self, title: str, about: str, *cards: str) -> None:
        """Add a section; `about` and the cards are HTML."""
        inside = "".join(cards)
        self._sections.append(f'<section><h2>{text(title)}</h2><p class="about">{about}</p>{inside}</section>')

    def chart(self, title: str, figure: Figure, caption: str = "", kind: str = "") -> str:
        """A figure's place, as HTML; a script fills it in."""
        key = f"chart-{len(self._charts)}"
        self._charts[key] = figure
        says = f"<b>{text(title)}</b> {text(caption)}"
        return f'<figure><figcaption>{says}</figcaption><div class="chart {kind}" id="{key}"></div></figure>'

    def html(self) -> str:
        """The whole page; the same content gives the same bytes."""
        from plotly.offline import get_plotlyjs

        parts = {
            "replay": "",
            "replay_data": "",
            "style": resource("style.css"),
            "palette": css(),
            "scripts": "\n".join(resource(f"{name}.js") for name in SCRIPTS),
        }
        if self._replay:
            data, events = self._replay
            parts |= frame(events, "robot" in data)
            parts["replay_data"] = f'<script type="application/json" id="replay-data">{inline(data)}</script>\n'
        parts |= {
            "kind": text(self.kind),
            "title": text(self.title),
            "pill": self.pill,
            "lead": self.lead,
            "body": "".join(self._sections),
            "plotly": packed(get_plotlyjs().encode()),
            "chart_data": inline(self._charts),
            "version": text(__version__),
        }
        return filled(resource("sheet.html"), parts)


def card(kind: str, inside: Iterable[str] | str) -> str:
    """A card of the page; `kind` is its layout: "", "two", "three", "multiples"."""
    return f'<div class="card {kind}">{inside if isinstance(inside, str) else "".join(inside)}</div>'
