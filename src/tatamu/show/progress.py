"""Shows how much of a long computation is done."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from time import monotonic
from typing import Protocol

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn
from rich.table import Column

PERCENT = 10
"""Part of the work between two lines, if there is no terminal [%]."""


class Report(Protocol):
    """Function that receives how much is done: the count, the total if it is known now, and a text for the moment."""

    def __call__(self, done: int, total: int | None = None, what: str = "") -> None:
        """Show how much is done."""
        ...


@contextmanager
def progress(title: str, total: int | None = None, unit: str = "", console: Console | None = None) -> Iterator[Report]:
    """Yield a function that shows progress with counts and the time left, on standard error.

    A terminal shows a bar. Otherwise there is one line at the start, and one for every `PERCENT` of the work.

    Args:
        title: What is done, such as "margins of towel".
        total: How many steps there are; None if they are not known, or given with the first report.
        unit: What is counted, such as "simulations".
        console: Console to show it on.
    """
    console = console or Console(stderr=True)
    work = _Work(total, unit)
    counts = TextColumn("{task.fields[work]}", markup=False, table_column=Column())
    columns = (TextColumn("{task.description}", markup=False), BarColumn(20), counts)
    printed = -1

    def report(done: int, total: int | None = None, what: str = "") -> None:
        nonlocal printed
        work.report(done, total)
        text = f"{title}: {what}" if what else title
        bar.update(line, completed=done, total=work.total, description=text)
        part = 100 * done // (PERCENT * work.total) if work.total else printed
        if not console.is_terminal and part > printed:
            printed = part
            console.print(f"{text}: {work}", soft_wrap=True, markup=False, highlight=False)

    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        line = bar.add_task(title, total=total, work=work)
        if not console.is_terminal:
            console.print(f"{title} ..", soft_wrap=True, markup=False, highlight=False)
        yield report


class _Work:
    """How much is done, and since when; as text, the counts and the time left."""

    def __init__(self, total: int | None, unit: str) -> None:
        self.total = total
        self._unit = f" {unit}" if unit else ""
        self._done = 0
        self._first: int | None = None
        self._began = monotonic()
        self._ends: float | None = None

    def report(self, done: int, total: int | None) -> None:
        self._done, self.total = done, self.total if total is None else total
        if self._first is None:  # a resumed computation reports what is there already
            self._first = done if done > 1 else 0
        made = done - self._first
        if made > 0 and self.total:
            now = monotonic()
            self._ends = now + (now - self._began) * (self.total - done) / made

    def __str__(self) -> str:
        if not self.total:
            return f"for {duration(monotonic() - self._began)}"
        text = f"{self._done} of {self.total}{self._unit}"
        if self._ends is None or self._done >= self.total:
            return text
        return f"{text}, about {duration(self._ends - monotonic())} left"


def duration(seconds: float) -> str:
    """Return a time [s] as text, such as "8 s", "1 min 10 s" or "2 h 5 min"."""
    whole = max(round(seconds), 1)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole % 3600 // 60} min"
