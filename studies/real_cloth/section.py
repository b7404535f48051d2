"""Defines a section: the result of a test on real cloth, for docs/notes/real-cloth.md and for an HTML page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from tatamu.show.chart import Chart

Line = Mapping[str, str]
"""A line of a table: the text in each column, by the column's name."""


@dataclass(frozen=True)
class Tabulated:
    """A table in the result of a test on real cloth."""

    name: str
    """Name of the table in the JSON file, and in its marks in the docs."""
    lines: Sequence[Line]
    """Lines of the table, which all have the same columns."""


@dataclass(frozen=True)
class Sketch:
    """A drawing that is shown next to the tables of a test on real cloth."""

    title: str
    svg: str
    note: str = ""


@dataclass(frozen=True)
class Section:
    """The result of a test on real cloth: texts, tables, charts and drawings."""

    name: str
    """Name of the test on real cloth, which the option `--only` also uses."""
    title: str
    method: str
    """Description of the simulation and its assumptions, in a few sentences."""
    tables: Sequence[Tabulated]
    beat: str
    """Text with the best published number, and its source. The simulator's result is compared with this number."""
    goal: str
    """Text with the goal of the test, and whether it was reached."""
    silent: str
    """Text on the limits of the test, which tells what the test cannot show."""
    charts: Sequence[Chart] = ()
    sketches: Sequence[Sketch] = field(default=())


def reached(yes: bool) -> str:
    """Return the text "reached" or "not reached", which tells whether a goal was reached."""
    return "reached" if yes else "not reached"
