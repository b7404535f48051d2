"""The evaluation of a trial: a pure function of arguments that can be pickled, which any executor may run anywhere.

What a robot cannot do is not among it: a reach may learn from what it is asked, so it is asked in the order of the
trials, before a trial is handed to the executor.
"""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from tatamu.errors import WorkerKilledError
from tatamu.folding.manipulation import Manipulation
from tatamu.folding.task import Outcome, Task
from tatamu.simulators.many import processors


@dataclass(frozen=True)
class Evaluation:
    """The outcome of a trial, and the time that it took."""

    outcome: Outcome
    seconds: float


def evaluate(task: Task, manipulation: Manipulation, below: float = np.inf) -> Evaluation:
    """Simulate and score one manipulation; the same to the last bit wherever it runs, but for the time.

    Args:
        task: What is folded.
        manipulation: How.
        below: The rollout comes with the outcome where the objective is less than this: others are not kept, and would
            only be carried from machine to machine.
    """
    started = perf_counter()
    outcome = task.evaluate(manipulation)
    if not outcome.objective < below:
        outcome = replace(outcome, rollout=None)
    return Evaluation(outcome, perf_counter() - started)


def submitted(executor: Executor, task: Task, manipulation: Manipulation, below: float = np.inf) -> Future[Evaluation]:
    """Hand a trial to an executor; one that the task's robot cannot do has ended at once."""
    refused = task.refused(manipulation)
    if refused is None:
        plain = task if task.reach is None else replace(task, reach=None)
        return executor.submit(evaluate, plain, manipulation, below)
    at_once: Future[Evaluation] = Future()
    at_once.set_result(Evaluation(refused, 0.0))
    return at_once


def ended(task: Task, manipulation: Manipulation, future: Future[Evaluation], which: str) -> Evaluation:
    """Wait for a trial; one that ended the processes it ran in has failed.

    Args:
        task: What is folded.
        manipulation: How.
        future: Of the trial.
        which: Its seed and number, for the error.
    """
    try:
        return future.result()
    except WorkerKilledError as error:
        penalty = task.penalty(manipulation.trajectory_length)
        return Evaluation(Outcome(None, penalty, f"{error} ({which})", None), 0.0)


@contextmanager
def executor_of(given: Executor | None, pending: int) -> Iterator[Executor]:
    """The executor given, or threads: as many as there are processors, and no more than pending trials."""
    if given is not None:
        yield given
        return
    with ThreadPoolExecutor(min(pending, processors())) as pool:
        try:
            yield pool
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
