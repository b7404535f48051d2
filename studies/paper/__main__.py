"""Repeats section VI of the paper that tatamu's method comes from, as docs/guide/reproduction.md explains.

    python -m studies.paper --garments towel --seeds 1 --out runs/paper
    python -m studies.paper --simulator native --out runs/paper-native

The first command runs a single study of the towel. The second command uses the simulator `native`.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
from rich.progress import Progress as Bar

from studies.paper.experiment import Choices, run
from studies.paper.page import save
from tatamu.base.errors import InputError
from tatamu.base.size import parse_size
from tatamu.cli.options import SchedulerOption, at_a_time
from tatamu.cli.program import run as run_program
from tatamu.cli.progress import prepare
from tatamu.cluster import executor_at
from tatamu.simulation.simulators import require
from tatamu.study.loop import Progress

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)


@app.command()
def reproduce(
    out: Annotated[
        Path, typer.Option(metavar="DIR", help="Where studies and page go; unfinished studies are resumed.")
    ],
    simulator: Annotated[str, typer.Option(help="blender, the paper's, or another.")] = "blender",
    garments: Annotated[str, typer.Option(metavar="NAME,..", help="Which garments.")] = "towel,tshirt,trousers",
    seeds: Annotated[int, typer.Option(help="Studies of each garment.")] = 5,
    trials: Annotated[int, typer.Option(help="Trials of each study.")] = 50,
    size: Annotated[
        list[str] | None, typer.Option(metavar="GARMENT=WxL", help="Width x length in metres; may be repeated.")
    ] = None,
    spacing: Annotated[
        list[str] | None, typer.Option(metavar="GARMENT=M", help="Mesh spacing in metres; default: 0.02.")
    ] = None,
    fold: Annotated[
        list[str] | None, typer.Option(metavar="GARMENT=FOLD", help="Default: half; leg over leg for trousers.")
    ] = None,
    material: Annotated[
        list[str] | None, typer.Option(metavar="GARMENT=MATERIAL", help="Preset or file; default: the paper's numbers.")
    ] = None,
    scheduler: SchedulerOption = None,
) -> None:
    """Repeat section VI of the paper that tatamu's method comes from, and compare its claims with the results.

    To resume an interrupted run, run the same command again.
    """
    choices = Choices(
        simulator=simulator,
        garments=tuple(name.strip() for name in garments.split(",") if name.strip()),
        seeds=seeds,
        trials=trials,
        sizes={name: parse_size(value) for name, value in _pairs("--size", size).items()},
        spacings={name: _metres(value) for name, value in _pairs("--spacing", spacing).items()},
        folds=_pairs("--fold", fold),
        materials=_pairs("--material", material),
    )
    require(simulator)
    if scheduler is None:
        prepare(simulator)
    console = Console()
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    done: dict[tuple[str, int], int] = {}
    with executor_at(scheduler) as executor, Bar(*columns, console=console, transient=True) as bar:
        line = bar.add_task("", total=len(choices.garments) * seeds * trials)

        def show_progress(garment: str, seed: int, now: Progress) -> None:
            done[garment, seed] = now.done
            bar.update(line, description=f"{garment}, seed {seed}", completed=sum(done.values()))
            if not console.is_terminal and now.done in (0, trials):
                console.print(f"{garment}, seed {seed}: {now.done}/{trials} trials")

        studies = run(choices, out, show_progress, executor, at_a_time(executor, pending=1))
    print(f"page: {save(choices, studies, out)}")


def _pairs(option: str, given: list[str] | None) -> dict[str, str]:
    """Read command line options of the form GARMENT=VALUE, and return the values by garment."""
    pairs = [text.partition("=") for text in given or []]
    for name, sign, value in pairs:
        if not (name and sign and value):
            raise InputError(f"{option}: must be GARMENT=VALUE, such as towel=.., given {name + sign + value!r}")
    return {name: value for name, _, value in pairs}


def _metres(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError(f"--spacing: must be GARMENT=METRES, such as towel=0.02, given {text!r}") from None


if __name__ == "__main__":
    run_program(app, "paper")
