"""Runs the tasks of a sweep."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from threading import Event, Lock
from typing import Any

from tatamu.base.errors import TatamuError, UnavailableError
from tatamu.base.files import lock_folder
from tatamu.sweep.description import SweepTask
from tatamu.sweep.records import SweepFolder, TaskRecord, completed, holds_task

Learned = Callable[[dict[str, Any], Path, Callable[[Any], None]], None]
"""Learns a task with the given options, in a folder, and reports progress."""
Shown = Callable[[TaskRecord, Any], None]
"""Shows the record of a task, and the progress of its trials or None."""


class _StoppedError(Exception):
    """Raised in a running task if the whole sweep has to stop."""


def run_sweep(
    tasks: Sequence[SweepTask],
    folder: SweepFolder,
    learned: Learned,
    *,
    trials: int = 50,
    at_a_time: int = 1,
    show: Shown = lambda record, progress: None,
) -> list[TaskRecord]:
    """Learn every task of a sweep, or resume an earlier run of the sweep.

    If a task fails, its error is recorded and the other tasks continue. The next run tries the failed task again.

    Args:
        tasks: The tasks to learn.
        folder: Folder of the sweep, which is created if it does not exist.
        learned: Function that learns one task.
        trials: Number of trials of a task that does not have the option `trials`.
        at_a_time: Number of tasks that run at the same time, in threads.
        show: Callback that draws the progress.

    Returns:
        Records of all tasks, in the order of `tasks`.

    Raises:
        InputError: If the folder cannot be used.
        UnavailableError: If a scheduler, a database or a disk does not answer. Finished work is kept.
    """
    with lock_folder(folder.path, ".sweep-lock", "another sweep is running here"):
        before = {record.name: record for record in folder.read()}
        records = {task.name: _begun(task, before, folder, trials) for task in tasks}
        folder.write(list(records.values()))
        lock, stopped = Lock(), Event()

        def keep(record: TaskRecord) -> None:
            with lock:
                records[record.name] = record
                folder.write(list(records.values()))
            show(record, None)

        def run(task: TaskRecord) -> None:
            running = task.model_copy(update={"state": "running"})

            def progress(now: Any) -> None:
                if stopped.is_set():
                    raise _StoppedError
                show(running, now)

            try:
                progress(None)
                learned(task.options, folder.of_task(task.name), progress)
                ended = completed(task, folder.of_task(task.name))
            except (_StoppedError, UnavailableError):
                raise
            except Exception as error:
                if stopped.is_set():
                    raise
                ended = task.model_copy(update={"state": "failed", "error": _said(error)})
            keep(ended)

        with ThreadPoolExecutor(at_a_time, thread_name_prefix="sweep") as pool:
            begun = [pool.submit(run, record) for record in records.values() if record.state != "complete"]
            try:
                for future in as_completed(begun):
                    future.result()
            except BaseException:
                stopped.set()
                pool.shutdown(wait=False, cancel_futures=True)
                raise
        return list(records.values())


def _begun(task: SweepTask, before: dict[str, TaskRecord], folder: SweepFolder, trials: int) -> TaskRecord:
    """Return a task's record at the start of this run: the earlier record if the task is complete, or a new record."""
    known = before.get(task.name)
    wanted = task.options.get("trials", trials)
    if known is not None and holds_task(known, folder.of_task(task.name), wanted):
        return known
    return TaskRecord(name=task.name, options=task.options)


def _said(error: Exception) -> str:
    """Return the message of an error in one line."""
    words = " ".join(str(error).split())
    return words if isinstance(error, TatamuError) else f"{type(error).__name__}: {words}"
