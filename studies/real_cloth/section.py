"""A section: what a test on real cloth hands over to the notes and to the page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from tatamu.presentation.chart import Chart

Line = Mapping[str, str]
"""One line of a table: column to text."""


@dataclass(frozen=True)
class Tabulated:
    """One table."""

    name: str
    """Name of its marks in the docs and of its key in the JSON file."""
    lines: Sequence[Line]
    """All with the same columns."""


@dataclass(frozen=True)
class Sketch:
    """A drawing beside the tables."""

    title: str
    svg: str
    note: str = ""


@dataclass(frozen=True)
class Section:
    """Everything that one test shows."""

    name: str
    """Name that `--only` takes."""
    title: str
    method: str
    """How it was simulated, and what was assumed, in a few sentences."""
    tables: Sequence[Tabulated]
    beat: str
    """The number to beat, and whose it is."""
    goal: str
    """The goal, and whether it was reached."""
    silent: str
    """Limits of the test: all that it cannot show."""
    charts: Sequence[Chart] = ()
    sketches: Sequence[Sketch] = field(default=())


def reached(yes: bool) -> str:
    """A goal's verdict in a word."""
    return "reached" if yes else "not reached"
