"""Compares a simulator with textbook results, as docs/guide/validation.md explains."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from tatamu.base.files import write_json, write_text
from tatamu.cli.program import run
from tatamu.simulation.simulators import require
from tests.physics import Subject, notes, validate
from tests.physics.page import page
from tests.physics.terminal import summary, table

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)


@app.command()
def main(
    simulator: Annotated[str, typer.Option(help="native, blender or mujoco.")] = "native",
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="Folder for validation.json and .html.")] = None,
    only: Annotated[list[str] | None, typer.Option(metavar="CHECK", help="Only this check; may be repeated.")] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Leave out long cases; takes less than a minute.")] = False,
    write_docs: Annotated[bool, typer.Option("--write-docs", help="Write table and picture into the notes.")] = False,
) -> None:
    """Compare a simulator with textbook results for cloth.

    The exit code is 0 if every quantity that has a limit is within this limit, otherwise 1.
    """
    require(simulator)
    screen = Console(highlight=False)
    report = validate(Subject.named(simulator), only or [], quick, lambda result: screen.print(table(result)))
    screen.print(summary(report))
    if out is not None:
        write_json(out / "validation.json", report.to_json())
        write_text(out / "validation.html", page(report))
        screen.print(f"{out / 'validation.html'}")
    if write_docs:
        notes.write(report)
    raise typer.Exit(1 if report.failures else 0)


if __name__ == "__main__":
    run(app, "physics")
