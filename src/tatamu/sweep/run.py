"""Runs the tasks of a sweep."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from pathlib import Path
from threading import Event, RLock
from typing import Any

from tatamu.base.errors import TatamuError, UnavailableError
from tatamu.base.locks import lock_folder
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
        state = _Sweep(folder, [_begun(task, before, folder, trials) for task in tasks], show)
        state.write()
        state.run(learned, at_a_time)
        return state.records


def _begun(task: SweepTask, before: dict[str, TaskRecord], folder: SweepFolder, trials: int) -> TaskRecord:
    """Return a task's record at the start of this run: the earlier record if the task is complete, or a new record."""
    known = before.get(task.name)
    wanted = task.options.get("trials", trials)
    if known is not None and holds_task(known, folder.of_task(task.name), wanted):
        return known
    return TaskRecord(name=task.name, options=task.options)


@dataclass
class _Sweep:
    """A sweep whose tasks are being run."""

    folder: SweepFolder
    records: list[TaskRecord]
    show: Shown

    def __post_init__(self) -> None:
        self._lock = RLock()
        self._stop = Event()

    def run(self, learned: Learned, at_a_time: int) -> None:
        """Run all tasks that are not complete.

        Raises:
            UnavailableError: If a task raises this error. Then all tasks are stopped.
        """
        with ThreadPoolExecutor(at_a_time, thread_name_prefix="sweep") as pool:
            numbers = [k for k, record in enumerate(self.records) if record.state != "complete"]
            futures = [pool.submit(self._one, number, learned) for number in numbers]
            try:
                _first_error(futures)
            except BaseException:
                self._stop.set()
                pool.shutdown(wait=False, cancel_futures=True)
                raise

    def write(self) -> None:
        """Write `sweep.json`. A running task is written with the state "waiting"."""
        with self._lock:
            waiting = {"state": "waiting"}
            self.folder.write([r.model_copy(update=waiting) if r.state == "running" else r for r in self.records])

    def _one(self, number: int, learned: Learned) -> None:
        record = self.records[number]
        self._change(number, record.model_copy(update={"state": "running"}))
        path = self.folder.of_task(record.name)

        def progress(now: Any) -> None:
            if self._stop.is_set():
                raise _StoppedError
            self.show(self.records[number], now)

        try:
            progress(None)
            learned(record.options, path, progress)
            ended = completed(record, path)
        except (_StoppedError, UnavailableError):
            self._change(number, record)
            raise
        except Exception as error:
            if self._stop.is_set():
                self._change(number, record)
                raise
            ended = record.model_copy(update={"state": "failed", "error": _said(error)})
        self._change(number, ended)
        self.write()

    def _change(self, number: int, record: TaskRecord) -> None:
        with self._lock:
            self.records[number] = record
        self.show(record, None)


def _first_error(futures: Sequence[Future[None]]) -> None:
    """Wait for all futures. If a future ends with an error, raise this error at once."""
    waiting = set(futures)
    while waiting:
        ended, waiting = wait(waiting, return_when="FIRST_COMPLETED")
        for future in futures:  # in the order of tasks, because several may have ended
            if future in ended:
                future.result()


def _said(error: Exception) -> str:
    """Return the message of an error in one line."""
    words = " ".join(str(error).split())
    return words if isinstance(error, TatamuError) else f"{type(error).__name__}: {words}"
