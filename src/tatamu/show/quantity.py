"""Values with their units and limits, and tables of them, as pages and the terminal show them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.table import Table as TerminalTable

UNITS = {
    "mm": (1e3, "m"),
    "cm": (1e2, "m"),
    "µm": (1e6, "m"),
    "g": (1e3, "kg"),
    "ms": (1e3, "s"),
    "°": (180.0 / pi, "rad"),
    "mrad": (1e3, "rad"),
    "g/m²": (1e3, "kg/m²"),
    "µN m": (1e6, "N m"),
    "mN": (1e3, "N"),
}
"""Units for readers, each with its factor and the unit in files; any other unit is the same in files."""
READERS = {"m": "mm", "kg": "g", "rad": "°", "-": "", "1": ""}
"""Usual units for readers, by the units in files."""
NOTHING = "–"
"""What stands in place of a value that is missing."""


def factor(unit: str) -> float:
    """Return the factor that converts a value in files to a unit for readers."""
    return UNITS[unit][0] if unit in UNITS else 1.0


def usual(unit: str) -> str:
    """Return the usual unit for readers of a unit in files."""
    return READERS.get(unit, unit)


def filed(unit: str) -> str:
    """Return the unit in files of a unit for readers."""
    return UNITS[unit][1] if unit in UNITS else unit


def number(value: float | None, unit: str = "", form: str = ".4g") -> str:
    """Return a value in a unit for readers as text, without the unit; a dash if it is None."""
    if value is None:
        return NOTHING
    text = f"{factor(unit) * value:{form}}"
    return f"−{text[1:]}" if text.startswith("-") else text


def shown(value: float | None, unit: str, form: str = ".4g") -> str:
    """Return a value with a unit for readers as text, such as "12.5 mm" or "3°"."""
    space = "" if unit in ("°", "") else " "
    return number(value, unit, form) + (f"{space}{unit}" if value is not None else "")


@dataclass(frozen=True)
class Quantity:
    """A value with its name, its unit for readers and its limits; values are in the units of files."""

    name: str
    value: float | None
    unit: str = ""
    form: str = ".4g"
    """How the number is written, as a format of Python."""
    minimum: float | None = None
    maximum: float | None = None

    @property
    def number(self) -> str:
        """The value without its unit."""
        return number(self.value, self.unit, self.form)

    @property
    def limit(self) -> str:
        """The limits in words, such as "at most 20"; empty if there are none."""
        bounds = (("at least", self.minimum), ("at most", self.maximum))
        return ", ".join(f"{words} {number(end, self.unit)}" for words, end in bounds if end is not None)

    @property
    def passes(self) -> bool | None:
        """Whether the value is within its limits; None if it has no limits or is missing."""
        if self.value is None or (self.minimum is None and self.maximum is None):
            return None
        return (self.minimum is None or self.value >= self.minimum) and (
            self.maximum is None or self.value <= self.maximum
        )

    def __str__(self) -> str:
        return shown(self.value, self.unit, self.form)


Cell = str | Quantity


@dataclass(frozen=True)
class Table:
    """Rows under a head. The macro `parts.rows` shows it on a page, `terminal` on the console."""

    head: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    """The first cell of a row is its name."""

    def __bool__(self) -> bool:
        return bool(self.rows)


def terminal(table: Table) -> TerminalTable:
    """Return a table for the console: names and words to the left, quantities to the right."""
    from rich.table import Table as TerminalTable
    from rich.text import Text

    made = TerminalTable(box=None, pad_edge=False)
    for place, name in enumerate(table.head):
        numbers = all(isinstance(row[place], Quantity) for row in table.rows)
        made.add_column(name, justify="right" if numbers else "left", no_wrap=numbers)
    for row in table.rows:
        made.add_row(*(Text(str(cell)) for cell in row))
    return made
