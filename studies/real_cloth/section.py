"""A section: the result of a test on real cloth for the notes and for the page."""

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
    """Lines with the same columns."""


@dataclass(frozen=True)
class Sketch:
    """A drawing next to the tables."""

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
    """The simulation and its assumptions, in a few sentences."""
    tables: Sequence[Tabulated]
    beat: str
    """The best published number, and its source."""
    goal: str
    """The goal, and whether it was reached."""
    silent: str
    """Limits of the test: all that it cannot show."""
    charts: Sequence[Chart] = ()
    sketches: Sequence[Sketch] = field(default=())


def reached(yes: bool) -> str:
    """Return a goal's verdict as text."""
    return "reached" if yes else "not reached"
