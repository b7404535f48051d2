"""One simulation of a manipulation, scored by the objective C of Eq. (10)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from tatamu.base.errors import SimulationError
from tatamu.evaluation.disturbances import NOMINAL, Scenario, disturbed_hands, disturbed_scene, hand_failure
from tatamu.evaluation.evaluator import Ask, Evaluation, Evaluator
from tatamu.folding.fold import Fold
from tatamu.folding.manipulation import Manipulation
from tatamu.folding.score import ALPHA, score, shape_distance, vertex_distances
from tatamu.folding.task import Task
from tatamu.simulation.simulators import simulate


@dataclass(frozen=True)
class Nominal(Evaluator):
    """Simulates a manipulation with every disturbance at its mean, and scores the outcome."""

    task: Task
    centre: Scenario = NOMINAL
    """The means of the disturbances, which are zero unless folds were measured."""

    contains_length = True

    def __call__(self, ask: Ask | Mapping[str, int | float]) -> Evaluation:
        return self.simulate(Ask.of(ask).parameters, self.centre)

    def on(self, task: Task) -> Nominal:
        return replace(self, task=task)

    def simulate(self, parameters: Mapping[str, int | float], scenario: Scenario) -> Evaluation:
        """Evaluate a manipulation in one scenario."""
        found = self.fixed(self.task.manipulation(parameters), scenario)
        return replace(found, parameters=dict(parameters))

    def fixed(self, manipulation: Manipulation, scenario: Scenario = NOMINAL) -> Evaluation:
        """Evaluate a manipulation that does not come from parameters."""
        fold, length = self.task.fold, manipulation.trajectory_length
        try:
            hands = disturbed_hands(fold, manipulation, scenario)
            if (failure := hand_failure(hands)) is not None:
                return failed(fold, length, failure)
            rollout = simulate(disturbed_scene(fold, manipulation, scenario, hands), self.task.simulator)
        except SimulationError as error:
            return failed(fold, length, str(error))
        final = rollout.positions[-1]
        if _left_table(fold, final):
            return replace(failed(fold, length, "the cloth left the table"), rollout=rollout)
        reached = score(fold, length, final)
        return Evaluation({}, length, reached.objective, reached.objective, reached, rollout=rollout)


def _left_table(fold: Fold, final: np.ndarray) -> bool:
    flat, margin = fold.start[:, :2], 0.5  # width of the table around the cloth's start [m]
    return bool((final[:, :2] < flat.min(0) - margin).any() or (final[:, :2] > flat.max(0) + margin).any())


def failed(fold: Fold, length: float, error: str) -> Evaluation:
    """Return the evaluation of a simulation that failed: alpha D as of twice the distance of untouched cloth."""
    objective = length + 2.0 * ALPHA * shape_distance(vertex_distances(fold.target, fold.start))
    return Evaluation({}, length, objective, objective, None, error)


def unsimulated(task: Task, made: Mapping[str, int | float] | Manipulation, error: str) -> Evaluation:
    """Return the evaluation of parameters, or of a manipulation, that could not be simulated."""
    if isinstance(made, Manipulation):
        return failed(task.fold, made.trajectory_length, error)
    return replace(unsimulated(task, task.manipulation(made), error), parameters=dict(made))


def refuse(task: Task, parameters: Mapping[str, int | float]) -> Evaluation | None:
    """Return a failed evaluation if the task's robot cannot carry out a manipulation; None if it can.

    The objective grows with how far the manipulation is out of reach.
    """
    if task.reach is None or (short := -task.reach.quality(task.manipulation(parameters))) <= 0.0:
        return None
    found = unsimulated(task, parameters, f"out of reach of {task.reach.robot}")
    return replace(found, objective=found.objective + short, nominal=found.nominal + short)
