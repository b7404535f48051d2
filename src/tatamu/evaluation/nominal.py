"""The nominal evaluator: one simulation without disturbances, scored by the objective C of Eq. (10)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from tatamu.base.errors import SimulationError
from tatamu.evaluation.disturbances import NOMINAL, World, disturbed_scene
from tatamu.evaluation.evaluator import NOTHING, Evaluation, Evaluator, Incumbent
from tatamu.folding.fold import Fold
from tatamu.folding.manipulation import Manipulation
from tatamu.folding.score import ALPHA, score, shape_distance, vertex_distances
from tatamu.folding.task import Task
from tatamu.folding.trial_scene import scene_of
from tatamu.simulation.scene import Scene
from tatamu.simulation.simulators import simulate

TABLE_MARGIN = 0.5
"""Width of the table around the initial position of the cloth [m]. Cloth that ends farther out has left the table."""


@dataclass(frozen=True)
class Nominal(Evaluator):
    """Simulates a manipulation without disturbances, and scores the outcome."""

    subject: Task
    """The fold that is evaluated."""
    ends_early: bool = False
    """Whether to end a simulation when the hands have arrived, if the fold cannot beat the best known fold.

    After the arrival, the layers of a fold can only come undone, so the fold does not become better."""
    centre: World = NOMINAL
    """World that is simulated. A world contains a value of every disturbance, such as an error of a hand's position.

    In this world, every disturbance has its mean value. By default, all means are zero, so nothing is disturbed."""

    @property
    def task(self) -> Task:
        """The fold that is evaluated."""
        return self.subject

    def __call__(self, parameters: Mapping[str, int | float], beat: Incumbent = NOTHING) -> Evaluation:
        """Evaluate a manipulation."""
        manipulation = self.task.manipulation(parameters)
        try:
            scene = disturbed_scene(self.task.fold, manipulation, self.centre)
        except SimulationError as error:
            return self.fail(parameters, str(error))
        if self.ends_early and beat.objective < np.inf:
            until = scene.model_copy(update={"duration": manipulation.timing.arrives})
            arrived = self._evaluate(parameters, manipulation, until)
            if arrived.objective >= beat.objective:
                return replace(arrived, rollout=None, ended=None if arrived.failed else "arrival")
        return self._evaluate(parameters, manipulation, scene)

    @property
    def contains_length(self) -> bool:
        """Whether the trajectory length l_x of Eq. (10) is a part of the objective.

        The result is True, because the objective is C = l_x + alpha D.
        """
        return True

    def on(self, task: Task) -> Nominal:
        """Return the same evaluator for another task."""
        return replace(self, subject=task)

    def in_world(self, parameters: Mapping[str, int | float], world: World) -> Evaluation:
        """Evaluate a manipulation in one world, which is one draw of the disturbances."""
        manipulation = self.task.manipulation(parameters)
        try:
            scene = disturbed_scene(self.task.fold, manipulation, world)
        except SimulationError as error:
            return self.fail(parameters, str(error))
        return self._evaluate(parameters, manipulation, scene)

    def fixed(self, manipulation: Manipulation) -> Evaluation:
        """Evaluate a manipulation that has no parameters, for example with paths that are polylines."""
        return self._evaluate({}, manipulation, scene_of(self.task.fold, manipulation))

    def fail(self, parameters: Mapping[str, int | float], error: str) -> Evaluation:
        """Return the evaluation of a manipulation that could not be simulated."""
        return replace(self.fail_fixed(self.task.manipulation(parameters), error), parameters=dict(parameters))

    def fail_fixed(self, manipulation: Manipulation, error: str) -> Evaluation:
        """Return the evaluation of a manipulation that has no parameters and could not be simulated."""
        return replace(_failed(self.task.fold, {}, manipulation.trajectory_length, error), simulations=0)

    def _evaluate(self, parameters: Mapping[str, int | float], manipulation: Manipulation, scene: Scene) -> Evaluation:
        """Simulate a scene of the evaluated fold, and score the outcome."""
        fold, length = self.task.fold, manipulation.trajectory_length
        try:
            rollout = simulate(scene, self.task.simulator)
        except SimulationError as error:
            return _failed(fold, parameters, length, str(error))
        final = rollout.positions[-1]
        if _left_table(fold, final):
            return replace(_failed(fold, parameters, length, "the cloth left the table"), rollout=rollout)
        reached = score(fold, length, final)
        return Evaluation(dict(parameters), length, reached.objective, reached.objective, reached, rollout=rollout)


def penalty(fold: Fold, trajectory_length: float) -> float:
    """Return the objective of a failed trial.

    The shape distance D of Eq. (11) in this objective is twice the D of untouched cloth.
    """
    untouched = shape_distance(vertex_distances(fold.target, fold.start))
    return trajectory_length + 2.0 * ALPHA * untouched


def _failed(fold: Fold, parameters: Mapping[str, int | float], length: float, error: str) -> Evaluation:
    objective = penalty(fold, length)
    return Evaluation(dict(parameters), length, objective, objective, None, error)


def _left_table(fold: Fold, positions: np.ndarray) -> bool:
    flat = fold.start[:, :2]
    low = flat.min(0) - TABLE_MARGIN
    high = flat.max(0) + TABLE_MARGIN
    return bool((positions[:, :2] < low).any() or (positions[:, :2] > high).any())
