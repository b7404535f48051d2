"""The command `tatamu validate`, which compares a simulator with textbook results, in tables and on a page."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tatamu.cli.app import app
from tatamu.cli.cluster import SchedulerOption


@app.command()
def validate(
    simulator: Annotated[str, typer.Option(help="native, blender or mujoco.")] = "native",
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder for validation.json and validation.html.")
    ] = None,
    only: Annotated[list[str] | None, typer.Option(metavar="CHECK", help="Only this check; may be repeated.")] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Leave out long cases; takes less than a minute.")] = False,
    scheduler: SchedulerOption = None,
) -> None:
    """Compare a simulator with textbook results for cloth.

    The exit code is 0 if every quantity that has a limit is within this limit, otherwise 1.

    Example: `tatamu validate --only hang --only cantilever --out runs/validation`
    """
    from tatamu.base.files import write_json, write_text
    from tatamu.cli.progress import prepare
    from tatamu.cluster import executor_at
    from tatamu.simulation.simulators import require
    from tatamu.validation import Subject
    from tatamu.validation import validate as run
    from tatamu.validation.report import select_cases
    from tatamu.validation.terminal import console, display, summary

    require(simulator)
    if scheduler is None:
        prepare(simulator)
    subject, names = Subject.named(simulator), only or []
    total = sum(len(cases) for _, cases in select_cases(names, quick))
    screen = console()
    with executor_at(scheduler) as executor, display(screen, total) as shown:
        report = run(subject, names, quick, shown.before, shown.after, executor)
    screen.print(summary(report))
    if out is not None:
        from tatamu.validation.page import page

        write_json(out / "validation.json", report.to_json())
        write_text(out / "validation.html", page(report))
        screen.print(f"{out / 'validation.html'}")
    raise typer.Exit(1 if report.failures else 0)
