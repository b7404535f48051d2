"""`tatamu validate`: textbook checks of a simulator, or its predictions of real cloth; tables and a page."""

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
        Path | None,
        typer.Option(metavar="DIR", help="Where validation.json and validation.html go; with --real, real-cloth.*."),
    ] = None,
    only: Annotated[list[str] | None, typer.Option(metavar="CHECK", help="Only this check; may be repeated.")] = None,
    real: Annotated[
        Path | None, typer.Option(metavar="DATA", help="Predict measurements of real cloth from this folder instead.")
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Leave out long cases: under a minute.")] = False,
    scheduler: SchedulerOption = None,
) -> None:
    """Compare a simulator with what is known of cloth.

    Exits with 0 if every judged quantity is within its limit, with 1 if not; with --real always with 0: goals are
    stated. What --real has simulated is kept in --out (runs/real-cloth if not given): a run that was stopped goes on.

    Example: `tatamu validate --only hang --only cantilever --out runs/validation`

    Example: `tatamu validate --real ~/realcloth --only drape --out runs/real-cloth`
    """
    from tatamu.cli.progress import prepare
    from tatamu.simulators import require

    require(simulator)
    if real is not None:
        _real(real, simulator, out or Path("runs/real-cloth"), only or [], quick, scheduler)
        return
    from tatamu.cluster import executor_at
    from tatamu.files import write_json, write_text
    from tatamu.validation import Subject
    from tatamu.validation import validate as run
    from tatamu.validation.report import chosen
    from tatamu.validation.terminal import console, display, summary

    if scheduler is None:
        prepare(simulator)
    subject, names = Subject.named(simulator), only or []
    total = sum(len(cases) for _, cases in chosen(names, quick))
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


def _real(data: Path, simulator: str, out: Path, only: list[str], quick: bool, scheduler: str | None) -> None:
    from rich.progress import Progress

    from tatamu.cluster import executor_at
    from tatamu.files import write_json, write_text
    from tatamu.simulators import named
    from tatamu.validation.real import notes
    from tatamu.validation.real.bench import Bench
    from tatamu.validation.real.page import page
    from tatamu.validation.real.study import load, run, simulations
    from tatamu.validation.terminal import console

    named(simulator)
    tests = load(data, only)
    screen = console()
    with executor_at(scheduler) as executor, Progress(console=screen, transient=True) as progress:
        bar = progress.add_task("")
        bench = Bench(
            simulator,
            out / "kept",
            seeds=1 if quick else 3,
            executor=executor,
            tick=lambda label: progress.update(bar, description=label, advance=1),
        )
        progress.update(bar, total=simulations(tests, bench))
        sections = run(tests, bench, lambda section: screen.print(f"{section.title}: {section.goal}", soft_wrap=True))
    write_json(out / "real-cloth.json", notes.data(sections, simulator))
    write_text(out / "real-cloth.md", notes.page(sections, simulator))
    write_text(out / "real-cloth.html", page(sections, simulator))
    screen.print(f"{out / 'real-cloth.html'}")
