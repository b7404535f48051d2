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

from tatamu.folding.coarser import as_on_finer_mesh, on_coarser_mesh
from tatamu.folding.manipulation import Manipulation
from tatamu.folding.task import Outcome, Task
from tatamu.results.result import Parameters
from tatamu.simulators.many import processors


@dataclass(frozen=True)
class Evaluation:
    """The outcome of a trial, and the time that it took."""

    outcome: Outcome
    seconds: float


def evaluate(task: Task, manipulation: Manipulation) -> Evaluation:
    """Simulate and score one manipulation; the same to the last bit wherever it runs, but for the time."""
    started = perf_counter()
    outcome = task.evaluate(manipulation)
    return Evaluation(outcome, perf_counter() - started)


@dataclass(frozen=True)
class Pending:
    """A trial that is being evaluated."""

    task: Task
    manipulation: Manipulation
    coarse: Manipulation | None
    """The manipulation on the task's coarser mesh, where it runs there."""
    evaluation: Future[Evaluation]

    @property
    def ended(self) -> Evaluation:
        """What came out, waited for; in the numbers of the task's own mesh."""
        ended = self.evaluation.result()
        if self.coarse is None:
            return ended
        return replace(ended, outcome=as_on_finer_mesh(self.task, self.manipulation, self.coarse, ended.outcome))


def submitted(
    executor: Executor, task: Task, manipulation: Manipulation, on_coarser: Parameters | None = None
) -> Pending:
    """Hand a trial to an executor; one that the task's robot cannot do has ended at once.

    Args:
        executor: Where it runs.
        task: The fold.
        manipulation: What the hands do.
        on_coarser: The parameters of the manipulation, if it is to run on the task's coarser mesh.
    """
    refused = task.refused(manipulation)
    if refused is not None:
        ended: Future[Evaluation] = Future()
        ended.set_result(Evaluation(refused, 0.0))
        return Pending(task, manipulation, None, ended)
    if task.coarser is None or on_coarser is None:
        return Pending(task, manipulation, None, executor.submit(evaluate, _alone(task), manipulation))
    coarse = on_coarser_mesh(task, manipulation, on_coarser)
    return Pending(task, manipulation, coarse, executor.submit(evaluate, _alone(task.coarser), coarse))


def _alone(task: Task) -> Task:
    """The task without what an evaluation has no use for."""
    return replace(task, reach=None, coarser=None)


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
