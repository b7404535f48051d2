"""Tables as data, which pages and the terminal show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tatamu.show.quantity import Quantity

if TYPE_CHECKING:
    from rich.table import Table as TerminalTable

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

    shown = TerminalTable(box=None, pad_edge=False)
    for place, name in enumerate(table.head):
        numbers = all(isinstance(row[place], Quantity) for row in table.rows)
        shown.add_column(name, justify="right" if numbers else "left", no_wrap=numbers)
    for row in table.rows:
        shown.add_row(*(Text(str(cell)) for cell in row))
    return shown
