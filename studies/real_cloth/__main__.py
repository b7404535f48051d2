"""Predicts measurements of real cloth with a simulator, and makes the tables of docs/notes/real-cloth.md.

    python -m studies.real_cloth --data DATA --out runs/real-cloth              # every test
    python -m studies.real_cloth --data DATA --only drape --only motion         # some tests
    python -m studies.real_cloth --data DATA --only drape --quick               # one repeat of each drape
    python -m studies.real_cloth --data DATA --scheduler local:4                # in four processes, same results

DATA is the folder with the measurements that docs/guide/studies.md lists.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from benchmarks.tables import publish
from rich.console import Console
from rich.progress import Progress

from studies.real_cloth import notes
from studies.real_cloth.bench import Bench
from studies.real_cloth.page import page
from studies.real_cloth.section import Section
from studies.real_cloth.study import load, run, simulations
from tatamu.base.files import write_json, write_text
from tatamu.cli.options import SchedulerOption
from tatamu.cli.program import run as run_program
from tatamu.cluster import executor_at
from tatamu.simulation.simulators import require

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)


@app.command()
def predict(
    data: Annotated[Path, typer.Option(help="Folder with measurements of real cloth.")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Where real-cloth.md, .json and .html go.")] = Path(
        "runs/real-cloth"
    ),
    only: Annotated[list[str] | None, typer.Option(metavar="TEST", help="Only this test; may be repeated.")] = None,
    simulator: Annotated[str, typer.Option(help="native, blender or mujoco.")] = "native",
    quick: Annotated[bool, typer.Option("--quick", help="One repeat of each drape instead of three.")] = False,
    scheduler: SchedulerOption = None,
    write_docs: Annotated[bool, typer.Option("--write-docs", help="Write the tables into the notes, too.")] = False,
) -> None:
    """Predict published measurements of real cloth.

    The exit code does not depend on the predictions. It is 0, or 2 if a file is missing or wrong. Values that were read
    from finished simulations are kept in DIR/kept. To resume an interrupted run, run the same command again.
    """
    require(simulator)
    tests = load(data, only or [])
    screen = Console(highlight=False)
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
    save(sections, simulator, out)
    screen.print(f"{out / 'real-cloth.html'}")
    if write_docs:
        for section in sections:
            publish(f"real: {section.name}", notes.text(section, tables=1))


def save(sections: list[Section], simulator: str, out: Path) -> None:
    """Write the results of all tests as `real-cloth.json`, `real-cloth.md` and `real-cloth.html`."""
    write_json(out / "real-cloth.json", notes.data(sections, simulator))
    write_text(out / "real-cloth.md", notes.page(sections, simulator))
    write_text(out / "real-cloth.html", page(sections, simulator))


if __name__ == "__main__":
    run_program(app, "real_cloth")
