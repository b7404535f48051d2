"""The commands `tatamu dataset`, which records folds for robot policies, and `tatamu replay`, which repeats a fold."""

from __future__ import annotations

import multiprocessing
import os
import threading
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path

import typer

from tatamu.base.errors import InputError
from tatamu.cli.options import MAX_AT_A_TIME, SchedulerOption


def dataset(
    specification: Path = typer.Argument(
        ..., metavar="SPEC.toml", help="File that describes the folds and the recording."
    ),
    out: Path = typer.Option(..., metavar="DIR", help="Folder of the dataset."),
    workers: int | None = typer.Option(
        None, help="Number of processes that record on this machine; default: one for each processor."
    ),
    scheduler: SchedulerOption = None,
) -> None:
    """Record folds as demonstrations for robot policies, in LeRobotDataset v3.0 and Zarr, with the score of each fold.

    Examples:
    `tatamu dataset examples/dataset.toml --out runs/folds`

    `tatamu dataset examples/dataset.toml --workers 1 --out runs/folds`

    `tatamu dataset examples/dataset.toml --scheduler tcp://lab:8786 --out runs/folds`

    The dataset does not depend on the number of workers. To resume an interrupted command, run the same command again.
    """
    from tatamu.cli.progress import prepare, resumable
    from tatamu.cluster import executor_at
    from tatamu.policies.dataset import DatasetFolder, make_dataset, read_specification
    from tatamu.show.progress import progress
    from tatamu.simulation.side_by_side import processors

    if workers is not None and not 1 <= workers <= MAX_AT_A_TIME:
        raise InputError(f"--workers: must be from 1 to {MAX_AT_A_TIME}, given {workers}")
    if workers is not None and scheduler is not None:
        raise InputError("--workers: must be left out with --scheduler, which has its own workers")
    wanted = read_specification(specification)
    if scheduler is None and not DatasetFolder(out).is_finished:
        prepare("native")
    count = min(workers or processors(), wanted.episodes)
    with ExitStack() as stack:
        executor = stack.enter_context(executor_at(scheduler))
        if executor is None:
            executor = _processes(count)
            stack.callback(executor.shutdown, wait=False, cancel_futures=True)
        with resumable(f"finished episodes are kept in {out}"), progress(out.name, unit="episodes") as report:
            found = make_dataset(wanted, out, executor=executor, progress=report)
    about = found.read()
    print(f"{about.successes} of {about.episodes} episodes succeed; the dataset has {about.frames} frames")
    print(f"dataset: {found.page}")


def replay(
    folder: Path = typer.Argument(..., metavar="DATASET", help="Folder of a dataset."),
    episode: int = typer.Argument(..., metavar="EPISODE", help="Index of the episode, from 0."),
) -> None:
    """Run the actions of an episode in the simulator again, and print how much the result differs.

    Example: `tatamu replay runs/folds 7`
    """
    from tatamu.cli.progress import prepare
    from tatamu.policies.dataset import DatasetFolder
    from tatamu.policies.dataset import replay as again
    from tatamu.policies.dataset.record import read_outcome

    DatasetFolder(folder).read()
    read_outcome(DatasetFolder(folder).table, episode)  # wrong arguments are refused before the simulator is compiled
    prepare("native")
    found = again(folder, episode)
    before = found.recorded.score
    was = "failed" if before is None else f"{1e3 * before.mean_vertex_distance:.2f} mm"
    print(f"mean distance from the target: {1e3 * found.score.mean_vertex_distance:.2f} mm now, {was} when recorded")
    yes = {True: "yes", False: "no"}
    print(f"success: {yes[found.success]} now, {yes[found.recorded.success]} when recorded")
    mean, largest = 1e3 * found.distances.mean(), 1e3 * found.distances.max()
    print(f"vertices differ from the recording by {mean:.3g} mm on average and by at most {largest:.3g} mm")


def _processes(count: int) -> Executor:
    """Return an executor with `count` worker processes on this machine. If `count` is 1, it has a single thread.

    The processes end when this process ends.
    """
    spawn = multiprocessing.get_context("spawn")
    return ProcessPoolExecutor(count, spawn, _end_with_parent) if count > 1 else ThreadPoolExecutor(1)


def _end_with_parent() -> None:
    """Arrange that this process ends when its parent process ends, even if the parent is killed."""
    parent = multiprocessing.parent_process()
    assert parent is not None

    def watch() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
