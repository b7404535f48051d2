"""An evaluator is a function from the parameters of a manipulation to an evaluation: how good the fold is.

    evaluate = CoarseFirst(Disturbed(Nominal(task), disturbances, quantile=0.975))
    evaluate(task.space.middle()).objective

`Nominal` simulates and scores. Wrappers change what is evaluated (`Disturbed`), how (`CoarseFirst`), or what is allowed
(`WithinReach`); a wrapper of your own overrides `__call__`:

    class Gentle(Wrapper):
        def __call__(self, parameters, beat=NOTHING):
            found = self.inner(parameters, beat)
            return replace(found, objective=found.objective + 0.1 * parameters["z1"])

Evaluators are immutable and can be pickled; an evaluation depends on nothing but the arguments.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor, Future
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Literal, Self

import numpy as np

from tatamu.disturbances import World
from tatamu.errors import InputError
from tatamu.folding.score import Score, residuals, vertex_distances
from tatamu.folding.task import Task
from tatamu.rollout import Rollout
from tatamu.search import HIGH, Parameters


@dataclass(frozen=True)
class Evaluation:
    """The result of evaluating the parameters of one manipulation."""

    parameters: Mapping[str, int | float]
    trajectory_length: float
    """l_x of Eq. (10) [m]."""
    objective: float
    """The value that a search minimises."""
    nominal: float
    """C of Eq. (10) without disturbances, or a penalty if the fold failed."""
    score: Score | None
    """All measures without disturbances; None if the fold failed."""
    error: str | None = None
    """Reason of the failure."""
    rollout: Rollout | None = None
    """The motion without disturbances; None if the simulation ended early, or if the motion was not kept."""
    simulations: int = 1
    """Number of simulations."""
    hardest: tuple[int, ...] = ()
    """Numbers of the disturbed worlds that were simulated, hardest first; empty if the evaluation was ended early."""
    fidelity: int = HIGH
    """`LOW` if a coarser mesh was simulated."""
    ended: Literal["arrival"] | None = None
    """"arrival" if the simulation ended at the hands' arrival, because the fold could no longer become the best."""
    seconds: float = 0.0
    """Wall time."""
    errors: np.ndarray | None = None
    """e_i of Eq. (12) [m], shape (n,); None if they were not requested."""

    @property
    def failed(self) -> bool:
        """Whether the simulation failed, so that there is no score."""
        return self.score is None

    @property
    def cost(self) -> float:
        """Difference of the objective from its nominal value, because of disturbances."""
        return self.objective - self.nominal

    @property
    def residuals(self) -> np.ndarray | None:
        """The vector whose squares sum to alpha D of Eq. (10), shape (n,), in single precision as in stored studies."""
        return None if self.errors is None else residuals(self.errors.astype(np.float32).astype(float))


@dataclass(frozen=True)
class Incumbent:
    """The best known evaluation. Another evaluation that cannot beat it may end early, with a worse objective."""

    objective: float = np.inf
    """The lowest objective known."""
    cost: float = 0.0
    """Part of the objective that is due to disturbances."""
    hardest: tuple[int, ...] = ()
    """Numbers of the disturbed worlds in which other evaluations are simulated, hardest first; empty for all worlds."""


NOTHING = Incumbent()
"""No incumbent: every evaluation is complete."""


class Evaluator(ABC):
    """Base of all evaluators."""

    @property
    @abstractmethod
    def task(self) -> Task:
        """The fold that is evaluated."""

    @abstractmethod
    def __call__(self, parameters: Mapping[str, int | float], beat: Incumbent = NOTHING) -> Evaluation:
        """Evaluate a manipulation; a failed simulation is a result, not an exception.

        Args:
            parameters: x1, z1, x2, z2 [m], g1 and g2 of Eq. (9).
            beat: Result to beat; an evaluation that cannot beat it may end early.

        Raises:
            InputError: If a parameter is wrong; the message names it.
        """

    @abstractmethod
    def on(self, task: Task) -> Self:
        """Return the same evaluator for another task."""

    @abstractmethod
    def in_world(self, parameters: Mapping[str, int | float], world: World) -> Evaluation:
        """Evaluate a manipulation in one disturbed world."""

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
        """Whether l_x of Eq. (10) is a part of the objective, so that a search need not learn it."""
        return False

    @property
    def fidelities(self) -> int:
        """2 if the evaluator has a low fidelity as well, otherwise 1."""
        return 1

    @property
    def scouts(self) -> int:
        """Number of first evaluations, which determine the worlds of later ones; later evaluations wait for them."""
        return 0

    def low_fidelity(self, parameters: Mapping[str, int | float]) -> tuple[Evaluator, Parameters] | None:
        """Return the evaluator of low fidelity and the same manipulation's parameters; None with one fidelity."""
        return None

    def incumbent(self, known: Sequence[Evaluation], parameters: Mapping[str, int | float]) -> Incumbent:
        """Return the incumbent that an evaluation has to beat.

        Args:
            known: Evaluations of earlier trials, in order.
            parameters: Parameters of the evaluation.
        """
        return Incumbent(min((each.objective for each in known if not each.failed), default=np.inf))

    def errors(self, evaluation: Evaluation) -> np.ndarray:
        """Return e_i of Eq. (12) [m] on the task's mesh, shape (n,), of an evaluation with a rollout."""
        if evaluation.rollout is None:
            raise InputError("evaluation: must have a rollout")
        return vertex_distances(self.task.fold.target, evaluation.rollout.positions[-1])

    def submit(
        self, executor: Executor, parameters: Mapping[str, int | float], beat: Incumbent, *, keep: bool = False
    ) -> Future[Evaluation]:
        """Evaluate on an executor. A manipulation that is not allowed fails at once, without the executor.

        Args:
            executor: Threads, processes or a cluster.
            parameters: Parameters of the manipulation.
            beat: Result that the evaluation has to beat.
            keep: Return the rollout also if the evaluation does not beat `beat`; otherwise the worker drops such a
                rollout.
        """
        refused = self.refuse(parameters)
        if refused is None:
            return executor.submit(_timed, self, parameters, beat, keep)
        answer: Future[Evaluation] = Future()
        answer.set_result(refused)
        return answer


def _timed(evaluator: Evaluator, parameters: Mapping[str, int | float], beat: Incumbent, keep: bool) -> Evaluation:
    """Evaluate, and measure how long it took."""
    started = perf_counter()
    found = evaluator(parameters, beat)
    rollout = found.rollout if keep or found.objective < beat.objective else None
    return replace(found, rollout=rollout, seconds=perf_counter() - started)


@dataclass(frozen=True)
class Wrapper(Evaluator):
    """Base of evaluators that modify another evaluator; methods that are not overridden call the inner one."""

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
        """Evaluate a manipulation in one disturbed world."""
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
        """2 if the evaluator has a low fidelity as well, otherwise 1."""
        return self.inner.fidelities

    @property
    def scouts(self) -> int:
        """Number of first evaluations for which later evaluations wait."""
        return self.inner.scouts

    def low_fidelity(self, parameters: Mapping[str, int | float]) -> tuple[Evaluator, Parameters] | None:
        """Return the evaluator of low fidelity and the same manipulation's parameters; None with one fidelity."""
        return self.inner.low_fidelity(parameters)

    def incumbent(self, known: Sequence[Evaluation], parameters: Mapping[str, int | float]) -> Incumbent:
        """Return the incumbent that an evaluation has to beat."""
        return self.inner.incumbent(known, parameters)

    def errors(self, evaluation: Evaluation) -> np.ndarray:
        """Return e_i of Eq. (12) [m] on the task's mesh, shape (n,), of an evaluation with a rollout."""
        return self.inner.errors(evaluation)
