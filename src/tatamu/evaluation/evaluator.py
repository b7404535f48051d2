"""Evaluators: functions that rate the fold that a manipulation's parameters produce.

    evaluate = CoarseFirst(Disturbed(Nominal(task), disturbances, quantile=0.975))
    evaluate(task.space.middle()).objective

`Nominal` simulates a fold and scores it. Wrappers modify an evaluator. `Disturbed` changes what is evaluated,
`CoarseFirst` how it is evaluated, and `WithinReach` which manipulations are allowed. A wrapper of your own overrides
`__call__`:

    class Gentle(Wrapper):
        def __call__(self, parameters, beat=NOTHING):
            found = self.inner(parameters, beat)
            return replace(found, objective=found.objective + 0.1 * parameters["z1"])

Evaluators are immutable and can be pickled. An evaluation depends only on the arguments.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor, Future
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Literal, Self

import numpy as np

from tatamu.base.errors import InputError
from tatamu.evaluation.disturbances import World
from tatamu.folding.score import Score, residuals, vertex_distances
from tatamu.folding.task import Task
from tatamu.search import HIGH, Parameters
from tatamu.simulation.rollout import Rollout


@dataclass(frozen=True)
class Evaluation:
    """The result of evaluating the parameters of one manipulation."""

    parameters: Mapping[str, int | float]
    trajectory_length: float
    """Trajectory length l_x of Eq. (10) [m]."""
    objective: float
    """The value that a search minimises."""
    nominal: float
    """Objective C of Eq. (10) without disturbances, or a penalty if the fold failed."""
    score: Score | None
    """All measures without disturbances; None if the fold failed."""
    error: str | None = None
    """Reason why the fold failed; None if it did not fail."""
    rollout: Rollout | None = None
    """Motion without disturbances; None if the simulation ended early or the motion was deleted to save memory."""
    simulations: int = 1
    """Number of simulations that the evaluation needed."""
    hardest: tuple[int, ...] = ()
    """Numbers of the disturbed worlds that were simulated, hardest first; empty if the evaluation was ended early.

    A disturbed world is one random draw of all disturbances."""
    failed_in: tuple[int, ...] = ()
    """Numbers of the simulated disturbed worlds in which the fold failed, although another fold succeeds there."""
    fidelity: int = HIGH
    """`LOW` if the coarse mesh was simulated, and `HIGH` if the fine mesh was simulated."""
    ended: Literal["arrival"] | None = None
    """"arrival" if the simulation ended when the hands arrived, because the fold could not become the best.

    None if the simulation did not end early."""
    seconds: float = 0.0
    """Wall time [s]."""
    errors: np.ndarray | None = None
    """Vertex distances e_i of Eq. (12) for the n vertices [m], shape (n,); None if they were not requested."""

    @property
    def failed(self) -> bool:
        """Whether the simulation failed. There is then no score."""
        return self.score is None

    @property
    def cost(self) -> float:
        """Amount by which disturbances change the objective, compared with its value without disturbances."""
        return self.objective - self.nominal

    @property
    def residuals(self) -> np.ndarray | None:
        """Vector whose squares sum to alpha D of Eq. (10), shape (n,), with one number for each vertex.

        It has single precision, as in stored studies.
        """
        return None if self.errors is None else residuals(self.errors.astype(np.float32).astype(float))


@dataclass(frozen=True)
class Incumbent:
    """The incumbent, which is the best known evaluation.

    Another evaluation may end early if it cannot beat the incumbent. The objective of an evaluation that ended early is
    worse than the objective of the incumbent.
    """

    objective: float = np.inf
    """Lowest known objective."""
    cost: float = 0.0
    """Part of the objective that is due to disturbances."""
    hardest: tuple[int, ...] = ()
    """Numbers of the disturbed worlds in which later evaluations are simulated, hardest first.

    The field is empty if later evaluations are simulated in all worlds. A disturbed world is one random draw of all
    disturbances."""


NOTHING = Incumbent()
"""Stands for the absence of an incumbent, the best known evaluation.

Without an incumbent to beat, every evaluation is complete.
"""


class Evaluator(ABC):
    """Base of all evaluators, which rate the fold that a manipulation's parameters produce."""

    @property
    @abstractmethod
    def task(self) -> Task:
        """The fold that is evaluated."""

    @abstractmethod
    def __call__(self, parameters: Mapping[str, int | float], beat: Incumbent = NOTHING) -> Evaluation:
        """Evaluate a manipulation. A failed simulation gives a result and raises no exception.

        Args:
            parameters: The parameters x1, z1, x2, z2 [m], g1 and g2 of Eq. (9).
            beat: The best known evaluation. An evaluation that cannot beat it may end early.

        Raises:
            InputError: If a parameter is wrong. The message names the parameter.
        """

    @abstractmethod
    def on(self, task: Task) -> Self:
        """Return the same evaluator for another task."""

    @abstractmethod
    def in_world(self, parameters: Mapping[str, int | float], world: World) -> Evaluation:
        """Evaluate a manipulation in one world, which is one draw of the disturbances."""

    @abstractmethod
    def fail(self, parameters: Mapping[str, int | float], error: str) -> Evaluation:
        """Return the evaluation of a manipulation that could not be simulated."""

    def refuse(self, parameters: Mapping[str, int | float]) -> Evaluation | None:
        """Return the failed evaluation of a manipulation that is not allowed; None if the manipulation is allowed."""
        return None

    def without_disturbances(self) -> Evaluator:
        """Return the same evaluator without disturbances."""
        return self

    @property
    def contains_length(self) -> bool:
        """Whether the trajectory length l_x of Eq. (10) is a part of the objective.

        A search need not learn this part, because it is known before the simulation.
        """
        return False

    @property
    def fidelities(self) -> int:
        """Number of fidelities: 2 if the evaluator also has a low fidelity, otherwise 1."""
        return 1

    @property
    def scouts(self) -> int:
        """Number of evaluations at the start of a search that find the hardest disturbances for later evaluations.

        Later evaluations wait until these evaluations (scouts) have ended.
        """
        return 0

    def low_fidelity(self, parameters: Mapping[str, int | float]) -> tuple[Evaluator, Parameters] | None:
        """Return the evaluator of low fidelity, and the parameters of the same manipulation for it.

        The result is None if the evaluator has only one fidelity.
        """
        return None

    def incumbent(self, known: Sequence[Evaluation], parameters: Mapping[str, int | float]) -> Incumbent:
        """Return the incumbent that an evaluation has to beat.

        Args:
            known: Evaluations of earlier trials, in the order of the trials.
            parameters: Parameters of the evaluation.
        """
        return Incumbent(min((each.objective for each in known if not each.failed), default=np.inf))

    def errors(self, evaluation: Evaluation) -> np.ndarray:
        """Return the vertex distances e_i of Eq. (12) for the n vertices of the task's mesh [m], shape (n,).

        The evaluation must have a rollout.
        """
        if evaluation.rollout is None:
            raise InputError("evaluation: must have a rollout")
        return vertex_distances(self.task.fold.target, evaluation.rollout.positions[-1])

    def submit(
        self, executor: Executor, parameters: Mapping[str, int | float], beat: Incumbent, *, keep: bool = False
    ) -> Future[Evaluation]:
        """Submit an evaluation to an executor.

        A manipulation that is not allowed fails immediately, without the executor.

        Args:
            executor: Threads, processes or a cluster.
            parameters: Parameters of the manipulation.
            beat: The best known evaluation. An evaluation that cannot beat it may end early.
            keep: Whether to return the rollout of an evaluation that does not beat `beat`. Otherwise the worker deletes
                this rollout.
        """
        refused = self.refuse(parameters)
        if refused is None:
            return executor.submit(_timed, self, parameters, beat, keep)
        answer: Future[Evaluation] = Future()
        answer.set_result(refused)
        return answer


def _timed(evaluator: Evaluator, parameters: Mapping[str, int | float], beat: Incumbent, keep: bool) -> Evaluation:
    """Evaluate a manipulation, and measure the time."""
    started = perf_counter()
    found = evaluator(parameters, beat)
    rollout = found.rollout if keep or found.objective < beat.objective else None
    return replace(found, rollout=rollout, seconds=perf_counter() - started)


@dataclass(frozen=True)
class Wrapper(Evaluator):
    """Base of evaluators that modify an inner evaluator. Methods that are not overridden call the inner evaluator."""

    inner: Evaluator

    @property
    def task(self) -> Task:
        """The fold that is evaluated."""
        return self.inner.task

    def __call__(self, parameters: Mapping[str, int | float], beat: Incumbent = NOTHING) -> Evaluation:
        """Evaluate a manipulation."""
        return self.inner(parameters, beat)

    def on(self, task: Task) -> Self:
        """Return the same evaluator for another task."""
        return replace(self, inner=self.inner.on(task))

    def in_world(self, parameters: Mapping[str, int | float], world: World) -> Evaluation:
        """Evaluate a manipulation in one world, which is one draw of the disturbances."""
        return self.inner.in_world(parameters, world)

    def fail(self, parameters: Mapping[str, int | float], error: str) -> Evaluation:
        """Return the evaluation of a manipulation that could not be simulated."""
        return self.inner.fail(parameters, error)

    def refuse(self, parameters: Mapping[str, int | float]) -> Evaluation | None:
        """Return the failed evaluation of a manipulation that is not allowed; None if the manipulation is allowed."""
        return self.inner.refuse(parameters)

    def without_disturbances(self) -> Evaluator:
        """Return the same evaluator without disturbances."""
        return replace(self, inner=self.inner.without_disturbances())

    @property
    def fidelities(self) -> int:
        """Number of fidelities: 2 if the evaluator also has a low fidelity, otherwise 1."""
        return self.inner.fidelities

    @property
    def scouts(self) -> int:
        """Number of evaluations at the start of a search (scouts) for which all later evaluations wait."""
        return self.inner.scouts

    def low_fidelity(self, parameters: Mapping[str, int | float]) -> tuple[Evaluator, Parameters] | None:
        """Return the evaluator of low fidelity, and the parameters of the same manipulation for it.

        The result is None if the evaluator has only one fidelity.
        """
        return self.inner.low_fidelity(parameters)

    def incumbent(self, known: Sequence[Evaluation], parameters: Mapping[str, int | float]) -> Incumbent:
        """Return the incumbent: the best known evaluation, which a new evaluation has to beat."""
        return self.inner.incumbent(known, parameters)

    def errors(self, evaluation: Evaluation) -> np.ndarray:
        """Return the vertex distances e_i of Eq. (12) for the n vertices of the task's mesh [m], shape (n,).

        The evaluation must have a rollout.
        """
        return self.inner.errors(evaluation)
