"""The report on a terminal: one table for each check, and a line that counts."""

from __future__ import annotations

from rich.markup import escape
from rich.table import Table

from tests.physics.findings import Row
from tests.physics.report import CheckResult, Report

VERDICT = {True: "[green]pass[/]", False: "[bold red]FAIL[/]", None: "[dim]stated[/]"}


def number(value: float | None, digits: int = 5) -> str:
    """Return a number as text with a few significant digits; a dash for None."""
    if value is None:
        return "–"
    if value == 0:
        return "0"
    return f"{value:.{digits}g}" if 1e-3 <= abs(value) < 1e5 else f"{value:.{digits - 1}e}"


def cells(row: Row) -> list[str]:
    """Return quantity, reference, measured value, error, limit and unit of a row as text."""
    return [row.quantity, number(row.reference), number(row.got), number(row.error, 3), number(row.limit, 3), row.unit]


def table(result: CheckResult) -> Table:
    """Return the table with the results of a check. Each case has a heading in it."""
    out = Table(title=f"{result.check.title}: {result.check.reference}", title_justify="left", title_style="bold")
    out.add_column("quantity", ratio=1)
    for name in ("reference", "got", "error", "limit"):
        out.add_column(name, justify="right", no_wrap=True)
    out.add_column("pass", no_wrap=True)
    for case in result.cases:
        out.add_row(f"[cyan]{case.label}[/]")
        for place, row in enumerate(case.rows):
            quantity, reference, got, error, limit, unit = cells(row)
            unit = "" if unit == "-" or error == "0" else f" {unit}"
            last = place == len(case.rows) - 1
            out.add_row(
                f"  {escape(quantity)}", reference, got, error + unit, limit, VERDICT[row.passed], end_section=last
            )
            if row.passed is False and row.note:
                out.add_row(f"    [dim]{escape(row.note)}[/]")
    return out


def summary(report: Report) -> str:
    """Return a line with three numbers: rows with a limit, rows that failed, and rows without a limit."""
    stated = len(report.rows) - report.judged
    verdict = "[green]all pass[/]" if report.failures == 0 else f"[bold red]{report.failures} fail[/]"
    return f"{report.simulator}: {report.judged} judged, {verdict}; {stated} reported without a limit"
