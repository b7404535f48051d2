"""Defines a section: the result of a test on real cloth, for the notes and for the page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from tatamu.presentation.chart import Chart

Line = Mapping[str, str]
"""A line of a table: the text in each column, by the column's name."""


@dataclass(frozen=True)
class Tabulated:
    """A table of a section."""

    name: str
    """Name of the table in its marks in the docs, and in the JSON file."""
    lines: Sequence[Line]
    """Lines of the table, which all have the same columns."""


@dataclass(frozen=True)
class Sketch:
    """A drawing next to the tables."""

    title: str
    svg: str
    note: str = ""


@dataclass(frozen=True)
class Section:
    """The result of a test: texts, tables, charts and drawings."""

    name: str
    """Name of the test in the option `--only`."""
    title: str
    method: str
    """Description of the simulation and its assumptions, in a few sentences."""
    tables: Sequence[Tabulated]
    beat: str
    """Text with the best published number, and its source.

    The simulator's result is compared with this number.
    """
    goal: str
    """Text with the goal, and whether it was reached."""
    silent: str
    """Text on the limits of the test, which tells what the test cannot show."""
    charts: Sequence[Chart] = ()
    sketches: Sequence[Sketch] = field(default=())


def reached(yes: bool) -> str:
    """Return "reached" or "not reached", for the text on a goal."""
    return "reached" if yes else "not reached"
