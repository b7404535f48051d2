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

from tatamu.folding.coarser import as_on_finer_mesh, larger_on_finer_mesh, on_coarser_mesh
from tatamu.folding.manipulation import Manipulation
from tatamu.folding.task import Outcome, Task
from tatamu.learning.expectation import Demand, Expected, Standing, expected
from tatamu.results.result import Parameters
from tatamu.simulators.many import processors


@dataclass(frozen=True)
class Evaluation:
    """The outcome of a trial, and the time that it took."""

    outcome: Outcome
    """Where nothing is off."""
    seconds: float
    expected: Expected | None = None
    """Over worlds in which something is off; None: nobody asked."""


@dataclass(frozen=True)
class Surrogate:
    """A manipulation on a coarser mesh that says what disturbances add to the objective on the finer one."""

    task: Task
    manipulation: Manipulation
    larger: float
    """D on the finer mesh over D on this one."""


def evaluate(
    task: Task, manipulation: Manipulation, demand: Demand | None = None, model: Surrogate | None = None
) -> Evaluation:
    """Simulate and score one manipulation; the same to the last bit wherever it runs, but for the time.

    Args:
        task: The fold.
        manipulation: What the hands do.
        demand: Worlds in which it is simulated too; None: in none.
        model: The same on a coarser mesh, where those worlds are simulated; None: on the task's own.
    """
    started = perf_counter()
    outcome = task.evaluate(manipulation)
    found = None if demand is None else _expected(task, manipulation, outcome, demand, model)
    return Evaluation(outcome, perf_counter() - started, found)


def _expected(
    task: Task, manipulation: Manipulation, outcome: Outcome, demand: Demand, model: Surrogate | None
) -> Expected:
    """The expected objective: on a coarser mesh, disturbances add to the objective what they add on the task's own."""
    own = outcome.objective
    standing = demand.standing
    if model is None or outcome.failed or (standing and own >= standing.expected):
        return expected(task, manipulation, outcome, demand)
    calm = model.task.evaluate(model.manipulation)
    if calm.failed:
        return expected(task, manipulation, outcome, demand)
    there = None
    if standing is not None:
        there = Standing(calm.objective + (standing.expected - own) / model.larger, standing.gap / model.larger)
    found = expected(model.task, model.manipulation, calm, replace(demand, standing=there))
    return replace(found, objective=own + model.larger * (found.objective - calm.objective))


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
        """The evaluation once it has ended, in the numbers of the task's own mesh."""
        ended = self.evaluation.result()
        if self.coarse is None:
            return ended
        outcome = as_on_finer_mesh(self.task, self.manipulation, self.coarse, ended.outcome)
        found = ended.expected
        if found is not None:
            added = larger_on_finer_mesh(self.task) * (found.objective - ended.outcome.objective)
            found = replace(found, objective=outcome.objective + added)
        return replace(ended, outcome=outcome, expected=found)


def submitted(
    executor: Executor,
    task: Task,
    manipulation: Manipulation,
    parameters: Parameters | None = None,
    *,
    coarse: bool = False,
    demand: Demand | None = None,
) -> Pending:
    """Hand a trial to an executor; one that the task's robot cannot do has ended at once.

    Args:
        executor: Where it runs.
        task: The fold.
        manipulation: What the hands do.
        parameters: Of the manipulation; None: it has none, and runs on the task's own mesh alone.
        coarse: Whether it is to run on the task's coarser mesh.
        demand: Worlds in which it is simulated too; where the task has a coarser mesh, there.
    """
    refused = task.refused(manipulation)
    if refused is not None:
        ended: Future[Evaluation] = Future()
        ended.set_result(Evaluation(refused, 0.0, None if demand is None else Expected(refused.objective, 0)))
        return Pending(task, manipulation, None, ended)
    if task.coarser is None or parameters is None:
        return Pending(task, manipulation, None, executor.submit(evaluate, _alone(task), manipulation, demand))
    there = on_coarser_mesh(task, manipulation, parameters)
    coarser = _alone(task.coarser)
    if coarse:
        meant = _on_coarser_mesh(task, manipulation, there, demand)
        return Pending(task, manipulation, there, executor.submit(evaluate, coarser, there, meant))
    model = None if demand is None else Surrogate(coarser, there, larger_on_finer_mesh(task))
    return Pending(task, manipulation, None, executor.submit(evaluate, _alone(task), manipulation, demand, model))


def _on_coarser_mesh(task: Task, fine: Manipulation, there: Manipulation, demand: Demand | None) -> Demand | None:
    """A demand in the numbers of the coarser mesh."""
    if demand is None or demand.standing is None:
        return demand
    larger = larger_on_finer_mesh(task)
    beaten = there.trajectory_length + (demand.standing.expected - fine.trajectory_length) / larger
    return replace(demand, standing=Standing(beaten, demand.standing.gap / larger))


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
