"""The evaluation of a trial: a pure function of arguments that can be pickled, which any executor may run anywhere.

What a robot cannot do is not among it: a reach may learn from what it is asked, so it is asked in the order of the
trials, before a trial is handed to the executor.
"""

from __future__ import annotations

from concurrent.futures import Executor, Future
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np

from tatamu.errors import WorkerKilledError
from tatamu.folding.coarser import (
    as_on_finer_mesh,
    larger_on_finer_mesh,
    objective_on_coarser_mesh,
    on_coarser_mesh,
)
from tatamu.folding.manipulation import Manipulation
from tatamu.folding.task import Outcome, Task
from tatamu.learning.expectation import Demand, Expected, Standing, at_least, expected
from tatamu.results.result import Parameters


@dataclass(frozen=True)
class Evaluation:
    """The outcome of a trial, and the time that it took."""

    outcome: Outcome
    """Where nothing is off."""
    seconds: float
    expected: Expected | None = None
    """Over worlds in which something is off; None: nobody asked."""
    on_arrival: bool = False
    """Whether the outcome is that when the hands had arrived, as the trial could no longer win."""

    @property
    def objective(self) -> float:
        """The value that the search minimises: C, or its expectation."""
        return self.outcome.objective if self.expected is None else self.expected.objective


@dataclass(frozen=True)
class Surrogate:
    """A manipulation on a coarser mesh that says what disturbances add to the objective on the finer one."""

    task: Task
    manipulation: Manipulation
    larger: float
    """D on the finer mesh over D on this one."""


def evaluate(
    task: Task,
    manipulation: Manipulation,
    below: float = np.inf,
    demand: Demand | None = None,
    surrogate: Surrogate | None = None,
    beaten: float = np.inf,
) -> Evaluation:
    """Simulate and score one manipulation; the same to the last bit wherever it runs, but for the time.

    Args:
        task: What is folded.
        manipulation: How.
        below: The rollout comes with the outcome where the objective, or the expected one, is less than this: others
            are not kept, and would only be carried from machine to machine.
        demand: Worlds in which it is simulated too; None: in none.
        surrogate: The same on a coarser mesh, where those worlds are simulated; None: on the task's own.
        beaten: What the trial has to beat. Where the objective is no less when the hands have arrived, a trial of a
            task that says so ends there: many layers only come undone afterwards. Not asked with a demand.
    """
    started = perf_counter()
    if task.ends_early and demand is None and beaten < np.inf:
        arrived = task.evaluate_on_arrival(manipulation)
        if arrived.objective >= beaten:
            return Evaluation(replace(arrived, rollout=None), perf_counter() - started, on_arrival=not arrived.failed)
    outcome = task.evaluate(manipulation)
    found = None if demand is None else _expected(task, manipulation, outcome, demand, surrogate)
    if not (outcome.objective if found is None else found.objective) < below:
        outcome = replace(outcome, rollout=None)
    return Evaluation(outcome, perf_counter() - started, found)


def _expected(
    task: Task, manipulation: Manipulation, outcome: Outcome, demand: Demand, surrogate: Surrogate | None
) -> Expected:
    """The expected objective: on a coarser mesh, disturbances add to the objective what they add on the task's own."""
    own = outcome.objective
    standing = demand.standing
    if demand.added is not None and not outcome.failed:
        estimate = Expected(own + demand.added.objective, demand.added.worlds, demand.added.hardest)
        return at_least(task, manipulation, outcome, demand, estimate)
    if surrogate is None or outcome.failed or (standing and own >= standing.expected):
        return expected(task, manipulation, outcome, demand)
    calm = surrogate.task.evaluate(surrogate.manipulation)
    if calm.failed:
        return expected(task, manipulation, outcome, demand)
    there = None
    if standing is not None:
        there = Standing(calm.objective + (standing.expected - own) / surrogate.larger, standing.gap / surrogate.larger)
    found = expected(surrogate.task, surrogate.manipulation, calm, replace(demand, standing=there))
    estimate = replace(found, objective=own + surrogate.larger * (found.objective - calm.objective))
    return at_least(task, manipulation, outcome, demand, estimate)


@dataclass(frozen=True)
class Pending:
    """A trial that is being evaluated."""

    task: Task
    manipulation: Manipulation
    coarse: Manipulation | None
    """The manipulation on the task's coarser mesh, where it runs there."""
    evaluation: Future[Evaluation]
    disturbed: bool = False
    """Whether it is simulated in disturbed worlds too."""

    def ended(self, which: str) -> Evaluation:
        """Wait for a trial, in the numbers of the task's own mesh; one that ended the processes it ran in has failed.

        Args:
            which: Its seed and number, for the error.
        """
        try:
            ended = self.evaluation.result()
        except WorkerKilledError as error:
            penalty = self.task.penalty(self.manipulation.trajectory_length)
            found = Expected(penalty, 0) if self.disturbed else None
            return Evaluation(Outcome(None, penalty, f"{error} ({which})", None), 0.0, found)
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
    below: float = np.inf,
    parameters: Parameters | None = None,
    *,
    coarse: bool = False,
    demand: Demand | None = None,
    beaten: float = np.inf,
) -> Pending:
    """Hand a trial to an executor; one that the task's robot cannot do has ended at once.

    Args:
        executor: Where it runs.
        task: The fold.
        manipulation: What the hands do.
        below: The rollout is wanted where the objective is less than this.
        parameters: Of the manipulation; None: it has none, and runs on the task's own mesh alone.
        coarse: Whether it is to run on the task's coarser mesh.
        demand: Worlds in which it is simulated too; where the task has a coarser mesh, there.
        beaten: The objective that it has to beat on the task's own mesh; where it cannot, it may end early.
    """
    refused = task.refused(manipulation)
    disturbed = demand is not None
    if refused is not None:
        at_once: Future[Evaluation] = Future()
        at_once.set_result(Evaluation(refused, 0.0, Expected(refused.objective, 0) if disturbed else None))
        return Pending(task, manipulation, None, at_once, disturbed)
    if task.coarser is None or parameters is None or not (coarse or disturbed):
        future = executor.submit(evaluate, task.bare, manipulation, below, demand, beaten=beaten)
        return Pending(task, manipulation, None, future, disturbed)
    there = on_coarser_mesh(task, manipulation, parameters)
    coarser = task.coarser.bare
    if coarse:
        beaten = objective_on_coarser_mesh(task, manipulation, there, below)
        meant = _on_coarser_mesh(task, manipulation, there, demand)
        future = executor.submit(evaluate, coarser, there, beaten, meant)
        return Pending(task, manipulation, there, future, disturbed)
    surrogate = Surrogate(coarser, there, larger_on_finer_mesh(task))
    future = executor.submit(evaluate, task.bare, manipulation, below, demand, surrogate)
    return Pending(task, manipulation, None, future, disturbed)


def _on_coarser_mesh(task: Task, fine: Manipulation, there: Manipulation, demand: Demand | None) -> Demand | None:
    """A demand in the numbers of the coarser mesh."""
    if demand is None or demand.standing is None:
        return demand
    beaten = objective_on_coarser_mesh(task, fine, there, demand.standing.expected)
    gap = demand.standing.gap / larger_on_finer_mesh(task)
    return replace(demand, standing=Standing(beaten, gap))
