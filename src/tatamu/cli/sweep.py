"""The command `tatamu sweep`, which learns many folds that a file describes."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer
from rich.console import Console
from rich.live import Live

from tatamu.base.errors import InputError
from tatamu.cli.options import MAX_AT_A_TIME, SchedulerOption, StorageOption
from tatamu.cli.options import at_a_time as most_at_a_time
from tatamu.study.options import TaskRequest

if TYPE_CHECKING:
    from tatamu.study.database import SharedDatabase
    from tatamu.sweep import SweepTask, TaskRecord


def sweep(
    file: Path = typer.Argument(
        ..., metavar="SWEEP.toml", help="File that describes the tasks, as a grid or as a list."
    ),
    out: Path = typer.Option(
        ..., metavar="DIR", help="Folder of the sweep, with a result folder for each task and a comparison."
    ),
    at_a_time: int | None = typer.Option(
        None, help="Number of tasks that run at the same time; default: 1, or enough for all workers of --scheduler."
    ),
    scheduler: SchedulerOption = None,
    storage: StorageOption = None,
) -> int:
    """Learn many folds: a list of tasks, or a grid of garments, sizes, materials, seeds and other options.

    The exit code is 0 if every task is complete, and 1 if a task failed. The errors are in `sweep.json` and on the
    page.

    Examples:
    `tatamu sweep examples/sweep.toml --out runs/sweep`

    `tatamu sweep examples/sweep.toml --scheduler local:4 --out runs/sweep`

    `tatamu sweep examples/sweep.toml --scheduler tcp://lab:8786 --storage postgresql://lab@db/folds --out runs/sweep`

    To resume an interrupted sweep, run the same command again. Failed tasks are then tried again.
    """
    from tatamu.sweep.description import read_sweep
    from tatamu.sweep.table import check_parquet

    if at_a_time is not None and not 1 <= at_a_time <= MAX_AT_A_TIME:
        raise InputError(f"--at-a-time: must be from 1 to {MAX_AT_A_TIME}, given {at_a_time}")
    tasks = read_sweep(file, TaskRequest)
    check_parquet()
    _check(file, tasks)
    from tatamu.cluster import executor_at
    from tatamu.study.database import shared_database
    from tatamu.study.learn import usual_pending

    warnings.simplefilter("ignore")  # the reports contain the warnings of single folds
    with shared_database(storage) as database, executor_at(scheduler) as executor:
        # the smallest number of trials that a task runs at the same time, which may differ between tasks
        options = [TaskRequest(**task.options) for task in tasks]
        pending = min(each.parallel or usual_pending(each.simulator) for each in options)
        return _run(tasks, out, at_a_time or most_at_a_time(executor, pending), executor, database)


def _check(file: Path, tasks: Sequence[SweepTask]) -> None:
    """Raise an error if a task of a sweep is impossible. This is done before any task starts."""
    from tatamu.api import task_of
    from tatamu.simulation.simulators import require
    from tatamu.study.learn import check_pending

    made = set()
    for task in tasks:
        options = TaskRequest(**task.options)
        same = options.model_copy(update={"seed": 0, "trials": 1, "sampler": "gp", "parallel": None})
        try:
            if same.model_dump_json() not in made:
                made.add(same.model_dump_json())
                require(options.simulator)
                task_of(options)
            check_pending(options, options.simulator)
        except InputError as error:
            raise InputError(f"{file}: task {task.name}: {error}") from None


def _run(
    tasks: Sequence[SweepTask], out: Path, at_a_time: int, executor: Executor | None, database: SharedDatabase | None
) -> int:
    from tatamu.api import learn, task_of
    from tatamu.sweep import SweepFolder, run_sweep
    from tatamu.sweep.page import write_results
    from tatamu.sweep.table import counts

    folder = SweepFolder(out)
    console = Console()

    def learned(options: dict[str, Any], path: Path, progress: Callable[[Any], None]) -> None:
        request = TaskRequest(**options)
        learn(
            task_of(request),
            request.learning,
            out=path,
            executor=executor,
            database=database,
            progress=lambda now: progress(
                f"{f'step {now.step} of {now.steps}, ' if now.steps > 1 else ''}trial {now.done}/{now.trials}"
            ),
        )

    with _display(console, tasks) as show:
        records = run_sweep(tasks, folder, learned, at_a_time=at_a_time, show=show)
    page = write_results(folder, records)
    console.print(counts(records), soft_wrap=True)
    print(f"page: {page}")
    return 1 if any(record.state == "failed" for record in records) else 0


@contextmanager
def _display(console: Console, tasks: Sequence[SweepTask]) -> Iterator[Callable[[TaskRecord, Any], None]]:
    """Yield a callback that shows the progress of a sweep.

    On a terminal, the callback updates a table. Otherwise it prints a line for each task that ends.
    """
    from tatamu.sweep import TaskRecord
    from tatamu.sweep.table import LiveTable, said

    if not console.is_terminal:

        def print_line(record: TaskRecord, progress: Any) -> None:
            if record.state in ("complete", "failed"):
                console.print(f"{record.name}: {record.state}, {said(record)}", soft_wrap=True, markup=False)

        yield print_line
        return
    table = LiveTable([TaskRecord(name=task.name, options=task.options) for task in tasks])
    with Live(table, console=console, refresh_per_second=4):
        yield table.update
