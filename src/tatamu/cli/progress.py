"""Progress of a study on the terminal."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
from rich.progress import Progress as Bar

from tatamu.folding.task import Task

if TYPE_CHECKING:
    from tatamu.learning import Progress

EVERY = 10
"""Trials per printed line where there is no terminal."""


@contextmanager
def reporting(task: Task, trials: int) -> Iterator[Callable[[Progress], None]]:
    """A callback that draws a progress bar, or prints a line every few trials where there is no terminal."""
    console = Console()
    garment = task.fold.garment
    number, count = task.step
    if number == 1:
        console.print(
            f"{garment.name} {garment.size[0]:g} x {garment.size[1]:g} m, {len(garment.vertices)} vertices, "
            f"fold {task.fold_name}, simulator {task.simulator}. The first run compiles it: about a minute.",
            soft_wrap=True,
            markup=False,
        )
    if count > 1:
        console.print(f"step {number} of {count}{': ' if task.title else ''}{task.title}", soft_wrap=True, markup=False)
    if not console.is_terminal:
        yield lambda p: _line(console, p)
        return
    columns = (
        TextColumn("trial"),
        MofNCompleteColumn(),
        BarColumn(),
        TextColumn("{task.fields[best]}"),
        TimeRemainingColumn(elapsed_when_finished=True),
    )
    with Bar(*columns, console=console) as bar:
        line = bar.add_task("trials", total=trials, best="")

        def update(progress: Progress) -> None:
            bar.update(line, completed=progress.done, best=_best(progress))

        yield update


def _line(console: Console, progress: Progress) -> None:
    if progress.done and (progress.done % EVERY == 0 or progress.done == progress.trials):
        console.print(f"trial {progress.done}/{progress.trials}: {_best(progress)}")


def _best(progress: Progress) -> str:
    if progress.best is None or progress.best_distance is None:
        return "no fold yet" if progress.done else "preparing"
    return f"best C = {progress.best:.4f}, {1000 * progress.best_distance:.1f} mm from the target"
